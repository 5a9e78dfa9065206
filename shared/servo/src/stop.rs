//! The sequence that ends with every motor off, whatever the servos are doing.
//!
//! A Morpheus servo keeps its last PWM for ever, so every doubtful state ends with this
//! sequence: bring-up, fault, panic, hard fault, and the start after a watchdog reset.
//!
//! | step                     | why                                            |
//! |--------------------------|------------------------------------------------|
//! | broadcast WRITE 1000     | stops every servo that is listening            |
//! | 210 × 0xFF               | completes or discards any half packet in a servo's receiver; no id, length or PWM is 0xFF, so it has no other effect |
//! | broadcast WRITE 1000     | stops the servos that were stuck               |
//! | SYNC_WR 1001, then 1000  | the only stop accepted by a servo that once saw a packet of LEN 128 or more |
//! | torque enable 0, twice   | stops stock servos, by Protocol 1.0; the second for those that took the first for the end of something else |
//!
//! The last comes last: it holds zeros, which a Morpheus servo in the middle of
//! a SYNC_WR would take for full drive. After the flush none is. Stock servos
//! find no header of theirs in what comes before.
//!
//! Where only stock servos are known to be, torque enable 0 comes first, and again right
//! after the flush: a stock servo that was inside a long packet listens from then on.
//!
//! Where X servos are known to be, they alone are addressed:
//!
//! | step                     | why                                            |
//! |--------------------------|------------------------------------------------|
//! | torque enable 0, twice   | stops every servo that is listening; by Protocol 2.0 |
//! | 210 × 0xFF               | completes a half packet in a servo's receiver  |
//! | torque enable 0, twice   | stops the servos that were stuck               |
//!
//! A board that has not found its servos yet does not send these. An X servo that was driven
//! before has the watchdog that bring-up gives it, and is off by itself.
//!
//! The steps are data: the bus master runs them on its interrupts, a panic
//! handler runs the same list by polling:
//!
//! ```
//! use armbridge_servo::ServoId;
//! use armbridge_servo::stop::{StopStep, stop_steps};
//!
//! let ids = [1, 2].map(|id| ServoId::new(id).unwrap());
//! let (mut wire, mut paused_us) = (Vec::new(), 0);
//! for step in stop_steps(ids) {
//!     match step {
//!         StopStep::Send(packet) => wire.extend_from_slice(&packet),
//!         StopStep::Repeat(byte, count) => wire.extend((0..count).map(|_| byte)),
//!         StopStep::Pause { us } => paused_us += us,
//!     }
//! }
//! // It begins with PWM 1000 to every Morpheus servo, and ends with torque enable 0 to
//! // every stock one.
//! assert!(wire.starts_with(&[0xAA, 6, 0xFF, 0xFE, 3, 0x10, 0xE8, 3]));
//! assert!(wire.ends_with(&[0xFF, 0xFF, 0xFE, 4, 3, 24, 0, 0xE2]));
//! // At 1 Mbaud a byte takes 10 µs.
//! assert!(paused_us as usize + 10 * wire.len() < 8_000);
//! ```
//!
//! # The brief stop
//!
//! The full sequence takes 7 ms at 1 Mbaud and more at other speeds: too long to
//! wait for where servos may run at any of several. [`brief_stop_step`] has the
//! two plain commands only, 0.39 ms at 1 Mbaud, to be sent at each speed first:
//!
//! | step                | why                                                 |
//! |---------------------|-----------------------------------------------------|
//! | 2 × 0xFF            | ends a packet of a Morpheus servo that was cut off, see below |
//! | broadcast WRITE 1000 | stops Morpheus servos                              |
//! | torque enable 0     | stops stock servos                                  |
//!
//! This order of the commands is safe with either firmware. A Morpheus servo that listens has taken
//! WRITE 1000 as a whole when the zeros of torque enable come, and looks for 0xAA
//! then, which is not among them. One that does not listen is inside a packet that
//! was cut off, and takes the next bytes for the rest of it:
//!
//! * inside the checked SYNC_WR, by which the bridge gives torque, nothing takes
//!   effect before a checksum that is right;
//! * inside an unchecked one after its own id, it takes the next two bytes for its
//!   PWM. Without the two 0xFF these would be the header and the length of WRITE
//!   1000, AA 06: a PWM of 1706. 0xFFFF is refused;
//! * elsewhere in an unchecked one it waits for its own id before it takes a PWM.
//!   Ids 1 and 2 are not among the bytes that follow. (A servo with id 3 would take
//!   03 18 00 for a PWM of 24: the bridge drives none.)
//! * after the header, 0xFF is a length that it refuses, and it listens again.
//!
//! The other way round the zeros would come first and WRITE 1000 later. To a stock
//! servo 0xFF 0xFF and the head of WRITE 1000 are a packet for id 170 that ends
//! within WRITE 1000. Servos that are wedged, or inside a longer packet, are left to
//! the full sequence, which must follow.

