//! Which mode follows which event: the whole of it, as one table.
//!
//! ```text
//!            BusReady          Torque, Regulate, Track
//! BringUp ------------> Idle <-------------------------> Torque, Regulate, Track
//!  ^ ^ |  <-- Prepare -- | |                                | (and each other)
//!  | | | ClientCame      | | ClientCame, Release            |
//!  | | +----> Passthrough <+                                |
//!  | +------------+ ClientLeft, Idle                        |
//!  | ClearFault          |                                  |
//!  +--------- Fault <----+----------------------------------+  (Tripped, from anywhere)
//! ```
//!
//! A client of the transparent port is given the bus only while torque is off
//! and no fault is latched; with torque on, its packets are served in the slack
//! of the ticks. What it did to the servos is not known, so the way back leads
//! through bring-up.
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
    /// A client speaks on the transparent port.
    ClientCame,
    /// It has closed that port.
    ClientLeft,
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
    /// Stock servos ready for torque.
    Prepare,
    /// Servos as they were found, the bus to the transparent port.
    Release,
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
    use Event::{Asked, BusReady, ClientCame, ClientLeft, Tripped};
    use Mode::{BringUp, Idle, Passthrough, Regulate, Torque, Track};
    match (mode, event) {
        // The first cause stays: what follows it is often its consequence.
        (Mode::Fault(first), Tripped(_)) => Ok(Mode::Fault(first)),
        (_, Tripped(fault)) => Ok(Mode::Fault(fault)),

        (BringUp, BusReady) => Ok(Idle),
        (_, BusReady) => Ok(mode),

        (BringUp | Idle | Passthrough, ClientCame) => Ok(Passthrough),
        // Served between the ticks.
        (Torque | Regulate | Track | Mode::Fault(_), ClientCame) => Ok(mode),
        (Passthrough, ClientLeft) => Ok(BringUp),
        (BringUp | Idle | Torque | Regulate | Track | Mode::Fault(_), ClientLeft) => Ok(mode),

        (Passthrough, Asked(Request::Idle)) => Ok(BringUp),
        // Torque is off already: nothing to refuse, nothing to leave.
        (BringUp | Mode::Fault(_), Asked(Request::Idle)) => Ok(mode),
        (Idle | Torque | Regulate | Track, Asked(Request::Idle)) => Ok(Idle),

        (BringUp, Asked(Request::Torque | Request::Regulate | Request::Track)) => {
            Err(Refusal::NotReady)
        }
        (Passthrough, Asked(Request::Torque | Request::Regulate | Request::Track)) => {
            Err(Refusal::Passthrough)
        }
        (Idle | Torque | Regulate | Track, Asked(Request::Torque)) => Ok(Torque),
        (Idle | Torque | Regulate | Track, Asked(Request::Regulate)) => Ok(Regulate),
        (Idle | Torque | Regulate | Track, Asked(Request::Track)) => Ok(Track),

        (BringUp | Idle | Torque | Regulate | Track | Passthrough, Asked(Request::Configure)) => {
            Ok(mode)
        }

        (Idle, Asked(Request::Prepare)) => Ok(BringUp),
        (Passthrough, Asked(Request::Prepare)) => Err(Refusal::Passthrough),
        (Idle | Passthrough, Asked(Request::Release)) => Ok(Passthrough),
        (BringUp, Asked(Request::Prepare | Request::Release)) => Err(Refusal::NotReady),
        (Torque | Regulate | Track, Asked(Request::Prepare | Request::Release)) => {
            Err(Refusal::NotIdle)
        }

        (Mode::Fault(_), Asked(Request::ClearFault)) => Ok(BringUp),
        (BringUp | Idle | Torque | Regulate | Track | Passthrough, Asked(Request::ClearFault)) => {
            Ok(mode)
        }

        (
            Mode::Fault(_),
            Asked(
                Request::Torque
                | Request::Regulate
                | Request::Track
                | Request::Configure
                | Request::Prepare
                | Request::Release,
            ),
        ) => Err(Refusal::Faulted),
    }
}

