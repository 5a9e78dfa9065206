//! The supervisor's table: states, events, and the transition of every pair.

use armbridge_link::message::Refusal;

/// A state of the bridge, without the drive and the fault that a
/// [`Mode`](armbridge_link::message::Mode) names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// The search for the servos is under way.
    Boot,
    /// Disarmed; angles are read.
    Idle,
    /// Armed, with zero torque.
    Armed,
    /// The motors are driven.
    Running,
    /// The motors are driven, with a sample missing.
    Degraded,
    /// The bus is lent to the client of the transparent port.
    Passthrough,
    /// Motors off, latched.
    Fault,
    /// The motors are checked, before the first command.
    MotorCheck,
    /// The board parks the arm: the motors are driven, without the host.
    Parking,
}

/// An event, from the bus, the control loop, the host or a client.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// All servos have been found and set up.
    BusReady,
    /// A fault has been detected.
    Tripped,
    /// A joint's sample is missing.
    SampleLost,
    /// All samples have been received.
    SamplesBack,
    /// The host is silent while the arm follows a reference, or an experiment has ended:
    /// brake and hold.
    Brake,
    /// The host is silent while torque is constant: zero torque.
    ZeroTorque,
    /// The host has the arm parked, leaves it or is silent, its command has expired, or a servo is
    /// nearly too hot: park the arm, which has a pose for it.
    Park,
    /// The arm has been parked.
    Parked,
    /// A client sends on the transparent port.
    ClientCame,
    /// The client has closed the port.
    ClientLeft,
    /// The host disarms, or leaves.
    Disarm,
    /// The host arms.
    Arm,
    /// The host arms, and the motors have not been checked.
    CheckMotors,
    /// The motors have been checked.
    MotorsChecked,
    /// The host commands a torque, a setpoint or a motion.
    Drive,
    /// The host replaces the set-up.
    Configure,
    /// The host replaces limits, or has settings saved.
    Keep,
    /// The host prepares stock servos for torque.
    Prepare,
    /// The host leaves the bus to the transparent port.
    Release,
    /// The host clears the fault.
    ClearFault,
}

/// The action of a transition, beside the change of state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// No action.
    Keep,
    /// Motors off with the next tick.
    SwitchOff,
    /// Motors that have to be off are commanded off again, and read back.
    Repeat,
    /// Motors off with the next tick; the control loop has restarted estimator and monitors, see
    /// [`ControlLoop::energise`](crate::tick::ControlLoop::energise).
    Energise,
    /// The reference brakes to rest.
    Hold,
    /// The stop sequence, repeated until every motor is confirmed off.
    Halt,
    /// The stop sequence, then bring-up.
    Search,
    /// The stop sequence; then the bus is lent to the client.
    HandOver,
}

/// A cell of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Cell {
    /// Transition to this state, with this action.
    Go(State, Action),
    /// The event has no effect.
    Stay,
    /// The event is refused; the refusal goes to the host.
    No(Refusal),
}

pub(super) const STATES: [State; 9] = [
    State::Boot,
    State::Idle,
    State::Armed,
    State::Running,
    State::Degraded,
    State::Passthrough,
    State::Fault,
    State::MotorCheck,
    State::Parking,
];

const EVENTS: usize = Event::ClearFault as usize + 1;