use super::morpheus::Request;
use super::protocol1::torque_off;
use super::protocol2;
use super::{Firmware, Packet, ServoIds};

/// Byte that flushes a servo's receiver.
pub const FLUSH: u8 = 0xFF;

/// Bytes of 0xFF that flush a servo's receiver: it gives up a packet 200 bytes
/// after the header; ten more for the header and for any phase.
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
    /// Send this byte this many times.
    Repeat(u8, u16),
    /// Keep the bus idle, from the end of the last stop bit.
    Pause {
        /// Length in µs.
        us: u32,
    },
}

/// The step with this index for servos with this firmware; `None` after the last. Where
/// only stock servos are known to be, their command comes first.
pub fn stop_step_for(index: u8, firmware: Firmware, ids: impl Into<ServoIds>) -> Option<StopStep> {
    let ids = ids.into();
    match (firmware, index) {
        (Firmware::Morpheus, _) => stop_step(index, ids),
        (Firmware::Stock, 0 | 2 | 11) => Some(StopStep::Pause { us: PACKET_GAP_US }),
        (Firmware::Stock, 1 | 10) => Some(StopStep::Send(torque_off())),
        (Firmware::Stock, 3..10) => stop_step(index - 3, ids),
        (Firmware::Stock, _) => stop_step(index - 5, ids),
        (Firmware::XSeries, _) => x_stop_step(index),
    }
}

/// The step with this index; `None` after the last.
#[expect(
    clippy::match_same_arms,
    reason = "a table: every row stands for itself"
)]
fn stop_step(index: u8, ids: ServoIds) -> Option<StopStep> {
    let send = |request: Request| StopStep::Send(request.encode());
    let pause = |us| StopStep::Pause { us };
    Some(match index {
        // A servo that is sending finishes first: a reply lasts 70 µs.
        0 => pause(2 * PACKET_GAP_US),
        1 => send(Request::StopAll),
        2 => pause(PACKET_GAP_US),
        3 => StopStep::Repeat(FLUSH, FLUSH_BYTES),
        4 => pause(PACKET_GAP_US),
        5 => send(Request::StopAll),
        6 => pause(PACKET_GAP_US),
        7 => send(Request::SideStep(ids.filled())),
        8 => pause(CONTROL_STEP_US),
        9 => send(Request::Release(ids.filled())),
        10 => pause(CONTROL_STEP_US),
        11 | 13 => StopStep::Send(torque_off()),
        12 | 14 => pause(PACKET_GAP_US),
        _ => return None,
    })
}

/// The step with this index for X servos; `None` after the last.
fn x_stop_step(index: u8) -> Option<StopStep> {
    Some(match index {
        // A servo that is sending finishes first.
        0 => StopStep::Pause {
            us: 2 * PACKET_GAP_US,
        },
        5 => StopStep::Repeat(FLUSH, FLUSH_BYTES),
        1 | 3 | 7 | 9 => StopStep::Send(protocol2::torque_off()),
        2 | 4 | 6 | 8 | 10 => StopStep::Pause { us: PACKET_GAP_US },
        _ => return None,
    })
}

