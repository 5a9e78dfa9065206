//! Static friction, from the torques at which a joint at rest breaks away.
//!
//! With all other parameters estimated, the applied torque on a joint at rest is known: motor
//! and gravity. Where the PWM changes slowly, the joint rests until the applied torque exceeds
//! static friction, and then slides.
//!
//! ```text
//! trace -> rests that end in sliding -> likelihood of each torque -> combined estimate
//!          rest.rs                      breakaway.rs                 likelihood.rs
//! ```

mod breakaway;
mod likelihood;
mod rest;

use armbridge_servo::JOINTS;
use nalgebra::{SMatrix, SVector};

use super::arm::KnownParameters;
use super::dataset::Trace;
use super::quantity::COUNT;
use breakaway::Breakaway;
use likelihood::TorqueLikelihood;

/// Fewest breakaways that identify a joint's static friction.
const BREAKAWAYS_MIN: usize = 2;

/// Estimated static friction of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StaticFriction {
    /// Torque in N m.
    pub torque_nm: f64,
    /// Standard error in N m.
    pub error_nm: f64,
    /// Number of breakaways.
    pub breakaways: usize,
}

/// Inputs of the estimate of static friction.
pub(super) struct StaticFrictionFit<'a> {
    /// Smoothed.
    pub(super) traces: &'a [Trace],
    pub(super) known: &'a KnownParameters,
    /// Coordinates of all other parameters, and their covariance.
    pub(super) coordinates: &'a [f64; COUNT],
    pub(super) covariance: &'a SMatrix<f64, COUNT, COUNT>,
    /// Standard deviation of the encoders' noise.
    pub(super) noise_counts: f64,
}

impl StaticFrictionFit<'_> {
    /// Static friction of each joint; `None` with too few breakaways.
    pub(super) fn estimate(&self) -> [Option<StaticFriction>; JOINTS] {
        core::array::from_fn(|joint| {
            let traces = self.traces.iter();
            let breakaways = traces.flat_map(|trace| {
                let rests = rest::rests(trace, self.known, joint).into_iter();
                rests.filter_map(move |rest| self.breakaway(trace, joint, rest))
            });
            let breakaways: Vec<Breakaway> = breakaways.collect();
            (breakaways.len() >= BREAKAWAYS_MIN).then(|| self.combine(&breakaways))
        })
    }

    /// Combines all breakaways. Their applied torques share the estimates of the other
    /// parameters, whose errors do not average out.
    fn combine(&self, breakaways: &[Breakaway]) -> StaticFriction {
        let likelihoods: Vec<TorqueLikelihood> = breakaways
            .iter()
            .map(|breakaway| breakaway.likelihood.clone())
            .collect();
        let [torque_nm, variance] = TorqueLikelihood::combined_moments(&likelihoods);
        let (mut gradient, mut total) = (SVector::<f64, COUNT>::zeros(), 0.0);
        for breakaway in breakaways {
            let [_, variance] = breakaway.likelihood.moments();
            gradient += breakaway.torque_gradient / variance;
            total += 1.0 / variance;
        }
        gradient /= total;
        let by_parameters = (gradient.transpose() * self.covariance * gradient)[0];
        StaticFriction {
            torque_nm,
            error_nm: (variance + by_parameters.max(0.0)).sqrt(),
            breakaways: breakaways.len(),
        }
    }
}
