//! Either control law, chosen at run time, following a moving reference.

use super::{ComputedTorque, Lqr, Reference};
use crate::arm::{Parameters, Posture, State};
use crate::check_word::{CheckWord, Checked};
use crate::real::Real;
use nalgebra::Vector2;

/// From state and reference to torque.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Controller<T> {
    /// State feedback (9) about the reference, with the torque that the
    /// reference itself takes: `u = ID(q_r, dq_r, ddq_r) - K (x - x_r)`, ID being
    /// equation (1). At rest that is `G(q_r)`.
    StateFeedback(Lqr<T>),
    /// Feedback linearisation.
    ComputedTorque(ComputedTorque<T>),
}

impl<T: Checked> Checked for Controller<T> {
    fn check(&self, sum: &mut CheckWord) {
        match self {
            Self::StateFeedback(lqr) => lqr.check(sum),
            Self::ComputedTorque(gains) => gains.check(sum),
        }
    }
}

/// What a control law asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Demand<T> {
    /// Joint torques in N m.
    pub torque_nm: Vector2<T>,
    /// The share of them, in N m, that corrects errors.
    pub feedback_nm: Vector2<T>,
}

impl<T: Real> Controller<T> {
    /// The demand for the state and the reference of one instant.
    pub fn demand(
        &self,
        arm: &Parameters<T>,
        state: &State<T>,
        reference: &Reference<T>,
    ) -> Demand<T> {
        match self {
            Self::StateFeedback(lqr) => {
                let feedback_nm = lqr.feedback(state, &reference.state());
                let posture = Posture::of(reference.q);
                let forward_nm = posture.inverse_dynamics(arm, reference.dq, reference.ddq);
                Demand {
                    torque_nm: forward_nm + feedback_nm,
                    feedback_nm,
                }
            }
            Self::ComputedTorque(law) => law.demand(arm, state, reference),
        }
    }
}