/// Whether motors may be driven in this mode.
pub const fn torque_is_on(mode: Mode) -> bool {
    match mode {
        Mode::Torque | Mode::Regulate | Mode::Track => true,
        Mode::BringUp | Mode::Idle | Mode::Passthrough | Mode::Fault(_) => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Mode::{BringUp, Idle, Passthrough, Regulate, Torque, Track};

    /// Every mode against every event, written out independently of `next`.
    #[test]
    fn every_pair() {
        const HELD: Mode = Mode::Fault(Fault::HostSilent);
        const TRIPPED: Mode = Mode::Fault(Fault::Overrun);
        use Refusal::{Faulted, NotIdle, NotReady};
        const BUS: Refusal = Refusal::Passthrough;
        let events = [
            Event::BusReady,
            Event::Tripped(Fault::Overrun),
            Event::ClientCame,
            Event::ClientLeft,
            Event::Asked(Request::Idle),
            Event::Asked(Request::Torque),
            Event::Asked(Request::Regulate),
            Event::Asked(Request::Track),
            Event::Asked(Request::Configure),
            Event::Asked(Request::Prepare),
            Event::Asked(Request::Release),
            Event::Asked(Request::ClearFault),
        ];
        let modes = [BringUp, Idle, Torque, Regulate, Track, Passthrough, HELD];
        // A row an event, a column a mode.
        #[rustfmt::skip]
        let table = [
            [Ok(Idle),        Ok(Idle),        Ok(Torque),    Ok(Regulate),  Ok(Track),    Ok(Passthrough), Ok(HELD)],
            [Ok(TRIPPED),     Ok(TRIPPED),     Ok(TRIPPED),   Ok(TRIPPED),   Ok(TRIPPED),  Ok(TRIPPED),     Ok(HELD)],
            [Ok(Passthrough), Ok(Passthrough), Ok(Torque),    Ok(Regulate),  Ok(Track),    Ok(Passthrough), Ok(HELD)],
            [Ok(BringUp),     Ok(Idle),        Ok(Torque),    Ok(Regulate),  Ok(Track),    Ok(BringUp),     Ok(HELD)],
            [Ok(BringUp),     Ok(Idle),        Ok(Idle),      Ok(Idle),      Ok(Idle),     Ok(BringUp),     Ok(HELD)],
            [Err(NotReady),   Ok(Torque),      Ok(Torque),    Ok(Torque),    Ok(Torque),   Err(BUS),        Err(Faulted)],
            [Err(NotReady),   Ok(Regulate),    Ok(Regulate),  Ok(Regulate),  Ok(Regulate), Err(BUS),        Err(Faulted)],
            [Err(NotReady),   Ok(Track),       Ok(Track),     Ok(Track),     Ok(Track),    Err(BUS),        Err(Faulted)],
            [Ok(BringUp),     Ok(Idle),        Ok(Torque),    Ok(Regulate),  Ok(Track),    Ok(Passthrough), Err(Faulted)],
            [Err(NotReady),   Ok(BringUp),     Err(NotIdle),  Err(NotIdle),  Err(NotIdle), Err(BUS),        Err(Faulted)],
            [Err(NotReady),   Ok(Passthrough), Err(NotIdle),  Err(NotIdle),  Err(NotIdle), Ok(Passthrough), Err(Faulted)],
            [Ok(BringUp),     Ok(Idle),        Ok(Torque),    Ok(Regulate),  Ok(Track),    Ok(Passthrough), Ok(BringUp)],
        ];
        for (event, row) in events.into_iter().zip(table) {
            for (mode, expected) in modes.into_iter().zip(row) {
                assert_eq!(next(mode, event), expected, "{mode:?} on {event:?}");
            }
        }
    }
}
