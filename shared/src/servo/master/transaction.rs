//! Transactions of the bus, and the steps of which they consist.

use super::super::firmware::with_protocol;
use super::super::morpheus::Morpheus;
use super::super::port::bytes_us;
use super::super::protocol1::Alarms;
use super::super::stop::{StopStep, brief_stop_step, stop_step_for};
use super::super::{ExpectedReply, Sample};
use super::exchange::{Answer, Awaited, Exchange, Line, Step};
use super::timing::ping_window_us;
use crate::JOINTS;
use crate::actuator::Pwm;

/// What can be asked of the bus. The servos' firmware is what
/// [`Master::set_line`](super::Master::set_line) was told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transaction {
    /// All motors off, whatever runs on the servos and whatever state they are
    /// in. Takes about 8 ms at 1 Mbaud.
    Stop,
    /// All motors off that hear a plain order, whatever runs on the servos. Takes
    /// 0.4 ms at 1 Mbaud; what it cannot do is in [`stop`](super::super::stop).
    BriefStop,
    /// Presence test of the servo of this joint.
    Ping {
        /// Index of the joint.
        joint: usize,
    },
    /// Line Morpheus servos up for the position chain.
    Start,
    /// Give each servo its PWM and collect all positions: the control tick. Stock
    /// servos that are not prepared are given none.
    Drive([Pwm; JOINTS]),
    /// The control tick with motors off, in the state in which servos are: Morpheus
    /// servos are given PWM 1000, stock ones are told to let go, prepared or not,
    /// and drive again only when torque is enabled again.
    HoldOff,
    /// Collect all positions, and switch one servo off with the only packet that a
    /// wedged servo accepts. It heeds changes only, so that first it is given a
    /// thousandth of the torque. Stock servos know no such state: to them the same
    /// as [`Transaction::Drive`] with motors off.
    Quell {
        /// Index of the servo's joint.
        joint: usize,
        /// The thousandth, not off.
        aside: bool,
    },
    /// A packet that was handed to [`Master::ask`](super::Master::ask).
    Ask(ExpectedReply),
}

/// How a transaction ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// What was asked.
    pub transaction: Transaction,
    /// Per joint: the position in counts for a tick; for a ping or START, 0 if the
    /// servo answered. A stop asks nobody.
    pub samples: [Sample; JOINTS],
    /// Per joint: what a stock servo complained of in its answer.
    pub alarms: [Alarms; JOINTS],
    /// From the first bit sent to the last byte heard, or to the end of the
    /// window if something is missing, in µs.
    pub bus_us: u32,
}

impl Transaction {
    /// Steps as a table, built as they are needed; `None` ends the transaction.
    pub(super) fn step(self, index: u8, line: &Line) -> Option<Step> {
        let &Line { firmware, baud, .. } = line;
        Some(match (self, index) {
            (Self::Stop, _) => stop_step_for(index, firmware, line.ids)?.into(),
            (Self::BriefStop, _) => brief_stop_step(index)?.into(),
            (Self::Ping { joint }, 0) => {
                Step::Send(firmware.ping_query(*line.ids.get(joint)?).packet)
            }
            (Self::Ping { joint }, 1) => Step::Listen(
                Awaited::One(joint, Answer::Pong),
                ping_window_us(firmware, baud),
            ),
            (Self::Start, _) => return Morpheus::step(self, index, line),
            (Self::Drive(_) | Self::HoldOff | Self::Quell { .. }, _) => {
                return with_protocol!(firmware, P => P::step(self, index, line));
            }
            (Self::Ask(_), 0) => Step::SendAsked,
            (Self::Ask(asked), 1) if asked.reply_bytes > 0 => Step::Listen(
                Awaited::Reply(asked),
                bytes_us(asked.reply_bytes.into(), baud) + u64::from(asked.latency_us),
            ),
            (Self::Ping { .. } | Self::Ask(_), _) => return None,
        })
    }
}

impl From<StopStep> for Step {
    fn from(step: StopStep) -> Self {
        match step {
            StopStep::Send(packet) => Self::Send(packet),
            StopStep::Repeat(byte, count) => Self::Repeat(byte, count),
            StopStep::Pause { us } => Self::Pause { us },
        }
    }
}
