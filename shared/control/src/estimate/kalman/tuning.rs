//! Tuning of the filter: noise of samples and model, and dry friction.

use crate::real::Real;
#[cfg(feature = "postcard")]
use postcard::experimental::max_size::MaxSize;
#[cfg(feature = "postcard")]
use postcard_schema::Schema;
#[cfg(feature = "postcard")]
use serde::{Deserialize, Serialize};

/// Noise and friction that the filter assumes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "postcard", derive(Serialize, Deserialize, Schema, MaxSize))]
pub struct Tuning<T> {
    /// Noise of an angle sample in rad rms, rounding included.
    pub angle_rad: T,
    /// Acceleration that no torque explains, as white noise:
    /// rad/s^2 per square root of Hz.
    pub acceleration: T,
    /// Random walk of the disturbance torque, in N m per square root of s.
    pub disturbance: T,
    /// Coulomb friction in N m; 0 leaves friction to the disturbance.
    pub coulomb_nm: T,
    /// Speed in rad/s from which on it is fully there.
    pub slide_rad_s: T,
}

impl<T: Real> Tuning<T> {
    /// For an arm that stands: noise of one count and its rounding, the bench's
    /// friction, and walks chosen on the bench, quiet at rest and quick enough to
    /// undo a push within a few tenths of a second.
    pub fn standing() -> Self {
        Self {
            angle_rad: T::lit(0.0053),
            acceleration: T::lit(0.3),
            disturbance: T::lit(0.2),
            coulomb_nm: T::lit(0.04),
            slide_rad_s: T::lit(0.1),
        }
    }

    /// Inside these a filter of single precision stays well conditioned, and
    /// outside them no arm is; NaN is inside nothing.
    pub(super) fn is_valid(&self) -> bool {
        let within = |x: T, low: f64, high: f64| x >= T::lit(low) && x <= T::lit(high);
        within(self.angle_rad, 1e-5, 1.0)
            && within(self.acceleration, 1e-4, 1e3)
            && within(self.disturbance, 0.0, 10.0)
            && within(self.coulomb_nm, 0.0, 1.0)
            && within(self.slide_rad_s, 1e-3, 10.0)
    }
}