/// The step with this index of the brief stop for servos with this firmware; `None` after the
/// last: for X servos the beginning of their sequence.
pub fn brief_stop_step_for(index: u8, firmware: Firmware) -> Option<StopStep> {
    match (firmware, index) {
        (Firmware::Morpheus | Firmware::Stock, _) => brief_stop_step(index),
        (Firmware::XSeries, 0..5) => x_stop_step(index),
        (Firmware::XSeries, _) => None,
    }
}

/// The step of the brief stop with this index; `None` after the last. Suits
/// AX-12A servos with either firmware.
pub fn brief_stop_step(index: u8) -> Option<StopStep> {
    Some(match index {
        // A reply that is under way ends first: it lasts 70 µs.
        0 => StopStep::Pause {
            us: 2 * PACKET_GAP_US,
        },
        1 => StopStep::Repeat(FLUSH, 2),
        2 => StopStep::Send(Request::StopAll.encode()),
        4 => StopStep::Send(torque_off()),
        3 | 5 => StopStep::Pause { us: PACKET_GAP_US },
        _ => return None,
    })
}

/// All steps in order, for a handler that polls.
pub fn stop_steps(ids: impl Into<ServoIds>) -> impl Iterator<Item = StopStep> {
    let ids = ids.into();
    (0..).map_while(move |index| stop_step(index, ids))
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;

    #[test]
    fn sequence_is_bounded_and_ends_with_off() {
        let ids = [1, 2].map(|id| crate::ServoId::new(id).unwrap());
        let sent = |step: &StopStep| !matches!(step, StopStep::Pause { .. });
        let last = stop_steps(ids).filter(sent).last();
        assert_eq!(last, Some(StopStep::Send(torque_off())));
        let release = StopStep::Send(Request::Release(ids).encode());
        assert!(stop_steps(ids).any(|step| step == release));
        assert_eq!(stop_steps(ids).count(), 15);
        let stock: std::vec::Vec<StopStep> = (0..)
            .map_while(|index| stop_step_for(index, Firmware::Stock, ids))
            .collect();
        let off = StopStep::Send(torque_off());
        assert_eq!(stock.iter().find(|step| sent(step)), Some(&off));
        // Between the flush and the next command to stock servos there is one packet.
        let after_flush = stock
            .iter()
            .skip_while(|step| !matches!(step, StopStep::Repeat(..)));
        assert_eq!(after_flush.filter(|step| sent(step)).nth(2), Some(&off));
        let others = stock.iter().filter(|step| sent(step) && **step != off);
        let all: std::vec::Vec<StopStep> = stop_steps(ids).collect();
        assert!(others.eq(all.iter().filter(|step| sent(step) && **step != off)));
    }

    #[test]
    fn brief_stop_is_short_and_contains_no_torque() {
        let steps = (0..).map_while(brief_stop_step);
        let mut sent = heapless::Vec::<u8, 32>::new();
        let mut us = 0;
        for step in steps {
            match step {
                StopStep::Send(packet) => sent.extend(packet),
                StopStep::Repeat(byte, count) => sent.extend((0..count).map(|_| byte)),
                StopStep::Pause { us: pause_us } => us += pause_us,
            }
        }
        assert_eq!(us + 10 * sent.len() as u32, 390);
        let stop_all = Request::StopAll.encode();
        assert_eq!(
            sent.as_slice(),
            [&[0xFF; 2][..], &stop_all, &torque_off()].concat()
        );
        // A servo of the bridge finds no block of its own in it, wherever in an
        // unchecked SYNC_WR it was cut off; a PWM that was due is refused.
        assert!(!sent.contains(&1) && !sent.contains(&2));
        let due = u16::from_le_bytes([sent[0], sent[1]]);
        assert!(due > 2000 && u16::from_le_bytes([0, sent[0]]) > 2000);
    }
}
