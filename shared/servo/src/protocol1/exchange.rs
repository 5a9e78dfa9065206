//! The control tick with stock servos, and their response times.
//!
//! ```text
//! SYNC_WRITE (14 bytes) | for each servo: guard | READ (8 bytes) | position (8)
//! ```
//!
//! With motors held off, before each READ:
//!
//! ```text
//! guard | torque enable 0 (8 bytes) | guard | READ (8 bytes) | position (8)
//! ```
//!
//! A servo that was cut off inside a packet takes up to 254 bytes for its rest, and receives
//! the first packet after them: the more bytes a tick has and the shorter its pauses, the sooner.
//!
//! Times are from the e-Manual, where it has any; it gives none for the processing time of
//! a servo.

use super::codec::{LATENCY_US, RETURN_DELAY_MAX_US};
use super::{BROADCAST, Instruction, Protocol1, register, torque_off};
use crate::exchange::{Exchange, ExpectedReplies, GUARD_US, Line, Readiness, ReplyContent, Step};
use crate::port::bytes_us;
use crate::transaction::Transaction;
use crate::{JOINTS, Packet, Pwm, ServoIds};

/// Return delay that bring-up gives to stock servos. With the 22 µs they take
/// themselves a status packet begins 42 µs after the READ: just late enough for
/// the direction pin, which is lowered within 40.
pub const RETURN_DELAY_US: u64 = 20;
/// From READ to status packet without return delay, as measured at the wire
/// (Xevel, notes on the USB2AX).
const STATUS_US: u64 = 22;
/// Additional time after a WRITE of two bytes (same source), rounded up.
const WRITE_US: u64 = 20;
/// Duration of the motor control step that a stock servo runs each millisecond, sending
/// nothing meanwhile (same source). It may fall before or into a status packet,
/// and into a long one several times.
pub const CONTROL_STEP_US: u64 = 130;
/// Longest time of a status packet with that delay beyond its bytes, if those
/// take less than a millisecond.
const SHORT_STATUS_US: u64 = RETURN_DELAY_US + STATUS_US + CONTROL_STEP_US;
/// Reserve on top of that in a tick's windows.
const RESERVE_US: u64 = 50;
/// Pause of the bus between two packets.
const REST: Step = Step::Pause {
    us: GUARD_US as u32,
};

impl Exchange for Protocol1 {
    const LATENCY_US: u32 = LATENCY_US;

    /// A control step at the end of its status packet keeps a servo's bus driver on, with which it
    /// receives nothing.
    const SAME_SERVO_GUARD_US: u64 = GUARD_US + CONTROL_STEP_US;

    fn reply_latency_us(baud: u32, answers_soon: bool) -> u32 {
        let begins_us = if answers_soon {
            SHORT_STATUS_US + WRITE_US
        } else {
            u64::from(LATENCY_US)
        };
        // The longest answer is the whole table.
        (begins_us + control_steps_us(bytes_us(56, baud))) as u32
    }

    fn tick_us(baud: u32, readiness: Readiness) -> u32 {
        let turn_us = GUARD_US + bytes_us(8, baud) + position_us(baud, readiness);
        let commands_us = match readiness {
            Readiness::Prepared => bytes_us(14, baud),
            Readiness::Released | Readiness::Unknown => {
                JOINTS as u64 * (GUARD_US + bytes_us(8, baud))
            }
        };
        (commands_us + JOINTS as u64 * turn_us + GUARD_US) as u32
    }

    /// One `SYNC_WRITE`, if the servos are prepared for it, then a READ for each servo; or
    /// for each torque enable 0 and a READ.
    fn step(transaction: Transaction, index: u8, line: &Line) -> Option<Step> {
        let pwm = match transaction {
            Transaction::Drive(pwm) => pwm,
            Transaction::StopWedged { .. } => [Pwm::OFF; JOINTS],
            Transaction::HoldOff => return hold_off(index, line),
            _ => return None,
        };
        let Some(read_step) = index.checked_sub(1) else {
            return if line.readiness == Readiness::Prepared {
                speeds(line.ids, pwm).map(Step::Send)
            } else {
                // In another mode the same value has another meaning.
                Some(Step::Pause { us: 0 })
            };
        };
        position_step(usize::from(read_step / 3), read_step % 3, line)
    }
}

/// Steps of a tick with motors held off.
fn hold_off(index: u8, line: &Line) -> Option<Step> {
    let joint = usize::from(index / 5);
    match index % 5 {
        _ if joint >= line.ids.len() => None,
        0 => Some(REST),
        1 => Some(Step::Send(torque_off())),
        step => position_step(joint, step - 2, line),
    }
}

/// Steps that read the position of the servo of this joint.
fn position_step(joint: usize, step: u8, line: &Line) -> Option<Step> {
    let id = line.ids.get(joint)?.get();
    Some(match step {
        0 => REST,
        1 => {
            let read = Instruction::Read {
                address: register::PRESENT_POSITION,
                count: 2,
            };
            Step::Send(read.encode(id)?)
        }
        _ => Step::Listen(
            ExpectedReplies::Servo(joint, ReplyContent::Position),
            position_us(line.baud, line.readiness) + RESERVE_US,
        ),
    })
}

/// `SYNC_WRITE` of the moving speed, in wheel mode the duty.
fn speeds(ids: ServoIds, pwm: [Pwm; JOINTS]) -> Option<Packet> {
    let mut blocks: heapless::Vec<u8, { 3 * JOINTS }> = heapless::Vec::new();
    for (id, pwm) in ids.iter().zip(pwm) {
        let [low, high] = duty(pwm).to_le_bytes();
        blocks.extend([id.get(), low, high]);
    }
    let instruction = Instruction::SyncWrite {
        address: register::MOVING_SPEED,
        count: 2,
        blocks: &blocks,
    };
    instruction.encode(BROADCAST)
}

/// PWM in the encoding of a stock servo: magnitude 0..=1023, bit 10 for clockwise,
/// which is towards lower counts. Rounded to the nearest.
fn duty(pwm: Pwm) -> u16 {
    const FULL: u32 = 1023;
    let off = Pwm::OFF.counts();
    let magnitude = u32::from(pwm.counts().abs_diff(off));
    let duty = ((magnitude * FULL + 500) / 1000).min(FULL) as u16;
    if pwm < Pwm::OFF { duty | 1 << 10 } else { duty }
}

/// Time in µs from the end of a READ to the end of a stock servo's position.
fn position_us(baud: u32, readiness: Readiness) -> u64 {
    let position_us = bytes_us(8, baud);
    let delay_us = if readiness.answers_soon() {
        SHORT_STATUS_US
    } else {
        RETURN_DELAY_MAX_US + STATUS_US + CONTROL_STEP_US
    };
    position_us + delay_us + control_steps_us(position_us)
}

/// Time in µs that control steps of a stock servo add to a packet of this duration,
/// beside the one that may precede it.
const fn control_steps_us(packet_us: u64) -> u64 {
    const SENDS_US: u32 = 1_000 - CONTROL_STEP_US as u32;
    (packet_us as u32 / SENDS_US * CONTROL_STEP_US as u32) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn duty_is_sign_and_magnitude() {
        let duty = |pwm| duty(Pwm::new(pwm).unwrap());
        assert_eq!(
            [0, 500, 999, 1000, 1001, 1500, 2000].map(duty),
            [2047, 1024 + 512, 1025, 0, 1, 512, 1023]
        );
    }
}
