//! Supervisor: who may drive the motors now, and which state follows which event.
//!
//! The whole of it is one table:
//!
//! ```text
//! Boot         --BusReady-->    Idle          Keep
//! Boot         --Tripped-->     Fault         Halt
//! Boot         --ClientCame-->  Passthrough   HandOver
//! Idle         --Arm-->         Armed         Energise
//! Idle         --Tripped-->     Fault         Halt
//! Idle         --ClientCame-->  Passthrough   HandOver
//! Idle         --Prepare-->     Boot          Search
//! Idle         --Release-->     Passthrough   HandOver
//! Armed        --Drive-->       Running       Energise
//! Armed        --Disarm-->      Idle          SwitchOff
//! Armed        --Tripped-->     Fault         Halt
//! Running      --SampleLost-->  Degraded      Keep
//! Running      --Slacken-->     Armed         SwitchOff
//! Running      --Disarm-->      Idle          SwitchOff
//! Running      --Tripped-->     Fault         Halt
//! Degraded     --SamplesBack--> Running       Keep
//! Degraded     --Slacken-->     Armed         SwitchOff
//! Degraded     --Disarm-->      Idle          SwitchOff
//! Degraded     --Tripped-->     Fault         Halt
//! Passthrough  --ClientLeft-->  Boot          Search    
//! Passthrough  --Disarm-->      Boot          Search    
//! Passthrough  --Tripped-->     Fault         Halt
//! Fault        --ClearFault-->  Boot          Search
//! ```
//!
//! A test compares these lines with the table. What is not among them leaves the
//! state as it is, or is refused.
//!
//! Motors are driven in [`State::Running`] and [`State::Degraded`] alone; the way
//! there leads through [`State::Armed`], and there only by the host's word. A
//! fault leads back through bring-up, which begins with the stop sequence.
//!
//! A client of the transparent port is given the bus only while torque is off
//! and no fault is latched; with torque on, its packets are served in the slack
//! of the ticks. What it did to the servos is not known, so the way back leads
//! through bring-up.

use crate::control_loop::Permission;
use crate::link::message::{Drive, Fault, Mode, Refusal, Trip};

/// What the bridge is in, apart from what drives the motors and which fault it
/// is: see [`Mode`](crate::link::message::Mode).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// Servos are being found.
    Boot,
    /// Disarmed, reading.
    Idle,
    /// Ready, with zero torque.
    Armed,
    /// The motors are driven.
    Running,
    /// The same, with a sample missing.
    Degraded,
    /// The bus is the client's of the transparent port.
    Passthrough,
    /// Motors off, latched.
    Fault,
}

/// What can happen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// All servos answer and are lined up.
    BusReady,
    /// Something is in doubt.
    Tripped,
    /// A joint's sample is missing.
    SampleLost,
    /// All samples have come.
    SamplesBack,
    /// The host is quiet while the arm follows, or an experiment is over: brake and
    /// hold.
    Brake,
    /// The host is quiet while torque is constant: none from now on.
    Slacken,
    /// A client speaks on the transparent port.
    ClientCame,
    /// It has closed that port.
    ClientLeft,
    /// The host wants torque off, or leaves.
    Disarm,
    /// The host wants to move the arm soon.
    Arm,
    /// The host wants a torque, a setpoint or a motion.
    Drive,
    /// The host replaces the set-up.
    Configure,
    /// The host replaces limits, or has settings saved.
    Keep,
    /// The host wants stock servos ready for torque.
    Prepare,
    /// The host leaves the bus to the transparent port.
    Release,
    /// The host has seen to the fault.
    ClearFault,
}

/// What a transition does beside changing the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Nothing.
    Keep,
    /// Motors off with the next tick.
    SwitchOff,
    /// The estimator begins at rest where the arm is, and the guard anew.
    Energise,
    /// The reference comes to rest.
    Hold,
    /// The stop sequence, again and again until every motor is seen to be off.
    Halt,
    /// The stop sequence, then bring-up.
    Search,
    /// The stop sequence; the bus is the client's then.
    HandOver,
}

/// A cell of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Cell {
    /// To this state, by this action.
    Go(State, Action),
    /// Nothing changes.
    Stay,
    /// Nothing changes, and the host is told why.
    No(Refusal),
}

const STATES: [State; 7] = [
    State::Boot,
    State::Idle,
    State::Armed,
    State::Running,
    State::Degraded,
    State::Passthrough,
    State::Fault,
];

