//! Ranges of the numbers of a trajectory, and the checks against them.

use super::{Argument, Bounds, Error, Quantity};
use crate::real::Real;
use crate::trajectory::Reference;
use nalgebra::Vector2;

/// Most waypoints of a trajectory.
pub const WAYPOINTS_MAX: usize = 8;
/// Shortest motion, and shortest way between waypoints: a tick.
pub const DURATION_MIN_S: f64 = 1e-3;
/// Longest trajectory, so that `f32` seconds stay finer than a tick.
pub const DURATION_MAX_S: f64 = 600.0;
/// Highest frequency of a wave: far above what the arm can follow, and at the longest
/// duration still few enough turns to count them off, see [`Real::to_count`].
pub const FREQUENCY_MAX_HZ: f64 = 50.0;

/// Checks that reference and bounds are finite and that the bounds leave room to move.
pub(super) fn check_start<T: Real>(
    from: &Reference<T>,
    bounds: &Bounds<T>,
) -> Result<(), Error<T>> {
    if !from.is_finite() {
        return Err(Error::NotFinite(Argument::From));
    }
    for quantity in [
        Quantity::Angle,
        Quantity::Speed,
        Quantity::Acceleration,
        Quantity::Jerk,
    ] {
        let bound = bounds.of(quantity);
        if !bound.is_finite() {
            return Err(Error::NotFinite(Argument::Bounds));
        }
        if bound <= T::zero() {
            return Err(Error::NoRoom(quantity));
        }
    }
    Ok(())
}

/// The duration, if it is in range.
pub(super) fn checked_duration<T: Real>(value_s: T) -> Result<T, Error<T>> {
    if value_s < T::lit(DURATION_MIN_S) || value_s > T::lit(DURATION_MAX_S) {
        Err(Error::Duration { value_s })
    } else {
        Ok(value_s)
    }
}

/// Checks the frequency of each joint.
pub(super) fn checked_frequency<T: Real>(hz: Vector2<T>) -> Result<(), Error<T>> {
    for (joint, &value_hz) in hz.iter().enumerate() {
        if value_hz < T::zero() || value_hz > T::lit(FREQUENCY_MAX_HZ) {
            return Err(Error::Frequency { joint, value_hz });
        }
    }
    Ok(())
}
