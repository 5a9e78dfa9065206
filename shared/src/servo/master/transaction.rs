//! What can be asked of the bus, and of which steps it consists.

use super::super::morpheus::{Request, ServoId};
use super::super::port::bytes_us;
use super::super::protocol1::{Alarms, BROADCAST, Instruction, register};
use super::super::stop::{StopStep, stop_step_for};
use super::super::{Firmware, Packet, Sample};
use super::collect::Awaited;
use super::timing::{GUARD_US, Windows, gap_us};
use crate::JOINTS;
use crate::actuator::Pwm;

/// What can be asked of the bus. The servos' firmware is what
/// [`Master::set_line`](super::Master::set_line) was told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transaction {
    /// All motors off, whatever runs on the servos and whatever state they are
    /// in. Takes about 8 ms at 1 Mbaud.
    Stop,
    /// Is the servo of this joint there?
    Ping {
        /// Index of the joint.
        joint: usize,
    },
    /// Line Morpheus servos up for the position chain.
    Start,
    /// Give each servo its PWM and collect all positions: the control tick.
    Drive([Pwm; JOINTS]),
    /// Collect all positions, and tell one servo that its motor is off in the way
    /// that a servo hears which hears nothing else. It listens to what changes only,
    /// so that first it is told a thousandth of the torque. Stock servos know no such
    /// state: to them the same as [`Transaction::Drive`] with motors off.
    Quell {
        /// Index of the servo's joint.
        joint: usize,
        /// The thousandth, not off.
        aside: bool,
    },
    /// A packet that was handed to [`Master::ask`](super::Master::ask).
    Ask(Asked),
}

/// What is awaited after a packet of somebody else's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Asked {
    /// Who shall answer; the answer of anybody else is not believed.
    pub id: u8,
    /// Bytes of the whole reply packet; 0 to await none.
    pub reply_bytes: u8,
    /// How long the servo may take to begin, in µs.
    pub latency_us: u32,
}

/// How a transaction ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// What was asked.
    pub transaction: Transaction,
    /// Per joint: the position in counts for [`Transaction::Drive`]; for a ping
    /// or START, 0 if the servo answered. A stop asks nobody.
    pub samples: [Sample; JOINTS],
    /// Per joint: what a stock servo complained of in its answer.
    pub alarms: [Alarms; JOINTS],
    /// From the first bit sent to the last byte heard, or to the end of the
    /// window if something is missing, in µs.
    pub bus_us: u32,
}

/// One step of a transaction.
pub(super) enum Step {
    Send(Packet),
    /// Send what [`super::Master::ask`] was handed.
    SendAsked,
    Repeat(u8, u16),
    Pause {
        us: u32,
    },
    Listen(Awaited, u64),
}

/// What the steps depend on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub(super) ids: [ServoId; JOINTS],
    pub(super) firmware: Firmware,
    pub(super) baud: u32,
    pub(super) available_us: u32,
    /// Stock servos are in wheel mode and answer soon.
    pub(super) is_prepared: bool,
}

