//! Bounds of speed, acceleration and jerk on trajectories.

use crate::check_word::checked;
use crate::real::Real;
use armbridge_servo::JOINTS;
#[cfg(feature = "postcard")]
use postcard::experimental::max_size::MaxSize;
#[cfg(feature = "postcard")]
use postcard_schema::Schema;
#[cfg(feature = "postcard")]
use serde::{Deserialize, Serialize};

/// Magnitudes that a trajectory must not exceed, for both joints.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "snapshot", serde(bound = "T: crate::snapshot::Number"))]
pub struct Bounds<T> {
    /// In rad, either way from upright.
    pub angle_rad: T,
    /// In rad/s.
    pub speed_rad_s: T,
    /// In rad/s^2.
    pub acceleration_rad_s2: T,
    /// In rad/s^3: of a [stream](super::stream) where it begins and ends. That of a planned
    /// motion follows from its duration.
    pub jerk_rad_s3: T,
}

checked!(Bounds<T> { angle_rad, speed_rad_s, acceleration_rad_s2, jerk_rad_s3 });

/// Bounded quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "postcard", derive(Serialize, Deserialize, Schema, MaxSize))]
pub enum Quantity {
    /// In rad.
    Angle,
    /// In rad/s.
    Speed,
    /// In rad/s^2.
    Acceleration,
    /// In rad/s^3.
    Jerk,
}

/// Where a motion comes nearest to a bound, or furthest beyond it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak<T> {
    /// Of this joint, counting from 0.
    pub joint: usize,
    /// Of its angle, speed, acceleration or jerk.
    pub quantity: Quantity,
    /// The value there, in the quantity's unit.
    pub value: T,
    /// Bound on its magnitude.
    pub limit: T,
    /// When, in s since the start.
    pub at_s: T,
}

impl<T: Real> Bounds<T> {
    /// The bound of one quantity.
    pub fn of(&self, quantity: Quantity) -> T {
        match quantity {
            Quantity::Angle => self.angle_rad,
            Quantity::Speed => self.speed_rad_s,
            Quantity::Acceleration => self.acceleration_rad_s2,
            Quantity::Jerk => self.jerk_rad_s3,
        }
    }
}

/// Share of a bound that a motion may be beyond it: one that was made to touch its bounds
/// may miss them by the rounding of `f32`.
pub(super) const SLACK: f64 = 1e-4;

/// Watches a motion go by and remembers its [`Peak`].
#[derive(Clone, Copy, Debug)]
pub(super) struct PeakTracker<T> {
    bounds: Bounds<T>,
    peak: Peak<T>,
    /// Value over limit at the peak.
    ratio: T,
}

impl<T: Real> PeakTracker<T> {
    pub(super) fn new(bounds: &Bounds<T>) -> Self {
        Self {
            bounds: *bounds,
            peak: Peak {
                joint: 0,
                quantity: Quantity::Angle,
                value: T::zero(),
                limit: bounds.angle_rad,
                at_s: T::zero(),
            },
            ratio: T::zero(),
        }
    }

    /// A value of one quantity at one time.
    pub(super) fn see(&mut self, joint: usize, quantity: Quantity, value: T, at_s: T) {
        let limit = self.bounds.of(quantity);
        let ratio = value.abs() / limit;
        // An overflow exceeds everything, and stays the peak: nothing compares
        // greater than what is not a number.
        if ratio > self.ratio || !ratio.is_finite() {
            self.ratio = ratio;
            self.peak = Peak {
                joint,
                quantity,
                value,
                limit,
                at_s,
            };
        }
    }

    /// Values of all quantities of all joints at one time.
    pub(super) fn see_all(&mut self, values: [[T; 3]; JOINTS], at_s: T) {
        use Quantity::{Acceleration, Angle, Speed};
        for (joint, [q, dq, ddq]) in values.into_iter().enumerate() {
            self.see(joint, Angle, q, at_s);
            self.see(joint, Speed, dq, at_s);
            self.see(joint, Acceleration, ddq, at_s);
        }
    }

    /// The peak, `Err` if it lies beyond the bound.
    pub(super) fn verdict(&self) -> Result<Peak<T>, Peak<T>> {
        if self.ratio.is_finite() && self.ratio <= T::lit(1.0 + SLACK) {
            Ok(self.peak)
        } else {
            Err(self.peak)
        }
    }

    /// Ratio of value to limit, for comparison.
    pub(super) fn ratio(&self) -> T {
        self.ratio
    }
}
