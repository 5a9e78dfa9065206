//! Fit of load friction, dry friction that grows with the torque on the gears, where the logs show it.
//!
//! ```text
//! F = coulomb + load |motor - viscous v + weight|
//! ```
//!
//! Most arms have none, or too little to be seen. So it is fitted after all other parameters, and only
//! where the linear test of [`Checks`](super::Checks) for such a torque is significant. For each load
//! the other parameters are fitted again ([`Profile`]).

use armbridge_sim::plant::Friction;
use serde::Serialize;

use super::profile::{FormFit, Point, Profile, SIGNIFICANT_SIGMAS};
use super::quantity::COUNT;
use super::stage::Stage;

/// Estimated load friction of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LoadEstimate {
    /// Dry friction in N m per N m that the gears transmit.
    pub load: f64,
    /// Its standard error.
    pub error: f64,
}

impl LoadEstimate {
    /// An initial guess.
    pub(super) const fn guess(load: f64) -> Self {
        Self {
            load,
            error: f64::INFINITY,
        }
    }
}

/// Initial distance between the points, unless the guess has a standard error.
const HALF_WIDTH: f64 = 0.02;
/// Least distance, about half a standard error: nearer, the loss of some logs jumps, that of the plant
/// `pendulum` by 1400 within 10⁻⁸, and a parabola through a jump has any width.
const HALF_WIDTH_MIN: f64 = 3e-4;
/// Largest rise of the loss from the middle to the outer points at the end: three standard errors.
const RISE_MAX: f64 = 9.0;
/// Rise at which the distance aims.
const RISE: f64 = 4.0;
/// Most steps.
const STEPS: usize = 16;

/// Fits the load friction of a joint; `None` if it is not identifiable.
///
/// The loss is evaluated at three points, which move downhill until the least is in the middle, and
/// then approach each other until the loss between them is a parabola.
pub(super) fn fit_load(
    stage: &Stage<'_>,
    coordinates: [f64; COUNT],
    joint: usize,
    initial: LoadEstimate,
) -> Option<FormFit<LoadEstimate>> {
    let profile = Profile::new(stage, joint);
    let evaluate = |load: f64, coordinates: [f64; COUNT]| -> Point {
        let mut known = profile.known();
        known.load[joint] = load;
        profile.evaluate(&known, coordinates)
    };
    let mut half = (RISE.sqrt() * initial.error).clamp(HALF_WIDTH_MIN, HALF_WIDTH);
    let mut load = initial.load.clamp(half, Friction::LOAD_MAX - half);
    let around = |load: f64, half: f64, coordinates: [f64; COUNT]| -> [Point; 3] {
        let middle = evaluate(load, coordinates);
        let [below, above] = [-half, half].map(|step| evaluate(load + step, middle.coordinates));
        [below, middle, above]
    };
    let [mut below, mut middle, mut above] = around(load, half, coordinates);
    for _ in 0..STEPS {
        if below.loss < middle.loss.min(above.loss) {
            load -= half;
            let next = evaluate(load - half, below.coordinates);
            [below, middle, above] = [next, below, middle];
            continue;
        }
        if above.loss < middle.loss {
            load += half;
            let next = evaluate(load + half, above.coordinates);
            [below, middle, above] = [middle, above, next];
            continue;
        }
        let gradient = (above.loss - below.loss) / (2.0 * half);
        let curvature = (above.loss + below.loss - 2.0 * middle.loss) / (half * half);
        let step = -gradient / curvature;
        load += step;
        let rise = 0.5 * curvature * half * half;
        if rise > RISE_MAX && half > HALF_WIDTH_MIN {
            half = (half * (RISE / rise).sqrt().clamp(0.1, 0.5)).max(HALF_WIDTH_MIN);
            [below, middle, above] = around(load, half, middle.coordinates);
            continue;
        }
        let sensitivity = profile.sensitivity(&above, &below, 2.0 * half);
        let variance = Profile::variance(curvature, &above, &below, 2.0 * half);
        let error = variance.sqrt();
        return (load > SIGNIFICANT_SIGMAS * error).then(|| FormFit {
            estimate: LoadEstimate { load, error },
            own_coordinates: profile.own_coordinates(&middle.coordinates, &(sensitivity * step)),
            covariance: sensitivity * sensitivity.transpose() * variance,
        });
    }
    None
}