const EVENTS: usize = Event::ClearFault as usize + 1;

/// A row an event, a column a state, both in the order in which they are declared.
const TABLE: [[Cell; STATES.len()]; EVENTS] = {
    use Action::{Energise, Halt, HandOver, Hold, Keep, Search as Find, SwitchOff as Off};
    use Cell::{Go, No, Stay};
    use Refusal::{Disarmed, Faulted, NotIdle, NotReady};
    use State::{Armed, Boot, Degraded, Fault, Idle, Passthrough as Pass, Running};
    const BUS: Refusal = Refusal::Passthrough;
    #[rustfmt::skip]
    let table = [
        // Boot             Idle                Armed            Running             Degraded             Passthrough          Fault
        [Go(Idle, Keep),     Stay,               Stay,            Stay,               Stay,                Stay,                Stay],             // BusReady
        // The first cause stays: what follows it is often its consequence.
        [Go(Fault, Halt),    Go(Fault, Halt),    Go(Fault, Halt), Go(Fault, Halt),    Go(Fault, Halt),     Go(Fault, Halt),     Stay],             // Tripped
        [Stay,               Stay,               Stay,            Go(Degraded, Keep), Stay,                Stay,                Stay],             // SampleLost
        [Stay,               Stay,               Stay,            Stay,               Go(Running, Keep),   Stay,                Stay],             // SamplesBack
        [Stay,               Stay,               Stay,            Go(Running, Hold),  Go(Degraded, Hold),  Stay,                Stay],             // Brake
        [Stay,               Stay,               Stay,            Go(Armed, Off),     Go(Armed, Off),      Stay,                Stay],             // Slacken
        [Go(Pass, HandOver), Go(Pass, HandOver), Stay,            Stay,               Stay,                Stay,                Stay],             // ClientCame
        [Stay,               Stay,               Stay,            Stay,               Stay,                Go(Boot, Find),  Stay],             // ClientLeft
        // Where torque is off already there is nothing to refuse, nothing to leave.
        [Stay,               Stay,               Go(Idle, Off),   Go(Idle, Off),      Go(Idle, Off),       Go(Boot, Find),  Stay],             // Disarm
        [No(NotReady),       Go(Armed, Energise),Stay,            Stay,               Stay,                No(BUS),             No(Faulted)],      // Arm
        [No(NotReady),       No(Disarmed),       Go(Running, Energise), Stay,         Stay,                No(BUS),             No(Faulted)],      // Drive
        [Stay,               Stay,               Stay,            Stay,               Stay,                Stay,                No(Faulted)],      // Configure
        [Stay,               Stay,               No(NotIdle),     No(NotIdle),        No(NotIdle),         Stay,                No(Faulted)],      // Keep
        [No(NotReady),       Go(Boot, Find),     No(NotIdle),     No(NotIdle),        No(NotIdle),         No(BUS),             No(Faulted)],      // Prepare
        [No(NotReady),       Go(Pass, HandOver), No(NotIdle),     No(NotIdle),        No(NotIdle),         Stay,                No(Faulted)],      // Release
        [Stay,               Stay,               Stay,            Stay,               Stay,                Stay,                Go(Boot, Find)],   // ClearFault
    ];
    table
};

/// The state after `event`, and what is to be done.
///
/// # Errors
/// The refusal that the host is told; the state stays as it is.
pub fn next(state: State, event: Event) -> Result<(State, Action), Refusal> {
    let row = TABLE.get(event as usize);
    match row.and_then(|row| row.get(state as usize)) {
        Some(Cell::Go(state, action)) => Ok((*state, *action)),
        Some(Cell::No(refusal)) => Err(*refusal),
        // Every pair is in the table.
        Some(Cell::Stay) | None => Ok((state, Action::Keep)),
    }
}

/// The state, kept as a word that is hard to corrupt, and the cause of a fault.
///
/// The words of any two states differ in 12 bits at least, so that no flip of fewer
/// turns one into another: anything that is no state's word is a fault.
#[derive(Clone, Debug)]
pub struct Supervisor {
    word: u32,
    trip: Option<Trip>,
}

/// Walsh functions, in the order of [`STATES`]; the last three bits are a state's
/// number, by which it is found.
const WORDS: [u32; STATES.len()] = [
    0x5555_5550,
    0x3333_3331,
    0x6666_6662,
    0x0F0F_0F0B,
    0x5A5A_5A5C,
    0x3C3C_3C3D,
    0x6969_696E,
];
const NUMBER: u32 = 0b111;

