//! Checks of a fit: which numbers are identifiable, whether the residuals are noise, and
//! whether the model has the right form.
//!
//! | file        | what is asked                                                  |
//! |-------------|----------------------------------------------------------------|
//! | `identifiability` | which numbers are strongly correlated or not identifiable, and what fixed them |
//! | `whiteness` | do errors follow from each other?                              |
//! | `model_errors`      | would a torque that the model has not explain the logs better? |
//! | `rollout`    | a window's motion by the numbers that were found               |
//! | `warnings`  | what is to be kept in mind, in words                           |
//! | `text`      | the checks as text for a terminal                              |

mod identifiability;
mod model_errors;
mod rollout;
mod text;
mod warnings;
mod whiteness;

pub use identifiability::{Combination, Pair, correlations, untold};
pub use model_errors::{Dry, Form};
pub use rollout::Followed;
pub use whiteness::Whiteness;

pub(super) use rollout::follow;

use armbridge_shared::JOINTS;
use nalgebra::SMatrix;
use serde::Serialize;

use super::arm::Known;
use super::cost::{Stretch, cost};
use super::dataset::Trace;
use super::fit_result::Found;
use super::quantity::{COUNT, Quantity};
use super::search::Prior;
use super::stribeck_curve::Falling;

/// All of it.
#[derive(Clone, Debug, Serialize)]
pub struct Checks {
    /// What is to be kept in mind, in words.
    pub warnings: Vec<String>,
    /// Numbers that are strongly correlated.
    pub pairs: Vec<Pair>,
    /// What the logs do not tell.
    pub untold: Vec<Combination>,
    /// What is left of each joint.
    pub whiteness: Vec<Whiteness>,
    /// Torques that the model has not.
    pub forms: Vec<Form>,
    /// What would be found without dry friction.
    pub dry: Vec<Dry>,
    /// All windows, as they are followed.
    #[serde(skip)]
    pub followed: Vec<Followed>,
    /// The logs, smoothed with the zeros that were found.
    #[serde(skip)]
    pub traces: Vec<Trace>,
}

impl Checks {
    /// Of what was found in these traces.
    pub fn of(found: &Found, traces: &[Trace], known: &Known, prior: &Prior) -> Self {
        let zero = [0, 1].map(|joint| found.number(joint, Quantity::Zero).0);
        let traces: Vec<Trace> = traces
            .iter()
            .map(|trace| trace.smoothed(known, zero))
            .collect();
        let known = &known.with(&found.stribeck);
        let followed = followed(found, &traces, known);
        let (mut whiteness, mut forms, mut dry) = (Vec::new(), Vec::new(), Vec::new());
        for joint in 0..JOINTS {
            let windows = explained(found, &followed, joint);
            whiteness.push(Whiteness::of(joint, windows.iter().copied()));
            let (more, without) = model_errors::forms(joint, &windows, &traces, known, found);
            forms.extend(more);
            dry.push(without);
        }
        let mut checks = Self {
            warnings: Vec::new(),
            pairs: identifiability::pairs(found),
            untold: untold(&information(found, &traces, known), prior),
            whiteness,
            forms,
            dry,
            followed,
            traces,
        };
        checks.warnings = warnings::warnings(found, &checks);
        checks
    }
}

/// How a joint's dry friction falls with speed, roughly, if the logs surely show that it
/// does; traces are smoothed.
pub(super) fn falling(
    found: &Found,
    traces: &[Trace],
    known: &Known,
    joint: usize,
) -> Option<Falling> {
    let followed = followed(found, traces, known);
    let all = followed.iter().filter(|of| of.window.joint == joint);
    let all: Vec<&Followed> = all.collect();
    let explained = explained(found, &followed, joint);
    // Friction that falls far leaves hardly any window explained.
    let windows = if 2 * explained.len() < all.len() {
        &all
    } else {
        &explained
    };
    model_errors::falling(joint, windows, traces, known, found)
}

/// All windows; traces are smoothed.
fn followed(found: &Found, traces: &[Trace], known: &Known) -> Vec<Followed> {
    let follow = |stretch: &Stretch| {
        let window = &stretch.window;
        follow(window, &traces[window.trace], known, &found.at, window.len)
    };
    found.stretches.iter().map(follow).collect()
}

/// Those of a joint that the numbers explain.
fn explained<'a>(found: &Found, followed: &'a [Followed], joint: usize) -> Vec<&'a Followed> {
    let windows = followed.iter().zip(&found.stretches);
    let is_explained = |stretch: &Stretch| stretch.squares <= found.most * stretch.count as f64;
    let of_joint = windows
        .filter(|(followed, stretch)| followed.window.joint == joint && is_explained(stretch));
    of_joint.map(|(followed, _)| followed).collect()
}

/// What the logs alone tell of the numbers; traces are smoothed.
fn information(found: &Found, traces: &[Trace], known: &Known) -> SMatrix<f64, COUNT, COUNT> {
    let mut stretches = found.stretches.clone();
    let cost = cost(&mut stretches, traces, known, &found.at, found.most);
    let mut information = cost.hessian / found.noise_counts.powi(2);
    // That there is no dead zone does not show in a slope.
    for edge in Quantity::edges().filter(|edge| found.has_none(*edge)) {
        information[(edge, edge)] += found.covariance[(edge, edge)].recip();
    }
    information
}
