//! Linear-quadratic state feedback about a setpoint, equation (9):
//!
//! ```text
//! u = G(q_ref) - K (x - x_ref)        x_ref = [q_ref, 0]
//! ```
//!
//! `G(q_ref)` is the torque that holds the arm at the setpoint, so that there is
//! no error at rest for K to work against. The gain is designed about upright
//! and used about every setpoint near it.
//!
//! Nothing is clamped here: the torque is what is asked for, and what the servo
//! can give is the business of the [`actuator`](crate::actuator).

use crate::arm::{Discrete, Parameters, State};
use crate::check_word::checked;
use crate::design::riccati;
use crate::real::Real;
use nalgebra::{Matrix2, Matrix2x4, Matrix4, Vector2, Vector4};

/// Largest weight: far more than any arm needs, and little enough for the gain's design in
/// single precision.
pub const WEIGHT_MAX: f64 = 1e6;

/// Diagonals of the cost, equation (8).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights<T> {
    /// Diagonal of Q: both angles, then both speeds.
    pub q: [T; 4],
    /// Diagonal of R: both torques.
    pub r: [T; 2],
}

impl<T: Real> Weights<T> {
    /// Whether none is beyond [`WEIGHT_MAX`], or not a number.
    pub fn is_valid(&self) -> bool {
        let limit = T::lit(WEIGHT_MAX);
        let mut all = self.q.iter().chain(&self.r);
        all.all(|weight| weight.abs() <= limit)
    }

    /// Equation (8): Q = diag(15, 15, 1, 1), R = diag(10, 10).
    pub fn paper() -> Self {
        let [angle, speed, torque] = [15.0, 1.0, 10.0].map(T::lit);
        Self {
            q: [angle, angle, speed, speed],
            r: [torque, torque],
        }
    }
}

/// The gain K.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lqr<T> {
    /// Rows: torques; columns: both angles, then both speeds.
    pub gain: Matrix2x4<T>,
}

checked!(Lqr<T> { gain });

impl<T: Real> Lqr<T> {
    /// Equation (10) as printed, meant for 45 ms: the optimum for (7) and (8),
    /// cut (not rounded) to two decimals.
    pub fn paper() -> Self {
        let o = T::zero();
        Self {
            #[rustfmt::skip]
            gain: Matrix2x4::new(
                T::lit(1.65), o, T::lit(0.22), o,
                o, T::lit(1.10), o, T::lit(0.20),
            ),
        }
    }

    /// A gain set by the user, one row a torque.
    pub fn of_rows(first: [T; 4], second: [T; 4]) -> Self {
        Self {
            gain: Matrix2x4::from_rows(&[first.into(), second.into()]),
        }
    }

    /// The optimal gain for a model and weights.
    ///
    /// ```
    /// use armbridge_control::arm::Parameters;
    /// use armbridge_control::controller::{Lqr, Weights};
    /// use armbridge_control::design::stability;
    /// use nalgebra::Vector2;
    ///
    /// let arm = Parameters::<f64>::paper();
    /// let model = arm.linearise(Vector2::zeros()).zero_order_hold(1e-3);
    /// let lqr = Lqr::design(&model, &Weights::paper()).unwrap();
    ///
    /// let radius = |matrix| stability::dominant(&matrix).unwrap().radius();
    /// assert!(radius(model.a) > 1.0, "the arm falls without control");
    /// assert!(radius(model.a - model.b * lqr.gain) < 1.0);
    ///
    /// let free_torque = Weights { r: [0.0; 2], ..Weights::paper() };
    /// assert!(Lqr::design(&model, &free_torque).is_err());
    /// ```
    ///
    /// # Errors
    ///
    /// See [`riccati::Error`].
    pub fn design(model: &Discrete<T>, weights: &Weights<T>) -> Result<Self, riccati::Error> {
        let q = Matrix4::from_diagonal(&Vector4::from(weights.q));
        let r = Matrix2::from_diagonal(&Vector2::from(weights.r));
        riccati::solve(&model.a, &model.b, &q, &r).map(|solution| Self {
            gain: solution.gain,
        })
    }

    /// The torque in N m for a state.
    pub fn torque(&self, state: &State<T>, setpoint: &Setpoint<T>) -> Vector2<T> {
        setpoint.torque + self.feedback(state, &State::at_rest(setpoint.q))
    }

    /// The share of it that corrects errors: `-K (x - x_ref)` for any reference.
    pub fn feedback(&self, state: &State<T>, reference: &State<T>) -> Vector2<T> {
        let lag = State {
            q: reference.q - state.q,
            dq: reference.dq - state.dq,
        };
        self.gain * lag.to_vector()
    }
}

/// Rest at given joint angles, and the torque that it takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setpoint<T> {
    q: Vector2<T>,
    torque: Vector2<T>,
}

impl<T: Real> Setpoint<T> {
    /// Computes the holding torque; once per setpoint, not per tick.
    pub fn new(arm: &Parameters<T>, q: Vector2<T>) -> Self {
        Self {
            q,
            torque: arm.gravity(q),
        }
    }

    /// The joint angles in rad.
    pub fn q(&self) -> Vector2<T> {
        self.q
    }

    /// The torque in N m that holds the arm there.
    pub fn torque(&self) -> Vector2<T> {
        self.torque
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arm::Mounting;
    use crate::design::stability;

    /// A hanging arm is stable by itself, and needs smaller gains on its angles.
    #[test]
    fn an_arm_that_hangs_has_a_gain_of_its_own() {
        let weights = Weights {
            q: [15.0, 15.0, 1.0, 1.0],
            r: [10.0, 10.0],
        };
        for period_s in [600e-6, 1e-3, 45e-3, 100e-3] {
            let [standing, hanging] = [Mounting::Upright, Mounting::Hanging].map(|mounting| {
                let arm = Parameters::<f32> {
                    mounting,
                    ..Parameters::paper()
                };
                let model = arm.linearise(Vector2::zeros()).zero_order_hold(period_s);
                let lqr = Lqr::design(&model, &weights).unwrap();
                let closed = model.a - model.b * lqr.gain;
                let radius = stability::dominant(&closed).unwrap().radius();
                assert!(radius < 1.0, "{mounting:?}, {period_s} s: {radius}");
                lqr.gain
            });
            for joint in 0..2 {
                let (less, more) = (hanging[(joint, joint)], standing[(joint, joint)]);
                assert!(0.0 < less && less < more, "{period_s} s: {less}, {more}");
            }
        }
    }
}