impl Transaction {
    /// Steps as a table, built as they are needed; `None` ends the transaction.
    pub(super) fn step(self, index: u8, line: &Line) -> Option<Step> {
        let windows = Windows::at(line.baud);
        Some(match (self, line.firmware, index) {
            (Self::Stop, firmware, _) => match stop_step_for(index, firmware, line.ids)? {
                StopStep::Send(packet) => Step::Send(packet),
                StopStep::Repeat(byte, count) => Step::Repeat(byte, count),
                StopStep::Pause { us } => Step::Pause { us },
            },
            (Self::Ping { joint }, firmware, 0) => Step::Send(match firmware {
                Firmware::Morpheus => Request::Ping(*line.ids.get(joint)?).encode(),
                Firmware::Stock => Instruction::Ping.encode(line.ids.get(joint)?.get())?,
            }),
            (Self::Ping { joint }, firmware, 1) => {
                let awaited = match firmware {
                    Firmware::Morpheus => Awaited::Ping(joint),
                    Firmware::Stock => status(line.ids, joint, 0)?,
                };
                Step::Listen(awaited, windows.ping_us(firmware))
            }
            (Self::Start, _, 0) => Step::Send(Request::Start.encode()),
            (Self::Start, _, 1) => {
                let last = line.ids.iter().map(|id| id.get()).max().unwrap_or(0);
                Step::Listen(Awaited::Pings, windows.start_us(last))
            }
            (Self::Drive([a, b]), Firmware::Morpheus, _) => {
                let [id_a, id_b] = line.ids;
                let drive = Request::Drive([(id_a, a), (id_b, b)]);
                return drive_morpheus(index, drive, line, windows);
            }
            (Self::Quell { joint, aside }, Firmware::Morpheus, _) => {
                let servo = [*line.ids.get(joint)?; JOINTS];
                let off = if aside {
                    Request::SideStep(servo)
                } else {
                    Request::Release(servo)
                };
                // Cut short on a bad line, it takes the next two bytes for its PWM:
                // these are none.
                return match index {
                    0 => Some(Step::Send(off.encode())),
                    1 => Some(Step::Repeat(0xFF, 2)),
                    _ => drive_morpheus(index - 1, off, line, windows),
                };
            }
            (Self::Drive(pwm), Firmware::Stock, _) => {
                return drive_stock(index, pwm, line, windows);
            }
            (Self::Quell { .. }, Firmware::Stock, _) => {
                return drive_stock(index, [Pwm::OFF; JOINTS], line, windows);
            }
            (Self::Ask(_), _, 0) => Step::SendAsked,
            (Self::Ask(asked), _, 1) if asked.reply_bytes > 0 => Step::Listen(
                Awaited::Reply(asked),
                bytes_us(asked.reply_bytes.into(), line.baud) + u64::from(asked.latency_us),
            ),
            _ => return None,
        })
    }
}

fn drive_morpheus(index: u8, drive: Request, line: &Line, windows: Windows) -> Option<Step> {
    Some(match index {
        0 => Step::Send(drive.encode()),
        1 => Step::Pause {
            us: gap_us(line.available_us, line.baud),
        },
        2 => Step::Send(Request::Cycle.encode()),
        3 => Step::Listen(Awaited::Positions, windows.positions_us()),
        _ => return None,
    })
}

/// One `SYNC_WRITE`, if the servos are prepared for it, then a READ a servo.
fn drive_stock(index: u8, pwm: [Pwm; JOINTS], line: &Line, windows: Windows) -> Option<Step> {
    let Some(after) = index.checked_sub(1) else {
        // To one in another mode the same number means another thing.
        return if line.is_prepared {
            speeds(line.ids, pwm).map(Step::Send)
        } else {
            Some(Step::Pause { us: 0 })
        };
    };
    let joint = usize::from(after / 3);
    let id = line.ids.get(joint)?.get();
    Some(match after % 3 {
        0 => Step::Pause {
            us: GUARD_US as u32,
        },
        1 => {
            let read = Instruction::Read {
                address: register::PRESENT_POSITION,
                count: 2,
            };
            Step::Send(read.encode(id)?)
        }
        _ => Step::Listen(
            status(line.ids, joint, 2)?,
            windows.position_status_us(line.is_prepared),
        ),
    })
}

fn status(ids: [ServoId; JOINTS], joint: usize, parameters: u8) -> Option<Awaited> {
    let id = ids.get(joint)?.get();
    Some(Awaited::Status {
        joint,
        id,
        parameters,
    })
}

/// `SYNC_WRITE` of the moving speed, in wheel mode the duty.
fn speeds(ids: [ServoId; JOINTS], pwm: [Pwm; JOINTS]) -> Option<Packet> {
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

/// A PWM as a stock servo takes it: magnitude 0..=1023, bit 10 for clockwise,
/// which is towards lower counts. Rounded to the nearest.
pub(super) fn duty(pwm: Pwm) -> u16 {
    const FULL: u32 = 1023;
    let off = Pwm::OFF.counts();
    let magnitude = u32::from(pwm.counts().abs_diff(off));
    let duty = ((magnitude * FULL + 500) / 1000).min(FULL) as u16;
    if pwm < Pwm::OFF { duty | 1 << 10 } else { duty }
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
