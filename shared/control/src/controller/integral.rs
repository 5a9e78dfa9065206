//! Integral action: a torque that grows until no angle error is left.
//!
//! ```text
//! u(k)   = control law + w(k)
//! w(k+1) = w(k) + ki T (q_r(k) - q(k))
//! ```
//!
//! q is the angle that the control law itself uses. The error of an observer does not depend on
//! w, so its poles do not change; those of the control loop do, see
//! [`closed_loop`](IntegralAction::closed_loop).
//!
//! # Wind-up
//!
//! Where the demanded torque exceeds what the servo gives, w does not grow towards it, and w is
//! never more than the joint's torque limit.
//!
//! # Dry friction
//!
//! An arm that sticks is freed in the end, slides, and sticks beyond: an integral and dry
//! friction together hunt about the setpoint, the slower the smaller ki is. Friction
//! compensation, or the disturbance of the Kalman filter, leaves less of that.

use crate::arm::Discrete;
use crate::check_word::checked;
use crate::real::Real;
use armbridge_servo::JOINTS;
use nalgebra::{Matrix2, Matrix2x4, SMatrix, Vector2};

/// States of the arm, and the torque of each joint's integral.
type ClosedLoop<T> = SMatrix<T, 6, 6>;

/// Integral action of both joints for one period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IntegralAction<T> {
    /// `ki T` in N m/rad.
    per_tick: Vector2<T>,
}

checked!(IntegralAction<T> { per_tick });

impl<T: Real> IntegralAction<T> {
    /// With these gains in N m/(rad s), sampled every `period_s`.
    pub fn new(gain: [T; JOINTS], period_s: T) -> Self {
        Self {
            per_tick: Vector2::from(gain) * period_s,
        }
    }

    /// The state matrix of the model under the gain K and this action. A joint without it has
    /// a torque that is 0 in the next tick.
    pub fn closed_loop(&self, model: &Discrete<T>, gain: &Matrix2x4<T>) -> ClosedLoop<T> {
        let mut closed = ClosedLoop::zeros();
        closed
            .fixed_view_mut::<4, 4>(0, 0)
            .copy_from(&(model.a - model.b * gain));
        closed.fixed_view_mut::<4, 2>(0, 4).copy_from(&model.b);
        closed
            .fixed_view_mut::<2, 2>(4, 0)
            .copy_from(&Matrix2::from_diagonal(&-self.per_tick));
        let lasts = |gain: T| {
            if gain == T::zero() {
                T::zero()
            } else {
                T::one()
            }
        };
        closed
            .fixed_view_mut::<2, 2>(4, 4)
            .copy_from(&Matrix2::from_diagonal(&self.per_tick.map(lasts)));
        closed
    }

    /// The torque of the next tick in N m, after `torque_nm` in this one, with an angle
    /// error in rad: where `unmet_nm` of the demand could not be given, beyond `rounding_nm`,
    /// it does not grow that way.
    pub fn next(
        &self,
        torque_nm: Vector2<T>,
        error_rad: Vector2<T>,
        unmet_nm: Vector2<T>,
        rounding_nm: [T; JOINTS],
        limit_nm: [T; JOINTS],
    ) -> Vector2<T> {
        Vector2::from_fn(|joint, _| {
            let step = self.per_tick[joint] * error_rad[joint];
            let unmet = unmet_nm[joint];
            let is_winding_up =
                unmet.abs() > rounding_nm[joint] && (unmet > T::zero()) == (step > T::zero());
            let limit = limit_nm[joint];
            let grown = torque_nm[joint] + if is_winding_up { T::zero() } else { step };
            grown.clamp(-limit, limit)
        })
    }
}
