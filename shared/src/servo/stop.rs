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
//! | torque enable 0, twice   | stops stock servos, by Protocol 1.0; the second for those that took the first for the end of something else |
//!
//! The last comes last: it holds zeros, which a Morpheus servo in the middle of
//! a SYNC_WR would take for full drive. After the flush none is. Stock servos
//! find no header of theirs in what comes before.
//!
//! The steps are data: the bus master runs them on its interrupts, a panic
//! handler runs the same list by polling.

use super::morpheus::{Request, ServoId};
use super::protocol1::{BROADCAST, Instruction, register};
use super::{Firmware, Packet};
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

/// The step with this index on a bus of servos that run this; `None` after the
/// last. Stock servos, where they are known to be alone, are not made to wait.
pub fn stop_step_for(index: u8, firmware: Firmware, ids: [ServoId; JOINTS]) -> Option<StopStep> {
    match (firmware, index) {
        (Firmware::Morpheus, _) => stop_step(index, ids),
        (Firmware::Stock, 0 | 2) => Some(StopStep::Pause { us: PACKET_GAP_US }),
        (Firmware::Stock, 1) => torque_off().map(StopStep::Send),
        (Firmware::Stock, _) => stop_step(index - 3, ids),
    }
}

/// The step with this index; `None` after the last.
#[expect(
    clippy::match_same_arms,
    reason = "a table: every row stands for itself"
)]
fn stop_step(index: u8, ids: [ServoId; JOINTS]) -> Option<StopStep> {
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
        11 | 13 => StopStep::Send(torque_off()?),
        12 | 14 => pause(PACKET_GAP_US),
        _ => return None,
    })
}

/// To all stock servos: let go of the shaft. No reply.
fn torque_off() -> Option<Packet> {
    let off = Instruction::Write {
        address: register::TORQUE_ENABLE,
        data: &[0],
    };
    off.encode(BROADCAST)
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
        assert_eq!(last, Some(StopStep::Send(torque_off().unwrap())));
        let release = StopStep::Send(Request::Release(ids).encode());
        assert!(stop_steps(ids).any(|step| step == release));
        assert_eq!(stop_steps(ids).count(), 15);
        let first = (0..).find_map(|index| match stop_step_for(index, Firmware::Stock, ids) {
            Some(StopStep::Send(packet)) => Some(packet),
            _ => None,
        });
        assert_eq!(first, torque_off());
    }
}
