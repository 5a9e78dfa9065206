//! What the board asks its servos for its own sake, in the slack of the ticks.
//!
//! | errand      | when                                          | so that            |
//! |-------------|-----------------------------------------------|--------------------|
//! | temperature | each [`INTERVAL_US`], one servo after the other | a hot motor is switched off |
//! | ping        | a Morpheus servo has been missing for a half, five and six eighths of what is allowed | one that was off and on again, and has left the chain, is told from one that is gone or not understood: it answers all three |
//!
//! A temperature goes out if its answer is sure to be over before the next tick;
//! after [`OVERDUE_US`] without such a gap, which is so at the shortest periods, a
//! tick may begin late for it. A ping may always: the arm is in doubt.
//!
//! A stock servo sends its heat alarm with every answer and switches itself off, so
//! a tick is never late for its temperature.

use embedded_hal::digital::OutputPin;
use embedded_hal_nb::serial::{Read, Write};

use super::gateway::Ask;
use super::mailbox::Notice;
use super::schedule::Stage;
use super::{Bridge, SERVO_IDS};
use crate::JOINTS;
use crate::control_loop::Violation;
use crate::link::message::Fault;
use crate::servo::Firmware;
use crate::servo::master::Asked;
use crate::servo::morpheus::safe_read::{self, Plan};
use crate::servo::morpheus::{Request, ServoId};
use crate::servo::port::SetBaud;
use crate::servo::protocol1::{Instruction, register};

/// From one temperature to the next, of the other servo. A motor's winding heats
/// up in tens of seconds.
const INTERVAL_US: u64 = 250_000;
/// How long a temperature waits for a gap before a tick waits for it.
const OVERDUE_US: u64 = 1_000_000;

/// Bytes of a Morpheus reply beside its payload, and of a stock servo's.
const MORPHEUS_FRAME: u8 = 5;
const STOCK_FRAME: u8 = 6;
/// Register of the temperature in a Morpheus servo: two bytes, of which the reading
/// begins two earlier (see [`safe_read`]).
const MORPHEUS_TEMPERATURE: u8 = 0x0E;
/// How often a servo is asked whether it is still there. On a line that lets one
/// answer in three pass, one that is only misunderstood answers all three once in 27
/// times.
const PINGS: u8 = 3;
/// What a Morpheus servo answers to a ping.
const PONG: [u8; 1] = [1];

/// Something asked for the board's own sake.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Errand {
    Temperature { joint: usize },
    Ping { joint: usize },
}

/// What is under way, and what is known.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Care {
    asked: Option<Errand>,
    /// Whose temperature is next, and when.
    joint: usize,
    due_us: u64,
    /// Pings since the servo has been missing, and how many were answered.
    pings: [u8; JOINTS],
    pongs: [u8; JOINTS],
    /// The first temperature since the servos were found.
    first: [Option<u16>; JOINTS],
}

impl Care {
    /// The servos were found anew.
    pub(super) fn restart(&mut self, now_us: u64) {
        *self = Self {
            due_us: now_us + INTERVAL_US,
            ..Self::default()
        };
    }
}

/// The safe reading of a Morpheus servo's temperature.
const TEMPERATURE: Option<Plan> = match safe_read::plan(MORPHEUS_TEMPERATURE, 2) {
    Ok(plan) => Some(plan),
    Err(_) => None,
};