/// Rows are events, columns states, both in the order of their declaration.
const TABLE: [[Cell; STATES.len()]; EVENTS] = {
    use Action::{Energise, Halt, HandOver, Hold, Keep, Repeat, Search as Find, SwitchOff as Off};
    use Cell::{Go, No, Stay};
    use Refusal::{Busy, Disarmed, Faulted, NotIdle, NotReady};
    use State::{
        Armed, Boot, Degraded, Fault, Idle, MotorCheck as Check, Parking, Passthrough as Pass,
        Running,
    };
    const BUS: Refusal = Refusal::Passthrough;
    #[rustfmt::skip]
    let table = [
        //                   Boot                Idle                   Armed                  Running             Degraded            Passthrough      Fault            MotorCheck           Parking
        /* BusReady      */ [Go(Idle, Keep),     Stay,                  Stay,                  Stay,               Stay,               Stay,            Stay,            Stay,                Stay],
        // The first cause is kept: later ones are often its consequence.
        /* Tripped       */ [Go(Fault, Halt),    Go(Fault, Halt),       Go(Fault, Halt),       Go(Fault, Halt),    Go(Fault, Halt),    Go(Fault, Halt), Stay,            Go(Fault, Halt),     Go(Fault, Halt)],
        /* SampleLost    */ [Stay,               Stay,                  Stay,                  Go(Degraded, Keep), Stay,               Stay,            Stay,            Stay,                Stay],
        /* SamplesBack   */ [Stay,               Stay,                  Stay,                  Stay,               Go(Running, Keep),  Stay,            Stay,            Stay,                Stay],
        /* Brake         */ [Stay,               Stay,                  Stay,                  Go(Running, Hold),  Go(Degraded, Hold), Stay,            Stay,            Stay,                Stay],
        /* ZeroTorque    */ [Stay,               Stay,                  Stay,                  Go(Armed, Off),     Go(Armed, Off),     Stay,            Stay,            Stay,                Stay],
        /* Park          */ [Stay,               Stay,                  Stay,                  Go(Parking, Keep),  Go(Parking, Keep),  Stay,            Stay,            Stay,                Stay],
        /* Parked        */ [Stay,               Stay,                  Stay,                  Stay,               Stay,               Stay,            Stay,            Stay,                Go(Idle, Off)],
        /* ClientCame    */ [Go(Pass, HandOver), Go(Pass, HandOver),    Stay,                  Stay,               Stay,               Stay,            Stay,            Stay,                Stay],
        /* ClientLeft    */ [Stay,               Stay,                  Stay,                  Stay,               Stay,               Go(Boot, Find),  Stay,            Stay,                Stay],
        // Torque that is off already may have been set on by another master on the bus.
        /* Disarm        */ [Stay,               Go(Idle, Repeat),      Go(Idle, Off),         Go(Idle, Off),      Go(Idle, Off),      Go(Boot, Find),  Go(Fault, Repeat), Go(Idle, Off),     Go(Idle, Off)],
        /* Arm           */ [No(NotReady),       Go(Armed, Energise),   Stay,                  Stay,               Stay,               No(BUS),         No(Faulted),     Stay,                Stay],
        /* CheckMotors   */ [No(NotReady),       Go(Check, Energise),   Stay,                  Stay,               Stay,               No(BUS),         No(Faulted),     Stay,                Stay],
        /* MotorsChecked */ [Stay,               Stay,                  Stay,                  Stay,               Stay,               Stay,            Stay,            Go(Armed, Energise), Stay],
        /* Drive         */ [No(NotReady),       No(Disarmed),          Go(Running, Energise), Stay,               Stay,               No(BUS),         No(Faulted),     No(Busy),            Go(Running, Keep)],
        /* Configure     */ [Stay,               Stay,                  Stay,                  Stay,               Stay,               Stay,            No(Faulted),     No(Busy),            Stay],
        /* Keep          */ [Stay,               Stay,                  No(NotIdle),           No(NotIdle),        No(NotIdle),        Stay,            No(Faulted),     No(NotIdle),         No(NotIdle)],
        /* Prepare       */ [No(NotReady),       Go(Boot, Find),        No(NotIdle),           No(NotIdle),        No(NotIdle),        No(BUS),         No(Faulted),     No(NotIdle),         No(NotIdle)],
        /* Release       */ [No(NotReady),       Go(Pass, HandOver),    No(NotIdle),           No(NotIdle),        No(NotIdle),        Stay,            No(Faulted),     No(NotIdle),         No(NotIdle)],
        /* ClearFault    */ [Stay,               Stay,                  Stay,                  Stay,               Stay,               Stay,            Go(Boot, Find),  Stay,                Stay],
    ];
    table
};

/// The state after `event`, and the action.
///
/// # Errors
/// The refusal for the host; the state is unchanged.
pub fn next(state: State, event: Event) -> Result<(State, Action), Refusal> {
    let row = TABLE.get(event as usize);
    match row.and_then(|row| row.get(state as usize)) {
        Some(Cell::Go(state, action)) => Ok((*state, *action)),
        Some(Cell::No(refusal)) => Err(*refusal),
        // Every pair is in the table.
        Some(Cell::Stay) | None => Ok((state, Action::Keep)),
    }
}

