//! Tables of the steps of transactions.

use super::super::dispatch::with_protocol;
use super::super::exchange::GUARD_US;
use super::super::exchange::{Exchange, ExpectedReplies, Line, ReplyContent, Step};
use super::super::morpheus::Morpheus;
use super::super::port::bytes_us;
use super::super::protocol2;
use super::super::stop::{StopStep, brief_stop_step_for, stop_step_for};
use super::Transaction;
use super::timing::ping_window_us;
use crate::Firmware;

impl Transaction {
    /// The step with this index; `None` ends the transaction.
    pub(super) fn step(self, index: u8, line: &Line) -> Option<Step> {
        let &Line { firmware, baud, .. } = line;
        Some(match (self, index) {
            (Self::Stop, _) => stop_step_for(index, firmware, line.ids)?.into(),
            (Self::BriefStop, _) => brief_stop_step_for(index, firmware)?.into(),
            (Self::Ping { joint }, _) => return ping_step(joint, index, line),
            (Self::Start, _) => return Morpheus::step(self, index, line),
            (Self::Drive(_) | Self::HoldOff | Self::StopWedged { .. }, _) => {
                return with_protocol!(firmware, P => P::step(self, index, line));
            }
            (Self::Request(_), 0) => Step::SendRequest,
            (Self::Request(expected), 1) if expected.reply_bytes > 0 => Step::Listen(
                ExpectedReplies::Request(expected),
                bytes_us(expected.reply_bytes.into(), baud) + u64::from(expected.latency_us),
            ),
            (Self::Request(_), _) => return None,
        })
    }
}

/// Steps of a ping. X servos are switched off first: the stop before a search does not reach them.
fn ping_step(joint: usize, index: u8, line: &Line) -> Option<Step> {
    let &Line { firmware, baud, .. } = line;
    let index = match (firmware, index) {
        (Firmware::XSeries, 0) => return Some(Step::Send(protocol2::torque_off())),
        (Firmware::XSeries, 1) => {
            return Some(Step::Pause {
                us: GUARD_US as u32,
            });
        }
        (Firmware::XSeries, _) => index - 2,
        (Firmware::Morpheus | Firmware::Stock, _) => index,
    };
    Some(match index {
        0 => Step::Send(firmware.ping_query(*line.ids.get(joint)?).packet),
        1 => Step::Listen(
            ExpectedReplies::Servo(joint, ReplyContent::Pong),
            ping_window_us(firmware, baud),
        ),
        _ => return None,
    })
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
