//! The sequence that ends with every motor off, whatever the servos are doing.
//!
//! A Morpheus servo keeps its last PWM for ever, so this is how every doubt
//! ends: bring-up, fault, panic, hard fault, and what follows a watchdog bite.
//!
//! | step                     | why                                            |
//! |--------------------------|------------------------------------------------|
//! | broadcast WRITE 1000     | stops every servo that is listening            |
//! | 210 × 0xFF               | completes or discards whatever half packet a servo's receiver is stuck in; no id, length or PWM is 0xFF, so it does nothing else |
//! | broadcast WRITE 1000     | stops the servos that were stuck               |
//! | SYNC_WR 1001, then 1000  | the only stop heard by a servo that once saw a packet of LEN 128 or more |
//!
//! The steps are data: the bus master runs them on its interrupts, a panic
//! handler runs the same list by polling.

use super::morpheus::{Packet, Request, ServoId};
use crate::JOINTS;

/// Bytes of 0xFF that flush a servo's receiver: it gives up a packet 200 bytes
/// after the header; ten more for the header and for luck with phase.
pub const FLUSH_BYTES: u16 = 210;

/// A checked packet that follows another by less than 20 µs may be lost.
const PACKET_GAP_US: u32 = 50;

/// The servo's control step takes up to 1.1 ms while it receives. The value
/// 1001 must be seen by one before 1000 replaces it.
const CONTROL_STEP_US: u32 = 2_000;

/// One step of the stop sequence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StopStep {
    /// Send these bytes.
    Send(Packet),
    /// Send this byte so many times.
    Repeat(u8, u16),
    /// Leave the wire alone, from the end of the last stop bit.
    Pause {
        /// Length in µs.
        us: u32,
    },
}

/// The step with this index; `None` after the last.
#[expect(
    clippy::match_same_arms,
    reason = "a table: every row stands for itself"
)]
pub fn stop_step(index: u8, ids: [ServoId; JOINTS]) -> Option<StopStep> {
    let send = |request: Request| StopStep::Send(request.encode());
    let pause = |us| StopStep::Pause { us };
    Some(match index {
        // Whoever is speaking finishes first: a reply lasts 70 µs.
        0 => pause(2 * PACKET_GAP_US),
        1 => send(Request::StopAll),
        2 => pause(PACKET_GAP_US),
        3 => StopStep::Repeat(0xFF, FLUSH_BYTES),
        4 => pause(PACKET_GAP_US),
        5 => send(Request::StopAll),
        6 => pause(PACKET_GAP_US),
        7 => send(Request::SideStep(ids)),
        8 => pause(CONTROL_STEP_US),
        9 => send(Request::Release(ids)),
        10 => pause(CONTROL_STEP_US),
        _ => return None,
    })
}

/// All steps in order, for a handler that polls.
pub fn stop_steps(ids: [ServoId; JOINTS]) -> impl Iterator<Item = StopStep> {
    (0..).map_while(move |index| stop_step(index, ids))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sequence_is_bounded_and_ends_with_off() {
        let ids = [1, 2].map(|id| ServoId::new(id).unwrap());
        let sent = |step: &StopStep| !matches!(step, StopStep::Pause { .. });
        let last = stop_steps(ids).filter(sent).last();
        assert_eq!(last, Some(StopStep::Send(Request::Release(ids).encode())));
        assert_eq!(stop_steps(ids).count(), 11);
    }
}