impl State {
    /// Whether the motors may be driven, or soon will be.
    pub const fn is_armed(self) -> bool {
        match self {
            Self::MotorCheck | Self::Armed | Self::Running | Self::Degraded | Self::Parking => true,
            Self::Boot | Self::Idle | Self::Passthrough | Self::Fault => false,
        }
    }

    /// Whether the motors are driven, for the host or to park the arm.
    pub const fn is_driven(self) -> bool {
        matches!(self, Self::Running | Self::Degraded | Self::Parking)
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
        Event::ZeroTorque,
        Event::Park,
        Event::Parked,
        Event::ClientCame,
        Event::ClientLeft,
        Event::Disarm,
        Event::Arm,
        Event::CheckMotors,
        Event::MotorsChecked,
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
        let lines = include_str!("mod.rs").lines();
        let lines = lines.filter_map(|line| line.strip_prefix("//! "));
        let mut of_diagram: Vec<String> = lines
            .filter(|line| line.contains("-->"))
            .map(|line| line.split_whitespace().collect::<Vec<_>>().join(" "))
            .collect();
        of_table.sort();
        of_diagram.sort();
        assert_eq!(of_diagram, of_table);
    }

    /// Properties of the table, pair by pair.
    #[test]
    fn every_pair_is_safe() {
        for (state, event) in pairs() {
            let pair = format!("{state:?} on {event:?}");
            let result = next(state, event);
            let (then, action) = result.unwrap_or((state, Action::Keep));
            if event == Event::Tripped {
                assert_eq!(then, State::Fault, "{pair}");
            }
            // The core passes these on in no other state.
            if matches!(event, Event::SampleLost | Event::SamplesBack) && then != state {
                let changes = [
                    (State::Running, Event::SampleLost),
                    (State::Degraded, Event::SamplesBack),
                ];
                assert!(changes.contains(&(state, event)), "{pair}");
            }
            if event == Event::Disarm {
                assert!(!then.is_armed(), "{pair}");
                // Bring-up begins with the stop sequence anyway.
                assert!(state == State::Boot || action != Action::Keep, "{pair}");
            }
            if then.is_armed() && !state.is_armed() {
                assert_eq!(state, State::Idle, "{pair}");
                assert!(matches!(event, Event::Arm | Event::CheckMotors), "{pair}");
                assert_eq!(action, Action::Energise, "{pair}");
            }
            if then.is_driven() && !state.is_driven() {
                assert_eq!((state, event), (State::Armed, Event::Drive), "{pair}");
                assert_eq!(action, Action::Energise, "{pair}");
            }
            if then == State::Parking && state != then {
                assert!(state.is_driven() && event == Event::Park, "{pair}");
            }
            if state == State::Fault && then != State::Fault {
                assert_eq!((then, event), (State::Boot, Event::ClearFault), "{pair}");
            }
            if state.is_driven() && !then.is_driven() {
                assert!(matches!(action, Action::SwitchOff | Action::Halt), "{pair}");
            }
            if state == State::MotorCheck && then != state {
                let ends = [Action::Energise, Action::SwitchOff, Action::Halt];
                assert!(ends.contains(&action), "{pair}");
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

    /// Refusals, written out independently of the table.
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
        let letters = |state| {
            let row = asks.map(|event| match next(state, event) {
                Ok(_) => '.',
                Err(Refusal::NotReady) => 'r',
                Err(Refusal::Disarmed) => 'd',
                Err(Refusal::NotIdle) => 'i',
                Err(Refusal::Passthrough) => 'p',
                Err(Refusal::Faulted) => 'f',
                Err(Refusal::Busy) => 'b',
                Err(_) => '?',
            });
            row.iter().collect::<String>()
        };
        let expected = vec![
            "rr..rr".to_string(), // Boot
            ".d....".to_string(), // Idle
            "...iii".to_string(), // Armed
            "...iii".to_string(), // Running
            "...iii".to_string(), // Degraded
            "pp..p.".to_string(), // Passthrough
            "ffffff".to_string(), // Fault
            ".bbiii".to_string(), // MotorCheck
            "...iii".to_string(), // Parking
        ];
        assert_eq!(STATES.map(letters).to_vec(), expected);
    }
}
