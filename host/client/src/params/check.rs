//! Checks of settings as a whole: whether a board runs with them.

use armbridge_board::bridge::settings_refusal;
use armbridge_link::message::{Refusal, Settings};

use toml::Value;

use super::{ParameterError, apply};
use crate::refusal_text;

/// Reason for which no board runs with these settings.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum InvalidSettings {
    /// The arm would be held after torque is off.
    #[error(
        "`limits.hold_ms` ({hold_ms}) is longer than `limits.silence_ms` ({silence_ms}); make it \
         shorter"
    )]
    HoldsTooLate {
        /// Silence after which it is held.
        hold_ms: u16,
        /// Silence after which torque is off.
        silence_ms: u16,
    },
    /// The temperature range is empty.
    #[error(
        "`limits.temperature_counts` must be the smaller count, then the larger; they are [{low}, {high}]"
    )]
    NoTemperature {
        /// Lower limit.
        low: u16,
        /// Upper limit.
        high: u16,
    },
    /// The pose of a park is beyond where the board brakes a joint.
    #[error(
        "`park.angle_rad` is beyond where a joint is braked, 0.1 rad before `limits.angle_rad` or \
         at three quarters of it; bring it nearer to 0"
    )]
    PoseBeyondLimit,
    /// Current control mode of servos that are not of the X series.
    #[error(
        "`setup.control_mode` is \"current\", which only X servos have, and the calibration of a joint is \
         not theirs: armbridge calibrate --mode current"
    )]
    NoCurrentMode,
    /// The board itself would refuse them.
    #[error("the board would refuse these settings: {}", refusal_text::in_words(*.0))]
    Refused(Refusal),
}

/// Reason for which parameters cannot be replaced.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReplaceError {
    /// A parameter that there is not, or that rejects its value.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// The settings as a whole.
    #[error(transparent)]
    Settings(#[from] InvalidSettings),
}

/// These settings with several parameters replaced, as [`apply`] does, if a board runs with them.
///
/// # Errors
/// If a parameter is not permitted, or the settings are not.
pub fn replaced<'a>(
    before: &Settings,
    pairs: impl IntoIterator<Item = (&'a str, &'a Value)>,
) -> Result<Settings, ReplaceError> {
    let mut after = *before;
    apply(&mut after, pairs)?;
    check(&after)?;
    Ok(after)
}

/// Checks whether a board runs with these settings, by the board's own code.
///
/// # Errors
/// If it does not.
pub fn check(settings: &Settings) -> Result<(), InvalidSettings> {
    let limits = &settings.limits;
    let [low, high] = limits.temperature_counts;
    if limits.hold_ms > limits.silence_ms {
        return Err(InvalidSettings::HoldsTooLate {
            hold_ms: limits.hold_ms,
            silence_ms: limits.silence_ms,
        });
    }
    if low >= high {
        return Err(InvalidSettings::NoTemperature { low, high });
    }
    if !limits.is_pose_valid() {
        return Err(InvalidSettings::PoseBeyondLimit);
    }
    if !settings.setup.mode_is_possible() {
        return Err(InvalidSettings::NoCurrentMode);
    }
    settings_refusal(settings).map_or(Ok(()), |refusal| Err(InvalidSettings::Refused(refusal)))
}
