//! Either control law, chosen at run time, following a moving reference.

use super::{ComputedTorque, Demand, Lqr};
use crate::arm::{Parameters, Posture, State};
use crate::check_word::{CheckWord, Checked};
use crate::real::Real;
use crate::trajectory::Reference;
use nalgebra::{Matrix2x4, Vector2};

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

impl<T: Real> Controller<T> {
    /// The torque in N m that the reference itself takes; zero from a law that works it
    /// out at the state.
    pub fn feed_forward(&self, arm: &Parameters<T>, reference: &Reference<T>) -> Vector2<T> {
        match self {
            Self::StateFeedback(_) => {
                Posture::of(reference.q).inverse_dynamics(arm, reference.dq, reference.ddq)
            }
            Self::ComputedTorque(_) => Vector2::zeros(),
        }
    }

    /// The gain K that the law has upright: rows are torques, columns both angles, then both
    /// speeds.
    pub fn upright_gain(&self, arm: &Parameters<T>) -> Matrix2x4<T> {
        match self {
            Self::StateFeedback(lqr) => lqr.gain,
            Self::ComputedTorque(law) => law.upright_gain(arm),
        }
    }

    /// The demand for the state and the reference of one instant, with the reference's
    /// [feed-forward](Self::feed_forward) in N m.
    pub fn demand(
        &self,
        arm: &Parameters<T>,
        state: &State<T>,
        reference: &Reference<T>,
        forward_nm: Vector2<T>,
    ) -> Demand<T> {
        match self {
            Self::StateFeedback(lqr) => {
                let feedback_nm = lqr.feedback(state, &reference.state());
                Demand {
                    torque_nm: forward_nm + feedback_nm,
                    feedback_nm,
                }
            }
            Self::ComputedTorque(law) => law.demand(arm, state, reference),
        }
    }
}
