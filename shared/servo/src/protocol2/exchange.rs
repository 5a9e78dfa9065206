//! The control tick with X servos, and their response times.
//!
//! ```text
//! SYNC_WRITE of the goals (20 bytes) | guard | FAST_SYNC_READ (16 bytes) | both positions (24)
//! ```
//!
//! The goals are PWM or currents, by the [`ControlMode`]. With motors held off, torque enable 0 to
//! all (13 bytes) stands in the place of the first.
//!
//! | at         | bytes  | guards | return delay and processing | shortest period |
//! |------------|--------|--------|-----------------------------|-----------------|
//! | 1 Mbaud    | 600 µs | 100 µs | 200 µs                      | 900 µs          |
//! | 2 Mbaud    | 300 µs | 100 µs | 200 µs                      | 600 µs          |
//! | 4 Mbaud    | 150 µs | 100 µs | 200 µs                      | 450 µs          |
//!
//! The e-Manual gives the return delay, which bring-up sets to [`RETURN_DELAY_US`], and no time for
//! the processing of an instruction: [`PROCESSING_US`] is an assumption, to be measured.

use super::codec::{LATENCY_US, POSITION_BYTES};
use super::{BROADCAST, FastStatus, Instruction, Protocol2, model, register, torque_off};
use crate::exchange::{Exchange, ExpectedReplies, GUARD_US, Line, Readiness, Step};
use crate::port::bytes_us;
use crate::transaction::Transaction;
use crate::{ControlMode, JOINTS, Packet, Pwm, ServoId, ServoIds};

/// Return delay that bring-up gives to X servos, with which a reply begins no sooner than that of
/// an AX-12A: the direction pin is lowered within 40 µs.
pub const RETURN_DELAY_US: u64 = 50;
/// Longest processing of an instruction beyond the return delay, for both servos of a tick.
const PROCESSING_US: u64 = 150;
/// Reserve on top of that in a tick's windows.
const RESERVE_US: u64 = 50;
/// Full duty in units of the goal PWM.
const FULL: i32 = model::FULL as i32;
/// Bytes of the packets of a tick.
const GOALS_BYTES: u32 = 14 + 3 * JOINTS as u32;
const READ_BYTES: u32 = 14 + JOINTS as u32;
const REPLY_BYTES: u32 = FastStatus::packet_bytes(JOINTS, POSITION_BYTES as usize) as u32;

impl Exchange for Protocol2 {
    const LATENCY_US: u32 = LATENCY_US;

    const SAME_SERVO_GUARD_US: u64 = GUARD_US;

    fn reply_latency_us(_baud: u32, answers_soon: bool) -> u32 {
        if answers_soon {
            (RETURN_DELAY_US + PROCESSING_US) as u32
        } else {
            LATENCY_US
        }
    }

    fn tick_us(baud: u32, readiness: Readiness) -> u32 {
        let bytes = GOALS_BYTES + READ_BYTES;
        (bytes_us(bytes, baud) + reply_us(baud, readiness) + 2 * GUARD_US) as u32
    }

    fn step(transaction: Transaction, index: u8, line: &Line) -> Option<Step> {
        let pwm = match transaction {
            Transaction::Drive(pwm) => Some(pwm),
            Transaction::StopWedged { .. } => Some([Pwm::OFF; JOINTS]),
            Transaction::HoldOff => None,
            _ => return None,
        };
        Some(match index {
            0 => match pwm {
                Some(pwm) if line.readiness == Readiness::Prepared => {
                    Step::Send(goals(line.mode, line.ids, pwm)?)
                }
                // In another mode the goal has another meaning.
                _ => Step::Send(torque_off()),
            },
            1 => Step::Pause {
                us: GUARD_US as u32,
            },
            2 => Step::Send(positions(line.ids)?),
            3 => Step::Listen(
                ExpectedReplies::Fast,
                reply_us(line.baud, line.readiness) + RESERVE_US,
            ),
            _ => return None,
        })
    }
}

/// Time in µs from the end of `FAST_SYNC_READ` to that of its reply.
fn reply_us(baud: u32, readiness: Readiness) -> u64 {
    let begins_us = if readiness.answers_soon() {
        RETURN_DELAY_US + PROCESSING_US
    } else {
        u64::from(LATENCY_US)
    };
    begins_us + bytes_us(REPLY_BYTES, baud)
}

/// `SYNC_WRITE` of the goals.
fn goals(mode: ControlMode, ids: ServoIds, pwm: [Pwm; JOINTS]) -> Option<Packet> {
    let mut blocks: heapless::Vec<u8, { 3 * JOINTS }> = heapless::Vec::new();
    for (id, pwm) in ids.iter().zip(pwm) {
        let [low, high] = goal(mode, pwm).to_le_bytes();
        blocks.extend([id.get(), low, high]);
    }
    let write = Instruction::SyncWrite {
        address: match mode {
            ControlMode::Pwm => register::GOAL_PWM,
            ControlMode::Current => register::GOAL_CURRENT,
        },
        count: 2,
        blocks: &blocks,
    };
    write.encode(BROADCAST)
}

/// `FAST_SYNC_READ` of the present position.
fn positions(ids: ServoIds) -> Option<Packet> {
    let each = ids.filled().map(ServoId::get);
    let read = Instruction::FastSyncRead {
        address: register::PRESENT_POSITION,
        count: POSITION_BYTES,
        ids: each.get(..ids.len())?,
    };
    read.encode(BROADCAST)
}

/// Goal in units of an X servo: a PWM of -885..=885, rounded to the nearest, or a current.
fn goal(mode: ControlMode, pwm: Pwm) -> i16 {
    let from_off = i32::from(pwm.counts()) - i32::from(Pwm::OFF.counts());
    if mode == ControlMode::Current {
        return from_off as i16;
    }
    let half = if from_off < 0 { -500 } else { 500 };
    ((from_off * FULL + half) / 1_000).clamp(-FULL, FULL) as i16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tick_is_as_long_as_its_table_says() {
        let ids = ServoIds::from([1, 2].map(|id| ServoId::new(id).unwrap()));
        let pwm = [2_000, 999].map(|counts| Pwm::new(counts).unwrap());
        let [goals, currents] =
            [ControlMode::Pwm, ControlMode::Current].map(|mode| goals(mode, ids, pwm).unwrap());
        assert_eq!(goals.len(), GOALS_BYTES as usize);
        // 885 and -1.
        assert_eq!(goals[12..18], [1, 0x75, 0x03, 2, 0xFF, 0xFF]);
        // 1000 and -1.
        assert_eq!(currents[8..12], [102, 0, 2, 0]);
        assert_eq!(currents[12..18], [1, 0xE8, 0x03, 2, 0xFF, 0xFF]);
        assert_eq!(positions(ids).unwrap().len(), READ_BYTES as usize);
        let tick_us = |baud| Protocol2::tick_us(baud, Readiness::Prepared);
        assert_eq!(
            [1_000_000, 2_000_000, 4_000_000].map(tick_us),
            [900, 600, 450]
        );
        assert_eq!(torque_off().len(), 13);
    }
}