impl Default for Supervisor {
    fn default() -> Self {
        Self {
            word: State::Boot.word(),
            trip: None,
        }
    }
}

impl Supervisor {
    /// The state; [`State::Fault`] if the word is none's.
    pub fn state(&self) -> State {
        let number = (self.word & NUMBER) as usize;
        match (STATES.get(number), WORDS.get(number)) {
            (Some(state), Some(word)) if *word == self.word => *state,
            _ => State::Fault,
        }
    }

    /// Whether the word is a state's.
    pub fn is_intact(&self) -> bool {
        self.state().word() == self.word
    }

    /// What a tick may do now.
    pub fn permission(&self) -> Permission {
        match self.state() {
            State::Boot => Permission::Unmonitored,
            State::Idle | State::Passthrough | State::Fault => Permission::Off,
            State::Armed => Permission::Armed,
            State::Running | State::Degraded => Permission::Drive,
        }
    }

    /// Whether `event` would be taken.
    ///
    /// # Errors
    /// The refusal that the host is told.
    pub fn check(&self, event: Event) -> Result<(), Refusal> {
        next(self.state(), event).map(|_| ())
    }

    /// Takes `event`: says what is to be done.
    ///
    /// # Errors
    /// The refusal that the host is told; the state stays as it is.
    pub fn apply(&mut self, event: Event) -> Result<Action, Refusal> {
        let before = self.state();
        let (state, action) = next(before, event)?;
        self.word = state.word();
        if before == State::Fault && state != before {
            self.trip = None;
        }
        Ok(action)
    }

    /// Latches a fault with its first cause. `None` if there was one already.
    pub fn trip(&mut self, trip: Trip) -> Option<Action> {
        if self.state() == State::Fault && self.is_intact() {
            return None;
        }
        self.trip = Some(trip);
        self.word = State::Fault.word();
        Some(Action::Halt)
    }

    /// Why there is a fault, if there is one.
    pub fn cause(&self) -> Option<Trip> {
        self.trip.filter(|_| self.state() == State::Fault)
    }

    /// The mode, for a loop that is driven by this while it is driven.
    pub fn mode(&self, drive: Drive) -> Mode {
        match self.state() {
            State::Boot => Mode::Boot,
            State::Idle => Mode::Idle,
            State::Armed => Mode::Armed,
            State::Running => Mode::Running(drive),
            State::Degraded => Mode::Degraded(drive),
            State::Passthrough => Mode::Passthrough,
            // A fault without a cause is one of the memory.
            State::Fault => Mode::Fault(self.trip.map_or(Fault::Corrupted, |trip| trip.fault)),
        }
    }

    /// The state is that of a recorded tick, whatever it was.
    pub fn resume(&mut self, mode: Mode, trip: Option<Trip>) {
        let state = match mode {
            Mode::Boot => State::Boot,
            Mode::Idle => State::Idle,
            Mode::Armed => State::Armed,
            Mode::Running(_) => State::Running,
            Mode::Degraded(_) => State::Degraded,
            Mode::Passthrough => State::Passthrough,
            Mode::Fault(_) => State::Fault,
        };
        (self.word, self.trip) = (state.word(), trip);
    }

    /// Turns a bit of the word: for tests of what becomes of it.
    pub fn inject_error(&mut self, bit: u32) {
        self.word ^= 1 << (bit % u32::BITS);
    }
}

impl State {
    const fn word(self) -> u32 {
        match self {
            Self::Boot => WORDS[0],
            Self::Idle => WORDS[1],
            Self::Armed => WORDS[2],
            Self::Running => WORDS[3],
            Self::Degraded => WORDS[4],
            Self::Passthrough => WORDS[5],
            Self::Fault => WORDS[6],
        }
    }

    /// Whether the motors may be driven, or soon will be.
    pub const fn is_armed(self) -> bool {
        match self {
            Self::Armed | Self::Running | Self::Degraded => true,
            Self::Boot | Self::Idle | Self::Passthrough | Self::Fault => false,
        }
    }