impl<S, D> Bridge<'_, S, D>
where
    S: Read<u8> + Write<u8> + SetBaud,
    D: OutputPin,
{
    /// The bus is idle between two ticks: asks what is due, if there is time. True
    /// if it has.
    pub(super) fn take_care(&mut self) -> bool {
        if self.stage != Stage::Ticking {
            return false;
        }
        let Some((errand, may_be_late)) = self.errand() else {
            return false;
        };
        let Some(ask) = self.ask_for(errand) else {
            return false;
        };
        let slack = self.slack_now(ask.id);
        if !(may_be_late || slack.has_time_for(&ask)) {
            return false;
        }
        let asked = Asked {
            id: ask.id,
            reply_bytes: ask.reply_bytes,
            latency_us: slack.latency_us,
        };
        match errand {
            Errand::Temperature { joint } => {
                self.care.due_us = self.core.now_us() + INTERVAL_US;
                self.care.joint = (joint + 1) % JOINTS;
            }
            Errand::Ping { joint } => {
                if let Some(pings) = self.care.pings.get_mut(joint) {
                    *pings += 1;
                }
            }
        }
        self.care.asked = Some(errand);
        // Idle was just seen, and our own requests are short.
        let _ = self.master.ask(&ask.packet, asked, self.core.now_us());
        let _ = self.master.poll(self.core.now_us());
        true
    }

    /// What is due, and whether a tick may begin late for it.
    fn errand(&mut self) -> Option<(Errand, bool)> {
        let is_morpheus = self.master.firmware() == Firmware::Morpheus;
        let counted = self.care.pings.iter_mut().zip(&mut self.care.pongs);
        for (joint, (pings, pongs)) in counted.enumerate() {
            let lost = self.core.lost_in_row(joint);
            let allowed = self.core.config().dropout_ticks();
            if lost == 0 {
                (*pings, *pongs) = (0, 0);
            }
            let due = 8 * lost >= (4 + u32::from(*pings)) * allowed;
            if is_morpheus && due && *pings < PINGS {
                return Some((Errand::Ping { joint }, true));
            }
        }
        let joint = self.care.joint;
        let overdue_us = self.core.now_us().checked_sub(self.care.due_us)?;
        let may_be_late = is_morpheus && overdue_us >= OVERDUE_US;
        Some((Errand::Temperature { joint }, may_be_late))
    }

    fn ask_for(&self, errand: Errand) -> Option<Ask> {
        let servo = |joint: usize| SERVO_IDS.get(joint).copied();
        let ask = |servo: ServoId, packet: &[u8], reply_bytes| {
            Some(Ask {
                packet: heapless::Vec::from_slice(packet).ok()?,
                id: servo.get(),
                reply_bytes,
            })
        };
        match (errand, self.master.firmware()) {
            (Errand::Ping { joint }, _) => {
                let servo = servo(joint)?;
                let request = Request::Ping(servo).encode();
                ask(servo, &request, MORPHEUS_FRAME + PONG.len() as u8)
            }
            (Errand::Temperature { joint }, Firmware::Morpheus) => {
                let (servo, plan) = (servo(joint)?, TEMPERATURE?);
                let reply_bytes = MORPHEUS_FRAME + plan.asked().len() as u8;
                ask(servo, &plan.request(servo), reply_bytes)
            }
            (Errand::Temperature { joint }, Firmware::Stock) => {
                let servo = servo(joint)?;
                let read = Instruction::Read {
                    address: register::PRESENT_TEMPERATURE,
                    count: 1,
                };
                let packet = read.encode::<8>(servo.get())?;
                ask(servo, &packet, STOCK_FRAME + 1)
            }
        }
    }

    /// Whether the answer that has just come was asked for here; judges it then.
    pub(super) fn finish_care(&mut self) -> bool {
        let Some(errand) = self.care.asked.take() else {
            return false;
        };
        let firmware = self.master.firmware();
        let data = self.master.reply().map(|reply| reply.data.as_slice());
        match errand {
            Errand::Ping { joint } => {
                let Some(pongs) = self.care.pongs.get_mut(joint) else {
                    return true;
                };
                *pongs += u8::from(data == Some(&PONG));
                if *pongs == PINGS {
                    let lost = self.core.lost_in_row(joint);
                    let allowed = self.core.config().dropout_ticks();
                    self.trip(Violation {
                        fault: Fault::ServoReset,
                        joint: Some(joint as u8),
                        value: lost as f32,
                        limit: allowed as f32,
                    });
                }
            }
            Errand::Temperature { joint } => {
                let value = match (firmware, data) {
                    (Firmware::Morpheus, Some(data)) => {
                        match TEMPERATURE.as_ref().and_then(|plan| plan.wanted(data)) {
                            // Zero until the first conversion, half a second after
                            // power-up.
                            Some(&[low, high]) if [low, high] != [0, 0] => {
                                Some(u16::from_le_bytes([low, high]))
                            }
                            _ => None,
                        }
                    }
                    (Firmware::Stock, Some(&[celsius])) => Some(u16::from(celsius)),
                    _ => None,
                };
                if let Some(value) = value {
                    self.judge_temperature(joint, firmware, value);
                }
            }
        }
        true
    }

    fn judge_temperature(&mut self, joint: usize, firmware: Firmware, value: u16) {
        // Lost if nobody fetches it: another comes.
        let _ = self
            .end
            .notices
            .enqueue(Notice::Temperature(joint as u8, value));
        let limits = self.core.config().limits();
        let first = self
            .care
            .first
            .get_mut(joint)
            .map_or(value, |first| *first.get_or_insert(value));
        let [coldest, hottest] = limits.temperature_counts;
        let drift = limits.temperature_drift_counts;
        // The first of these that is passed.
        let passed = match firmware {
            Firmware::Stock => [(
                value > limits.temperature_c.into(),
                limits.temperature_c.into(),
            )]
            .into_iter()
            .find(|(is_passed, _)| *is_passed),
            Firmware::Morpheus => [
                (value > hottest, hottest),
                (value < coldest, coldest),
                (
                    value > first.saturating_add(drift),
                    first.saturating_add(drift),
                ),
                (
                    value < first.saturating_sub(drift),
                    first.saturating_sub(drift),
                ),
            ]
            .into_iter()
            .find(|(is_passed, _)| *is_passed),
        };
        if let (Some((_, limit)), true) = (passed, self.core.state().is_armed()) {
            self.trip(Violation {
                fault: Fault::Temperature,
                joint: Some(joint as u8),
                value: value.into(),
                limit: limit.into(),
            });
        }
    }
}
