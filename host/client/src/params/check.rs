//! What only settings as a whole can be asked: whether a board runs with them.

use armbridge_shared::bridge::why_not;
use armbridge_shared::link::message::{Refusal, Settings};

use crate::refusal_text;

/// Why no board runs with these settings.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Unfit {
    /// The arm would be held after it has been let go.
    #[error(
        "`limits.hold_ms` ({hold_ms}) is longer than `limits.silence_ms` ({silence_ms}); make it \
         shorter"
    )]
    HoldsTooLate {
        /// When it is held.
        hold_ms: u16,
        /// When it is let go.
        silence_ms: u16,
    },
    /// No temperature is between these.
    #[error(
        "`limits.temperature_counts` must be the smaller count, then the larger; they are [{low}, {high}]"
    )]
    NoTemperature {
        /// The first.
        low: u16,
        /// The second.
        high: u16,
    },
    /// As the board itself would say.
    #[error("the board would refuse these settings: {}", refusal_text::in_words(*.0))]
    Refused(Refusal),
}

/// Whether a board runs with these settings, by the very code of the board.
///
/// # Errors
/// Why it does not.
pub fn check(settings: &Settings) -> Result<(), Unfit> {
    let limits = &settings.limits;
    let [low, high] = limits.temperature_counts;
    if limits.hold_ms > limits.silence_ms {
        return Err(Unfit::HoldsTooLate {
            hold_ms: limits.hold_ms,
            silence_ms: limits.silence_ms,
        });
    }
    if low >= high {
        return Err(Unfit::NoTemperature { low, high });
    }
    why_not(settings).map_or(Ok(()), |refusal| Err(Unfit::Refused(refusal)))
}
