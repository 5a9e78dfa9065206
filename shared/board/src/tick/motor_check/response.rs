//! Response of a joint: its motion in units of the model's.
//!
//! The measured angle is fitted by least squares with
//!
//! ```text
//! q(t) = c + v t + f t^2 + r d(t)     d: motion by the model, from the torque that was sent
//! ```
//!
//! The response `r` is 1 on the arm of the model, negative for a motor in the wrong direction,
//! and near 0 for a joint that does not move; `v` is the speed from before, `f` a lean that the
//! model has wrong. One count of noise leaves 0.06 of `r` at 1 kHz, dry friction takes 0.1.

use nalgebra::{Matrix4, Vector4};

/// Angle in which the equations of the fit are, in rad.
const UNIT_RAD: f32 = 0.01;

/// Largest variance of a response, for noise of one [`UNIT_RAD`]: a count of noise leaves a
/// standard error of 0.25.
const CERTAIN: f32 = 0.25;

/// Largest variance at which a response tells the direction, as it must when an attempt ends
/// early: a standard error of 0.5. A fit to a tenth of an attempt is off by 10 and more.
const DIRECTED: f32 = 1.0;

/// Mean square beyond the encoder's noise that a fit leaves, in squares of [`UNIT_RAD`]: dry
/// friction leaves a tenth of it.
const UNDISTURBED: f32 = 0.75;

/// Torque in N m below which a check tells directions alone: the limits of the host leave no
/// more.
pub(super) const CONCLUSIVE_NM: f32 = 0.3;

/// Motion of one joint by the model, and its fit to the samples.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Response {
    /// First sample in rad.
    from_rad: Option<f32>,
    /// Variance of the encoder's noise, in squares of [`UNIT_RAD`].
    noise: f32,
    /// Motion by the model in rad and rad/s.
    moved_rad: f32,
    speed_rad_s: f32,
    /// Largest torque beside gravity, in N m.
    pub(super) largest_nm: f32,
    /// Normal equations of the fit, in units of [`UNIT_RAD`].
    normal: Matrix4<f32>,
    right: Vector4<f32>,
    squares: f32,
}

/// Result of a fit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fit {
    /// Motion in units of the model's.
    pub(super) response: f32,
    /// Its variance, for noise of one [`UNIT_RAD`].
    variance: f32,
    /// Mean square of what the fit leaves, in squares of [`UNIT_RAD`].
    residual: f32,
}

impl Response {
    /// Moves the joint by the model for a period.
    pub(super) fn advance(&mut self, torque_nm: f32, inertia: f32, viscous: f32, period_s: f32) {
        let acceleration = (torque_nm - viscous * self.speed_rad_s) / inertia;
        self.moved_rad += (self.speed_rad_s + 0.5 * acceleration * period_s) * period_s;
        self.speed_rad_s += acceleration * period_s;
        self.largest_nm = self.largest_nm.max(torque_nm.abs());
    }

    /// Takes a sample, after this share of the attempt, of an encoder with this variance in rad².
    pub(super) fn take(&mut self, measured_rad: f32, share: f32, noise_rad2: f32) {
        self.noise = noise_rad2 / (UNIT_RAD * UNIT_RAD);
        let from_rad = *self.from_rad.get_or_insert(measured_rad);
        let measured = (measured_rad - from_rad) / UNIT_RAD;
        let row = Vector4::new(1.0, share, share * share, self.moved_rad / UNIT_RAD);
        self.normal += row * row.transpose();
        self.right += row * measured;
        self.squares += measured * measured;
    }

    /// Measured motion in units of the model's; NaN if noise hides it or something else moves
    /// the joint.
    pub(super) fn ratio(&self) -> f32 {
        self.response_within(CERTAIN)
    }

    /// The same, with more noise than one that must be about 1.
    pub(super) fn direction(&self) -> f32 {
        self.response_within(DIRECTED)
    }

    fn response_within(&self, variance_max: f32) -> f32 {
        let fit = self.fit();
        let certain = fit.filter(|it| it.variance < variance_max && !self.is_beyond(it));
        certain.map_or(f32::NAN, |fit| fit.response)
    }

    /// Whether the torque was enough to tell more than the direction.
    pub(super) fn is_conclusive(&self) -> bool {
        self.largest_nm > CONCLUSIVE_NM
    }

    /// Whether something else moves the joint.
    pub(super) fn is_disturbed(&self) -> bool {
        self.fit().is_some_and(|fit| self.is_beyond(&fit))
    }

    fn is_beyond(&self, fit: &Fit) -> bool {
        fit.residual - self.noise >= UNDISTURBED
    }

    /// The fit to the samples so far; `None` if they do not determine it.
    ///
    /// The equations are symmetrical, and the response is their last unknown: once the others
    /// are eliminated, its pivot is the inverse of its variance, and each pivot has taken its
    /// part of the squares. Nothing is substituted back.
    pub(super) fn fit(&self) -> Option<Fit> {
        let (mut rest, mut right, mut squares) = (self.normal, self.right, self.squares);
        for column in 0..3 {
            let pivot = rest[(column, column)];
            if pivot <= 0.0 {
                return None;
            }
            let (of_pivot, explained) = (rest.column(column) / pivot, right[column]);
            rest -= of_pivot * rest.column(column).transpose();
            right -= of_pivot * explained;
            squares -= explained * explained / pivot;
        }
        let (pivot, explained) = (rest.m44, right.w);
        (pivot > 0.0).then(|| Fit {
            response: explained / pivot,
            variance: 1.0 / pivot,
            residual: (squares - explained * explained / pivot) / self.normal.m11,
        })
    }
}
