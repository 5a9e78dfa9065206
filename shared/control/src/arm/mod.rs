//! The two-joint arm: parameters, dynamics, linearisation, discretisation.
//!
//! Joint 1 is fixed to the table and turns about x, joint 2 turns about y of
//! the upper link. At q = 0 both links point straight up, and that equilibrium
//! is unstable; of an arm that hangs they point straight down, and it is stable,
//! see [`Mounting`]. "Upright" in this crate means q = 0, however the arm is
//! mounted. Angles in rad, speeds in rad/s, torques in N m, SI throughout.
//!
//! The model is the one of the paper,
//!
//! ```text
//! M(q) ddq + (Co(q, dq) + F) dq + G(q) = torque                          (1)
//! ```
//!
//! in a reading that agrees with a Lagrangian derivation (rotations Rx(q1)
//! Ry(q2), centres of mass at half length). The printed equations differ from
//! it in five places:
//!
//! | equation   | printed                        | here, and why |
//! |------------|--------------------------------|---------------|
//! | (2) G      | a stray "2" below each row     | a denominator: each row is divided by 2 |
//! | (3) M(1,1) | no `M1 L1^2/4`                 | with it: G has that half link, and only so do the numbers of (7) come out, see [`Parameters::paper`] |
//! | (4) sign   | `Co = B`                       | `Co = -B`: with B itself, energy is not conserved. (4) is right if moved to the right-hand side |
//! | (4) B(2,1) | `L2/4`                         | `M2 L2^2/4`: as in B(1,1), and the only one with the right dimension |
//! | Table 1    | b1, b2 without unit            | N m s/rad. The b1 of the text (0.421, 0.239) are fits; (7) was made with 0.24 |
//!
//! | file           | content                                                 |
//! |----------------|---------------------------------------------------------|
//! | `parameters`   | [`Parameters`]: Table 1 as data; [`Mounting`]           |
//! | `posture`      | [`Posture`]: the terms of (1), sines and cosines shared |
//! | `dynamics`     | mass, Coriolis, gravity, acceleration, energy           |
//! | `linear`       | [`Linear`]: continuous A and B about a setpoint         |
//! | `discrete`     | [`Discrete`]: forward Euler, exact zero-order hold, (7) |

mod discrete;
mod dynamics;
mod linear;
mod parameters;
mod posture;

pub use discrete::Discrete;
pub use linear::Linear;
pub use parameters::{Mounting, Parameters};
pub use posture::Posture;

use crate::real::Real;
use nalgebra::{Vector2, Vector4};

/// Angles and speeds of both joints at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "snapshot", serde(bound = "T: crate::snapshot::Number"))]
pub struct State<T> {
    /// Joint angles in rad; 0 is upright, or straight down if the arm hangs.
    pub q: Vector2<T>,
    /// Joint speeds in rad/s.
    pub dq: Vector2<T>,
}

impl<T: Real> State<T> {
    /// At rest at these angles.
    pub fn at_rest(q: Vector2<T>) -> Self {
        Self {
            q,
            dq: Vector2::zeros(),
        }
    }

    /// The state vector x = [q1, q2, dq1, dq2] of equation (6).
    pub fn to_vector(self) -> Vector4<T> {
        Vector4::new(self.q.x, self.q.y, self.dq.x, self.dq.y)
    }

    /// The inverse of [`to_vector`](Self::to_vector).
    pub fn from_vector(x: Vector4<T>) -> Self {
        Self {
            q: Vector2::new(x.x, x.y),
            dq: Vector2::new(x.z, x.w),
        }
    }
}
