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

    /// A state together with what the model needs to leave it.
    pub(super) fn at(&self, state: State<T>) -> Known<T> {
        let gravity = self.gravity.map_or_else(Vector2::zeros, |gravity| {
            gravity.slope * state.q - gravity.arm.gravity(state.q)
        });
        Known { state, gravity }
    }

    /// The state one period after a known one.
    pub(super) fn step(&self, from: &Known<T>, torque: Vector2<T>) -> State<T> {
        State::from_vector(
            self.discrete
                .step(from.state.to_vector(), torque + from.gravity),
        )
    }
}

/// A state, and the gravity torque there that the linear model lacks: found
/// once per tick, used by the prediction of this tick and the update of the
/// next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Known<T> {
    pub(super) state: State<T>,
    gravity: Vector2<T>,
}
