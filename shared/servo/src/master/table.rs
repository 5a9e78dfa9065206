//! Tables of the steps of transactions.

use super::super::dispatch::with_protocol;
use super::super::exchange::{Exchange, ExpectedReplies, Line, ReplyContent, Step};
use super::super::morpheus::Morpheus;
use super::super::port::bytes_us;
use super::super::stop::{StopStep, brief_stop_step, stop_step_for};
use super::Transaction;
use super::timing::ping_window_us;

impl Transaction {
    /// The step with this index; `None` ends the transaction.
    pub(super) fn step(self, index: u8, line: &Line) -> Option<Step> {
        let &Line { firmware, baud, .. } = line;
        Some(match (self, index) {
            (Self::Stop, _) => stop_step_for(index, firmware, line.ids)?.into(),
            (Self::BriefStop, _) => brief_stop_step(index)?.into(),
            (Self::Ping { joint }, 0) => {
                Step::Send(firmware.ping_query(*line.ids.get(joint)?).packet)
            }
            (Self::Ping { joint }, 1) => Step::Listen(
                ExpectedReplies::Servo(joint, ReplyContent::Pong),
                ping_window_us(firmware, baud),
            ),
            (Self::Start, _) => return Morpheus::step(self, index, line),
            (Self::Drive(_) | Self::HoldOff | Self::StopWedged { .. }, _) => {
                return with_protocol!(firmware, P => P::step(self, index, line));
            }
            (Self::Request(_), 0) => Step::SendRequest,
            (Self::Request(expected), 1) if expected.reply_bytes > 0 => Step::Listen(
                ExpectedReplies::Request(expected),
                bytes_us(expected.reply_bytes.into(), baud) + u64::from(expected.latency_us),
            ),
            (Self::Ping { .. } | Self::Request(_), _) => return None,
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
