//! Computed torque: the arm made to follow a reference as two independent
//! second-order systems.
//!
//! ```text
//! torque = M(q) (ddq_r + kd (dq_r - dq) + kp (q_r - q)) + Co(q, dq) dq + F dq + G(q)
//! ```
//!
//! With the exact model the error `e = q_r - q` obeys `e'' + kd e' + kp e = 0` for
//! any motion, kp = wn^2 and kd = 2 zeta wn: gravity, friction of the viscous kind
//! and the coupling of the joints are taken away, and what is left is chosen. What
//! the model does not know (dry friction above all) is resisted by M kp alone, so
//! a slow loop is a soft one.
//!
//! # Sampled
//!
//! A torque is held for a period and is decided a period before it acts. The
//! estimator predicts the state at that instant, so the delay costs no stability as
//! far as the model holds; the hold does. [`ComputedTorque::new`] refuses gains with
//! which the sampled error dynamics,
//!
//! ```text
//! e(k+1) = (A - B [kp kd]) e(k)      A = [1 T]   B = [T^2/2]
//!                                        [0 1]       [ T   ]
//! ```
//!
//! do not decay. Stable is `zeta wn T < 1` and `wn T < 4 zeta`; well damped, as a
//! rule, is `wn T < 0.3`. The state and the reference passed in must be those of the
//! instant at which the torque takes effect, the next tick.
//!
//! Nothing is clamped here, see [`actuator`](crate::actuator). A torque takes some 170
//! instructions on a Cortex-M4F, sines and cosines included.
//!
//! # Example
//!
//! ```
//! use armbridge_control::arm::{Parameters, State};
//! use armbridge_control::controller::{ComputedTorque, Tuning, computed_torque::Error};
//! use armbridge_control::trajectory::Reference;
//! use nalgebra::Vector2;
//!
//! let arm = Parameters::<f64>::paper();
//! let tuning = Tuning { natural_rad_s: [15.0; 2], damping: [1.0; 2] };
//! let law = ComputedTorque::new(&tuning, 1e-3).unwrap();
//!
//! // 0.1 s from an error of 0.2 rad on, critically damped: 0.2 (1 + wn t) exp(-wn t).
//! let reference = Reference::at_rest(Vector2::new(0.5, 0.0));
//! let mut state = State::at_rest(Vector2::new(0.3, 0.0));
//! for _ in 0..1_000 {
//!     let torque = law.torque(&arm, &state, &reference);
//!     state.dq += arm.acceleration(&state, torque) * 1e-4;
//!     state.q += state.dq * 1e-4;
//! }
//! let error = reference.q - state.q;
//! assert!((error.x - 0.2 * 2.5 * (-1.5_f64).exp()).abs() < 1e-3);
//! // The joints do not couple.
//! assert!(error.y.abs() < 1e-12);
//!
//! let too_stiff = Tuning { natural_rad_s: [5_000.0; 2], ..tuning };
//! let refused = ComputedTorque::new(&too_stiff, 1e-3);
//! assert!(matches!(refused, Err(Error::Unstable { joint: 0, .. })));
//! ```

use super::Demand;
use crate::arm::{Parameters, Posture, State};
use crate::check_word::checked;
use crate::real::Real;
use crate::trajectory::Reference;
use armbridge_servo::JOINTS;
use nalgebra::{Matrix2x4, Vector2};

/// Error dynamics of each joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tuning<T> {
    /// Natural frequency wn in rad/s.
    pub natural_rad_s: [T; JOINTS],
    /// Damping ratio zeta; 1 is critical.
    pub damping: [T; JOINTS],
}

/// Why there is no such controller. Joints count from 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Error<T> {
    /// The period is not positive, or not finite.
    Period,
    /// A natural frequency is not positive, or not finite.
    Natural {
        /// Of this joint.
        joint: usize,
    },
    /// A damping ratio is not positive, or not finite.
    Damping {
        /// Of this joint.
        joint: usize,
    },
    /// Too stiff for the period: the sampled error would not decay.
    Unstable {
        /// This joint.
        joint: usize,
        /// Growth factor of the error per period: 1 or more.
        radius: T,
    },
}

/// The gains of the control law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComputedTorque<T> {
    /// 1/s^2.
    kp: Vector2<T>,
    /// 1/s.
    kd: Vector2<T>,
}

