//! Model of the observers: the arm's motion in one period.
//!
//! About upright the joints do not couple, so A and B are one block per joint,
//! and only these are kept: a third of the products.

use crate::arm::{Discrete, Parameters, Posture, State};
use crate::check_word::checked;
use crate::real::Real;
use armbridge_servo::JOINTS;
use nalgebra::{Matrix2, Vector2};

/// A discrete model about upright, with or without the gravity that a linear
/// model lacks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model<T> {
    axes: [Axis<T>; JOINTS],
    /// dG/dq upright, which the linear part already contains; `None` where the
    /// linear part is all there is.
    gravity_slope: Option<Matrix2<T>>,
}

/// One joint's share of A and B.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Axis<T> {
    a: Matrix2<T>,
    b: Vector2<T>,
}

checked!(Model<T> { axes, gravity_slope });
checked!(Axis<T> { a, b });

impl<T: Real> Model<T> {
    /// The exact discretisation of an arm, with its exact gravity.
    pub fn of_arm(arm: &Parameters<T>, period_s: T) -> Self {
        let upright = Vector2::zeros();
        Self {
            axes: axes(&arm.linearise(upright).zero_order_hold(period_s)),
            gravity_slope: Some(arm.gravity_slope(upright)),
        }
    }

    /// A linear model alone, as the paper's observer has it; what couples the
    /// joints in it, off upright, is left out.
    pub fn linear(discrete: &Discrete<T>) -> Self {
        Self {
            axes: axes(discrete),
            gravity_slope: None,
        }
    }

    /// The state one period later under a constant torque, for the arm that the
    /// model was made of, in this posture.
    #[inline]
    pub(super) fn step(
        &self,
        arm: &Parameters<T>,
        posture: &Posture<T>,
        from: &State<T>,
        torque: Vector2<T>,
    ) -> State<T> {
        let torque = match &self.gravity_slope {
            None => torque,
            // The torque that the linear part lacks.
            Some(slope) => torque + (slope * from.q - posture.gravity(arm)),
        };
        let [first, second] = &self.axes;
        let (q1, v1) = first.step(from.q.x, from.dq.x, torque.x);
        let (q2, v2) = second.step(from.q.y, from.dq.y, torque.y);
        State {
            q: Vector2::new(q1, q2),
            dq: Vector2::new(v1, v2),
        }
    }

    /// The state matrices of joints 1 and 2, angle before speed.
    pub(super) fn joints(&self) -> [Matrix2<T>; JOINTS] {
        [self.axes[0].a, self.axes[1].a]
    }
}

impl<T: Real> Axis<T> {
    #[inline]
    fn step(&self, q: T, v: T, torque: T) -> (T, T) {
        let (a, b) = (&self.a, &self.b);
        (
            a.m11 * q + a.m12 * v + b.x * torque,
            a.m21 * q + a.m22 * v + b.y * torque,
        )
    }
}

fn axes<T: Real>(discrete: &Discrete<T>) -> [Axis<T>; JOINTS] {
    let ([first, second], b) = (discrete.joints(), &discrete.b);
    [
        Axis {
            a: first,
            b: Vector2::new(b.m11, b.m31),
        },
        Axis {
            a: second,
            b: Vector2::new(b.m22, b.m42),
        },
    ]
}
