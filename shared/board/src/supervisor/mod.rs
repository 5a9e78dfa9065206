//! Supervisor: the state machine that permits or forbids to drive the motors.
//!
//! All of its transitions are in one table:
//!
//! ```text
//! Boot         --BusReady-->    Idle          Keep
//! Boot         --Tripped-->     Fault         Halt
//! Boot         --ClientCame-->  Passthrough   HandOver
//! Idle         --Arm-->         Armed         Energise
//! Idle         --CheckMotors--> MotorCheck    Energise
//! Idle         --Tripped-->     Fault         Halt
//! Idle         --ClientCame-->  Passthrough   HandOver
//! Idle         --Prepare-->     Boot          Search
//! Idle         --Release-->     Passthrough   HandOver
//! MotorCheck   --MotorsChecked--> Armed       Energise
//! MotorCheck   --Disarm-->      Idle          SwitchOff
//! MotorCheck   --Tripped-->     Fault         Halt
//! Armed        --Drive-->       Running       Energise
//! Armed        --Disarm-->      Idle          SwitchOff
//! Armed        --Tripped-->     Fault         Halt
//! Running      --Park-->        Parking       Keep
//! Running      --SampleLost-->  Degraded      Keep
//! Running      --ZeroTorque-->  Armed         SwitchOff
//! Running      --Disarm-->      Idle          SwitchOff
//! Running      --Tripped-->     Fault         Halt
//! Degraded     --Park-->        Parking       Keep
//! Degraded     --SamplesBack--> Running       Keep
//! Degraded     --ZeroTorque-->  Armed         SwitchOff
//! Degraded     --Disarm-->      Idle          SwitchOff
//! Degraded     --Tripped-->     Fault         Halt
//! Parking      --Drive-->       Running       Keep
//! Parking      --Parked-->      Idle          SwitchOff
//! Parking      --Disarm-->      Idle          SwitchOff
//! Parking      --Tripped-->     Fault         Halt
//! Passthrough  --ClientLeft-->  Boot          Search
//! Passthrough  --Disarm-->      Boot          Search
//! Passthrough  --Tripped-->     Fault         Halt
//! Fault        --ClearFault-->  Boot          Search
//! ```
//!
//! A test compares these lines with the table. Any other event leaves the
//! state unchanged, or is refused.
//!
//! # Contract
//!
//! * A transition is complete when [`apply`](Supervisor::apply) or
//!   [`trip`](Supervisor::trip) returns; its [`Action`] is the caller's to carry out.
//! * The state is a permission, not a command: control loop and sequencer read it in
//!   each tick and each poll, and neither drives a motor by an earlier state.
//! * A corrupted state reads as [`State::Fault`]. The caller looks at
//!   [`is_intact`](Supervisor::is_intact) in each poll, and latches the fault.
//! * The supervisor has no time and no bus. The control loop checks the silence of the
//!   host, and the sequencer collects the evidence that motors are off.
//!
//! # Paths to a driven motor
//!
//! Motors are driven for the host in [`State::Running`] and [`State::Degraded`] alone, and by the
//! board itself in [`State::Parking`], which follows on these; the path
//! leads through [`State::Armed`], which only a command of the host enters: by way of
//! [`State::MotorCheck`], unless the motors have been checked since bring-up and the last
//! change of the calibration. A
//! fault leads back through bring-up, which begins with the stop sequence.
//!
//! The bus is lent to a client of the transparent port only while torque is off and no
//! fault is latched; with torque on, its packets are served in the slack of the ticks.
//! A client's changes to the servos are not known, so the path back leads through bring-up.
//!
//! # Example
//!
//! ```
//! use armbridge_board::supervisor::{Action, Event, State, Supervisor, next};
//! use armbridge_link::message::Refusal;
//! use armbridge_link::record::Permission;
//!
//! let mut supervisor = Supervisor::default();
//! assert_eq!(supervisor.apply(Event::Arm), Err(Refusal::NotReady));
//! assert_eq!(supervisor.apply(Event::BusReady), Ok(Action::Keep));
//! assert_eq!(supervisor.apply(Event::Drive), Err(Refusal::Disarmed));
//! assert_eq!(supervisor.apply(Event::Arm), Ok(Action::Energise));
//! assert_eq!(supervisor.apply(Event::Drive), Ok(Action::Energise));
//! assert_eq!(supervisor.permission(), Permission::Drive);
//!
//! // The same table without a state of its own.
//! assert_eq!(next(State::Running, Event::Tripped), Ok((State::Fault, Action::Halt)));
//! assert_eq!(next(State::Fault, Event::Arm), Err(Refusal::Faulted));
//! assert_eq!(next(State::Fault, Event::ClearFault), Ok((State::Boot, Action::Search)));
//! ```

