//! Which mode follows which event: the whole of it, as one table.
//!
//! ```text
//!            BusReady          Torque, Regulate, Track
//! BringUp ------------> Idle <-------------------------> Torque, Regulate, Track
//!    ^                   |                                  | (and each other)
//!    | ClearFault        |                                  |
//!    +------- Fault <----+----------------------------------+  (Tripped, from anywhere)
//! ```
//!
//! Torque is on in [`Mode::Torque`], [`Mode::Regulate`] and [`Mode::Track`] and
//! in no other mode. A fault is latched with its first cause, and leads back through
//! bring-up, which begins with the stop sequence.

use crate::link::message::{Fault, Mode, Refusal};

/// What can happen to a mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// All servos answer and are lined up.
    BusReady,
    /// Something is in doubt.
    Tripped(Fault),
    /// The host asks for this.
    Asked(Request),
}

/// What the host can ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// Torque off.
    Idle,
    /// Constant torque.
    Torque,
    /// Hold a reference.
    Regulate,
    /// Follow a moving one.
    Track,
    /// Another set-up.
    Configure,
    /// Leave the fault.
    ClearFault,
}

/// The mode after `event`.
///
/// # Errors
/// The refusal that the host is told; the mode stays as it is.
#[expect(
    clippy::match_same_arms,
    reason = "a table: every row stands for itself"
)]
pub const fn next(mode: Mode, event: Event) -> Result<Mode, Refusal> {
    use Event::{Asked, BusReady, Tripped};
    use Mode::{BringUp, Idle, Regulate, Torque, Track};
    match (mode, event) {
        // The first cause stays: what follows it is often its consequence.
        (Mode::Fault(first), Tripped(_)) => Ok(Mode::Fault(first)),
        (_, Tripped(fault)) => Ok(Mode::Fault(fault)),

        (BringUp, BusReady) => Ok(Idle),
        (_, BusReady) => Ok(mode),

        // Torque is off already: nothing to refuse, nothing to leave.
        (BringUp | Mode::Fault(_), Asked(Request::Idle)) => Ok(mode),
        (Idle | Torque | Regulate | Track, Asked(Request::Idle)) => Ok(Idle),

        (BringUp, Asked(Request::Torque | Request::Regulate | Request::Track)) => {
            Err(Refusal::NotReady)
        }
        (Idle | Torque | Regulate | Track, Asked(Request::Torque)) => Ok(Torque),
        (Idle | Torque | Regulate | Track, Asked(Request::Regulate)) => Ok(Regulate),
        (Idle | Torque | Regulate | Track, Asked(Request::Track)) => Ok(Track),

        (BringUp | Idle | Torque | Regulate | Track, Asked(Request::Configure)) => Ok(mode),

        (Mode::Fault(_), Asked(Request::ClearFault)) => Ok(BringUp),
        (BringUp | Idle | Torque | Regulate | Track, Asked(Request::ClearFault)) => Ok(mode),

        (
            Mode::Fault(_),
            Asked(Request::Torque | Request::Regulate | Request::Track | Request::Configure),
        ) => Err(Refusal::Faulted),
    }
}

/// Whether motors may be driven in this mode.
pub const fn torque_is_on(mode: Mode) -> bool {
    match mode {
        Mode::Torque | Mode::Regulate | Mode::Track => true,
        Mode::BringUp | Mode::Idle | Mode::Fault(_) => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Mode::{BringUp, Idle, Regulate, Torque, Track};

    /// Every mode against every event, written out independently of `next`.
    #[test]
    fn every_pair() {
        const HELD: Mode = Mode::Fault(Fault::HostSilent);
        const TRIPPED: Mode = Mode::Fault(Fault::Overrun);
        use Refusal::{Faulted, NotReady};
        let columns = [
            Event::BusReady,
            Event::Tripped(Fault::Overrun),
            Event::Asked(Request::Idle),
            Event::Asked(Request::Torque),
            Event::Asked(Request::Regulate),
            Event::Asked(Request::Track),
            Event::Asked(Request::Configure),
            Event::Asked(Request::ClearFault),
        ];
        #[rustfmt::skip]
        let table = [
            (BringUp,  [Ok(Idle), Ok(TRIPPED), Ok(BringUp), Err(NotReady), Err(NotReady), Err(NotReady), Ok(BringUp), Ok(BringUp)]),
            (Idle,     [Ok(Idle), Ok(TRIPPED), Ok(Idle), Ok(Torque), Ok(Regulate), Ok(Track), Ok(Idle), Ok(Idle)]),
            (Torque,   [Ok(Torque), Ok(TRIPPED), Ok(Idle), Ok(Torque), Ok(Regulate), Ok(Track), Ok(Torque), Ok(Torque)]),
            (Regulate, [Ok(Regulate), Ok(TRIPPED), Ok(Idle), Ok(Torque), Ok(Regulate), Ok(Track), Ok(Regulate), Ok(Regulate)]),
            (Track,    [Ok(Track), Ok(TRIPPED), Ok(Idle), Ok(Torque), Ok(Regulate), Ok(Track), Ok(Track), Ok(Track)]),
            (HELD,     [Ok(HELD), Ok(HELD), Ok(HELD), Err(Faulted), Err(Faulted), Err(Faulted), Err(Faulted), Ok(BringUp)]),
        ];
        for (mode, row) in table {
            for (event, expected) in columns.into_iter().zip(row) {
                assert_eq!(next(mode, event), expected, "{mode:?} on {event:?}");
            }
        }
    }
}
