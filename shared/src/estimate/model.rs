//! What the estimators believe the arm does in one period.

use crate::arm::{Discrete, Parameters, State};
use crate::real::Real;
use nalgebra::{Matrix2, Vector2};

/// A discrete model about upright, with or without the gravity that a linear
/// model lacks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model<T> {
    /// The linear part.
    pub discrete: Discrete<T>,
    gravity: Option<Gravity<T>>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Gravity<T> {
    arm: Parameters<T>,
    /// dG/dq upright: what the linear part already contains.
    slope: Matrix2<T>,
}

impl<T: Real> Model<T> {
    /// The exact discretisation of an arm, with its exact gravity.
    pub fn of_arm(arm: &Parameters<T>, period_s: T) -> Self {
        let upright = Vector2::zeros();
        Self {
            discrete: arm.linearise(upright).zero_order_hold(period_s),
            gravity: Some(Gravity {
                arm: *arm,
                slope: arm.gravity_slope(upright),
            }),
        }
    }

    /// A linear model alone, as the paper's observer has it.
    pub fn linear(discrete: Discrete<T>) -> Self {
        Self {
            discrete,
            gravity: None,
        }
    }

    /// The state one period later under a constant torque.
    pub(super) fn step(&self, from: &State<T>, torque: Vector2<T>) -> State<T> {
        let gravity = self.gravity.map_or_else(Vector2::zeros, |gravity| {
            gravity.slope * from.q - gravity.arm.gravity(from.q)
        });
        State::from_vector(self.discrete.step(from.to_vector(), torque + gravity))
    }
}
