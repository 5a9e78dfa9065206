//! Checks of a fit: identifiability of the parameters, whiteness of the residuals, and
//! errors of the model.
//!
//! | file              | contents                                                        |
//! |-------------------|-----------------------------------------------------------------|
//! | `identifiability` | strongly correlated and unidentifiable parameters, and the prior that fixed them |
//! | `whiteness`       | autocorrelation of the residuals                                |
//! | `model_errors`    | torques that the model lacks, and the fit without dry friction  |
//! | `rollout`         | motion of a window, simulated with the estimates                |
//! | `warnings`        | warnings in words                                               |
//! | `text`            | the checks as text for a terminal                               |

mod identifiability;
mod model_errors;
mod rollout;
mod text;
mod warnings;
mod whiteness;

pub use identifiability::{Combination, Correlation};
pub use model_errors::{MissingTorque, WithoutDryFriction};
pub use rollout::Rollout;
pub use whiteness::Whiteness;

pub(super) use identifiability::correlation_matrix;
pub(super) use rollout::rollout;

use nalgebra::SMatrix;
use serde::Serialize;

use super::arm::KnownParameters;
use super::cost::{WindowFit, cost};
use super::dataset::Trace;
use super::fit_result::FitResult;
use super::friction_forms::FrictionForm;
use super::prior::Prior;
use super::quantity::{COUNT, Quantity};

/// All checks of a fit.
#[derive(Clone, Debug, Serialize)]
pub struct Checks {
    /// Warnings in words.
    pub warnings: Vec<String>,
    /// Strongly correlated parameters.
    pub correlations: Vec<Correlation>,
    /// Combinations of parameters that the logs do not identify.
    pub unidentifiable: Vec<Combination>,
    /// Whiteness of each joint's residuals.
    pub whiteness: Vec<Whiteness>,
    /// Torques that the model lacks.
    pub missing_torques: Vec<MissingTorque>,
    /// Fit of each joint without dry friction.
    pub without_dry_friction: Vec<WithoutDryFriction>,
    /// Rollouts of all windows.
    #[serde(skip)]
    pub rollouts: Vec<Rollout>,
    /// The logs, smoothed with the estimated encoder zeros.
    #[serde(skip)]
    pub traces: Vec<Trace>,
}

impl Checks {
    /// Checks a fit to these traces.
    pub fn new(fit: &FitResult, traces: &[Trace], known: &KnownParameters, prior: &Prior) -> Self {
        let traces = fit.smoothed(traces, known);
        let known = &known.with_friction(fit);
        let rollouts = rollouts(fit, &traces, known);
        let mut whiteness = Vec::new();
        let (mut missing_torques, mut without_dry_friction) = (Vec::new(), Vec::new());
        for joint in 0..known.joints {
            let windows = explained(fit, &rollouts, joint);
            whiteness.push(Whiteness::new(joint, windows.iter().copied()));
            let (missing, without) =
                model_errors::model_errors(joint, &windows, &traces, known, fit);
            missing_torques.extend(missing);
            without_dry_friction.push(without);
        }
        let information = information(fit, &traces, known);
        let mut checks = Self {
            warnings: Vec::new(),
            correlations: identifiability::strong_correlations(fit),
            unidentifiable: identifiability::unidentifiable(&information, prior, known.joints),
            whiteness,
            missing_torques,
            without_dry_friction,
            rollouts,
            traces,
        };
        checks.warnings = warnings::warnings(fit, &checks);
        checks
    }
}

/// Initial guess of the form of a joint's dry friction for which the test is most significant,
/// beside those that it has; traces are smoothed.
pub(super) fn friction_candidate(
    fit: &FitResult,
    traces: &[Trace],
    known: &KnownParameters,
    joint: usize,
) -> Option<FrictionForm> {
    let rollouts = rollouts(fit, traces, known);
    let is_of_joint = |rollout: &&Rollout| rollout.window.joint == joint;
    let all: Vec<&Rollout> = rollouts.iter().filter(is_of_joint).collect();
    let explained = explained(fit, &rollouts, joint);
    // With much of it hardly any window is explained.
    let windows = if 2 * explained.len() < all.len() {
        &all
    } else {
        &explained
    };
    model_errors::friction_candidate(joint, windows, traces, known, fit)
}

/// Rollouts of all windows; traces are smoothed.
fn rollouts(fit: &FitResult, traces: &[Trace], known: &KnownParameters) -> Vec<Rollout> {
    let rollout = |window_fit: &WindowFit| {
        let window = &window_fit.window;
        let trace = &traces[window.trace];
        rollout(window, trace, known, &fit.coordinates, window.len)
    };
    fit.window_fits.iter().map(rollout).collect()
}

/// Rollouts of a joint's windows that are no outliers.
fn explained<'a>(fit: &FitResult, rollouts: &'a [Rollout], joint: usize) -> Vec<&'a Rollout> {
    let limit = fit.outlier_limit_counts2;
    let windows = rollouts.iter().zip(&fit.window_fits);
    let of_joint = windows.filter(|(rollout, window_fit)| {
        rollout.window.joint == joint && window_fit.is_explained(limit)
    });
    of_joint.map(|(rollout, _)| rollout).collect()
}

/// Information matrix of the logs alone; traces are smoothed.
fn information(
    fit: &FitResult,
    traces: &[Trace],
    known: &KnownParameters,
) -> SMatrix<f64, COUNT, COUNT> {
    let mut window_fits = fit.window_fits.clone();
    let limit = fit.outlier_limit_counts2;
    let cost = cost(&mut window_fits, traces, known, &fit.coordinates, limit);
    let mut information = cost.hessian / fit.noise_counts.powi(2);
    // The gradient does not show that there is no dead zone.
    for edge in Quantity::dead_zone_edges().filter(|edge| fit.has_no_dead_zone(*edge)) {
        information[(edge, edge)] += fit.covariance[(edge, edge)].recip();
    }
    information
}