checked!(ComputedTorque<T> { kp, kd });

impl<T: Real> ComputedTorque<T> {
    /// The gains for an arm whose torque is renewed every `period_s`.
    ///
    /// # Errors
    ///
    /// See [`Error`].
    pub fn new(tuning: &Tuning<T>, period_s: T) -> Result<Self, Error<T>> {
        let positive = |x: T| x.is_finite() && x > T::zero();
        if !positive(period_s) {
            return Err(Error::Period);
        }
        let (mut kp, mut kd) = (Vector2::zeros(), Vector2::zeros());
        let joints = tuning.natural_rad_s.into_iter().zip(tuning.damping);
        let gains = kp.iter_mut().zip(kd.iter_mut());
        for (joint, ((natural, damping), (kp, kd))) in joints.zip(gains).enumerate() {
            if !positive(natural) {
                return Err(Error::Natural { joint });
            }
            if !positive(damping) {
                return Err(Error::Damping { joint });
            }
            *kp = natural * natural;
            *kd = T::lit(2.0) * damping * natural;
            let radius = spectral_radius(*kp, *kd, period_s);
            // Absurd gains overflow, and may make it NaN.
            if !radius.is_finite() || radius >= T::one() {
                return Err(Error::Unstable { joint, radius });
            }
        }
        Ok(Self { kp, kd })
    }

    /// Its linearisation upright: `M (kd dq + kp q)` less what it gives back, `F dq + G(q)`.
    pub(super) fn upright_gain(&self, arm: &Parameters<T>) -> Matrix2x4<T> {
        let upright = Posture::of(Vector2::zeros());
        let mass = upright.mass_diagonal(arm);
        let slope = upright.gravity_slope(arm);
        let (kp, kd) = (
            mass.component_mul(&self.kp),
            mass.component_mul(&self.kd) - Vector2::new(arm.b1, arm.b2),
        );
        let o = T::zero();
        #[rustfmt::skip]
        let gain = Matrix2x4::new(
            kp.x - slope.m11, -slope.m12, kd.x, o,
            -slope.m21, kp.y - slope.m22, o, kd.y,
        );
        gain
    }

    /// The torque in N m for the state and the reference of one instant.
    pub fn torque(
        &self,
        arm: &Parameters<T>,
        state: &State<T>,
        reference: &Reference<T>,
    ) -> Vector2<T> {
        self.demand(arm, state, reference).torque_nm
    }

    /// The torque, and the share of it that corrects errors.
    pub(super) fn demand(
        &self,
        arm: &Parameters<T>,
        state: &State<T>,
        reference: &Reference<T>,
    ) -> Demand<T> {
        let posture = Posture::of(state.q);
        let correction = self.correction(state, reference);
        let ddq = reference.ddq + correction;
        Demand {
            torque_nm: posture.inverse_dynamics(arm, state.dq, ddq),
            feedback_nm: posture.mass_diagonal(arm).component_mul(&correction),
        }
    }

    /// `kd (dq_r - dq) + kp (q_r - q)` in rad/s^2.
    fn correction(&self, state: &State<T>, reference: &Reference<T>) -> Vector2<T> {
        self.kd.component_mul(&(reference.dq - state.dq))
            + self.kp.component_mul(&(reference.q - state.q))
    }
}

/// The larger magnitude of the two eigenvalues of `A - B [kp kd]`.
///
/// They are 1 - w with `w^2 - (a + b) w + 2 a = 0`, a = kp T^2/2 and b = kd T.
/// Written in w no digit is lost where T is short and both lie close to 1.
fn spectral_radius<T: Real>(kp: T, kd: T, period_s: T) -> T {
    let half = T::lit(0.5);
    let (a, b) = (kp * period_s * period_s * half, kd * period_s);
    let mean = (a + b) * half;
    let discriminant = mean * mean - (a + a);
    if discriminant < T::zero() {
        (T::one() + a - b).sqrt()
    } else {
        let root = discriminant.sqrt();
        let (fast, slow) = (T::one() - (mean + root), T::one() - (mean - root));
        // A comparison, unlike `max`, lets NaN through.
        if fast.abs() < slow.abs() {
            slow.abs()
        } else {
            fast.abs()
        }
    }
}

#[cfg(test)]
mod tests;