mod table;

pub use table::{Action, Event, State, next};

use armbridge_control::check_word::CodeTable;
use armbridge_link::message::{Drive, Fault, Mode, Refusal, Trip};
use armbridge_link::record::Permission;
use table::STATES;

/// The state, as an error-detecting code word, and the cause of a fault.
///
/// The words of any two states differ in 12 bits at least, so that fewer flipped
/// bits never turn one into another: an invalid word is a fault.
#[derive(Clone, Debug)]
pub struct Supervisor {
    word: u32,
    trip: Option<Trip>,
}

/// Code words: Walsh functions, with the index of the state in the last four bits.
const WORDS: [(State, u32); STATES.len()] = [
    (State::Boot, 0x5555_5550),
    (State::Idle, 0x3333_3331),
    (State::Armed, 0x6666_6662),
    (State::Running, 0x0F0F_0F03),
    (State::Degraded, 0x5A5A_5A54),
    (State::Passthrough, 0x3C3C_3C35),
    (State::Fault, 0x6969_6966),
    (State::MotorCheck, 0x00FF_00F7),
    (State::Parking, 0x55AA_55A8),
];

const CODES: CodeTable<State> = CodeTable::new(&WORDS);

impl Default for Supervisor {
    fn default() -> Self {
        Self {
            word: State::Boot.word(),
            trip: None,
        }
    }
}

impl Supervisor {
    /// The state; [`State::Fault`] if the word is invalid.
    pub fn state(&self) -> State {
        CODES.decode(self.word).unwrap_or(State::Fault)
    }

    /// Whether the word is valid.
    pub fn is_intact(&self) -> bool {
        CODES.decode(self.word).is_some()
    }

    /// Permission for bus and control loop.
    #[inline]
    pub fn permission(&self) -> Permission {
        match self.state() {
            State::Boot => Permission::Search,
            State::Passthrough => Permission::Passthrough,
            State::Idle | State::Fault => Permission::Off,
            State::MotorCheck => Permission::MotorCheck,
            State::Armed => Permission::Armed,
            State::Running | State::Degraded => Permission::Drive,
            State::Parking => Permission::Park,
        }
    }

    /// Checks whether `event` would be accepted.
    ///
    /// # Errors
    /// The refusal for the host.
    pub fn check(&self, event: Event) -> Result<(), Refusal> {
        next(self.state(), event).map(|_| ())
    }

    /// Applies `event`, and returns the action.
    ///
    /// # Errors
    /// The refusal for the host; the state is unchanged.
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

    /// Cause of the fault, if one is latched.
    pub fn cause(&self) -> Option<Trip> {
        self.trip.filter(|_| self.state() == State::Fault)
    }

    /// The fault, if one is latched; one without a cause is a memory fault.
    pub fn fault(&self) -> Option<Fault> {
        let cause = || self.trip.map_or(Fault::Corrupted, |trip| trip.fault);
        (self.state() == State::Fault).then(cause)
    }

    /// The mode, with the source that drives the motors.
    pub fn mode(&self, drive: Drive) -> Mode {
        match self.state() {
            State::Boot => Mode::Boot,
            State::Idle => Mode::Idle,
            State::MotorCheck => Mode::MotorCheck,
            State::Armed => Mode::Armed,
            State::Running => Mode::Running(drive),
            State::Parking => Mode::Running(Drive::Park),
            State::Degraded => Mode::Degraded(drive),
            State::Passthrough => Mode::Passthrough,
            State::Fault => Mode::Fault(self.fault().unwrap_or(Fault::Corrupted)),
        }
    }

    /// Turns a bit of the word, for tests.
    pub fn inject_error(&mut self, bit: u32) {
        self.word ^= 1 << (bit % u32::BITS);
    }
}

impl State {
    const fn word(self) -> u32 {
        match self {
            Self::Boot => WORDS[0].1,
            Self::Idle => WORDS[1].1,
            Self::Armed => WORDS[2].1,
            Self::Running => WORDS[3].1,
            Self::Degraded => WORDS[4].1,
            Self::Passthrough => WORDS[5].1,
            Self::Fault => WORDS[6].1,
            Self::MotorCheck => WORDS[7].1,
            Self::Parking => WORDS[8].1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