    /// Whether the motors are driven.
    pub const fn is_driven(self) -> bool {
        matches!(self, Self::Running | Self::Degraded)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;
    use std::string::{String, ToString};
    use std::vec::Vec;
    use std::{format, vec};

    const EVENTS: [Event; super::EVENTS] = [
        Event::BusReady,
        Event::Tripped,
        Event::SampleLost,
        Event::SamplesBack,
        Event::Brake,
        Event::Slacken,
        Event::ClientCame,
        Event::ClientLeft,
        Event::Disarm,
        Event::Arm,
        Event::Drive,
        Event::Configure,
        Event::Keep,
        Event::Prepare,
        Event::Release,
        Event::ClearFault,
    ];

    fn pairs() -> impl Iterator<Item = (State, Event)> {
        STATES
            .into_iter()
            .flat_map(|state| EVENTS.into_iter().map(move |event| (state, event)))
    }

    /// No flip of fewer than 12 bits makes one state of another, and each is found.
    #[test]
    fn words_of_states_are_far_apart() {
        for (index, state) in STATES.into_iter().enumerate() {
            for other in STATES.into_iter().skip(index + 1) {
                assert!((state.word() ^ other.word()).count_ones() >= 12);
            }
            let supervisor = Supervisor {
                word: state.word(),
                trip: None,
            };
            assert_eq!((supervisor.state(), supervisor.is_intact()), (state, true));
        }
    }

    /// The diagram has every change of state, and nothing else.
    #[test]
    fn the_diagram_is_the_table() {
        let of_table = pairs().filter_map(|(state, event)| match next(state, event) {
            Ok((then, action)) if then != state => {
                Some(format!("{state:?} --{event:?}--> {then:?} {action:?}"))
            }
            _ => None,
        });
        let mut of_table: Vec<String> = of_table.collect();
        let lines = include_str!("supervisor.rs").lines();
        let lines = lines.filter_map(|line| line.strip_prefix("//! "));
        let mut of_diagram: Vec<String> = lines
            .filter(|line| line.contains("-->"))
            .map(|line| line.split_whitespace().collect::<Vec<_>>().join(" "))
            .collect();
        of_table.sort();
        of_diagram.sort();
        assert_eq!(of_diagram, of_table);
    }

    /// What must hold whatever else the table says, pair by pair.
    #[test]
    fn every_pair_is_safe() {
        for (state, event) in pairs() {
            let pair = format!("{state:?} on {event:?}");
            let result = next(state, event);
            let (then, action) = result.unwrap_or((state, Action::Keep));
            if event == Event::Tripped {
                assert_eq!(then, State::Fault, "{pair}");
            }
            if event == Event::Disarm {
                assert!(!then.is_armed(), "{pair}");
            }
            if then.is_armed() && !state.is_armed() {
                assert_eq!((state, event), (State::Idle, Event::Arm), "{pair}");
                assert_eq!(action, Action::Energise, "{pair}");
            }
            if then.is_driven() && !state.is_driven() {
                assert_eq!((state, event), (State::Armed, Event::Drive), "{pair}");
                assert_eq!(action, Action::Energise, "{pair}");
            }
            if state == State::Fault && then != State::Fault {
                assert_eq!((then, event), (State::Boot, Event::ClearFault), "{pair}");
            }
            if state.is_driven() && !then.is_driven() {
                assert!(matches!(action, Action::SwitchOff | Action::Halt), "{pair}");
            }
            // Bring-up begins with the stop sequence, and so does a client's turn.
            if then != state && matches!(then, State::Boot | State::Passthrough) {
                let stops = [Action::Search, Action::HandOver];
                assert!(stops.contains(&action), "{pair}");
            }
            if result.is_err() {
                assert!(event as usize >= Event::Disarm as usize, "{pair}");
            }
        }
    }

    /// What the host is told, written out independently of the table.
    #[test]
    fn refusals_name_what_is_missing() {
        let asks = [
            Event::Arm,
            Event::Drive,
            Event::Configure,
            Event::Keep,
            Event::Prepare,
            Event::Release,
        ];
        let told = |state| {
            let letters = asks.map(|event| match next(state, event) {
                Ok(_) => '.',
                Err(Refusal::NotReady) => 'r',
                Err(Refusal::Disarmed) => 'd',
                Err(Refusal::NotIdle) => 'i',
                Err(Refusal::Passthrough) => 'p',
                Err(Refusal::Faulted) => 'f',
                Err(_) => '?',
            });
            letters.iter().collect::<String>()
        };
        let expected = vec![
            "rr..rr".to_string(), // Boot
            ".d....".to_string(), // Idle
            "...iii".to_string(), // Armed
            "...iii".to_string(), // Running
            "...iii".to_string(), // Degraded
            "pp..p.".to_string(), // Passthrough
            "ffffff".to_string(), // Fault
        ];
        assert_eq!(STATES.map(told).to_vec(), expected);
    }
}
