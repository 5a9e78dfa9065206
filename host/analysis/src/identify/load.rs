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

use super::profile::{FormFit, Point, Profile, SIGNIFICANT_SIGMAS, STEPS, TOLERANCE};
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

/// Step for finite differences.
const STEP: f64 = 0.01;
/// Longest Newton step.
const STEP_MAX: f64 = 0.1;

/// Fits the load friction of a joint; `None` if it is not identifiable.
pub(super) fn fit_load(
    stage: &Stage<'_>,
    mut coordinates: [f64; COUNT],
    joint: usize,
    initial: f64,
) -> Option<FormFit<LoadEstimate>> {
    let profile = Profile::new(stage, joint);
    let evaluate = |load: f64, coordinates: [f64; COUNT]| -> Point {
        let mut known = profile.known();
        known.load[joint] = load;
        profile.evaluate(&known, coordinates)
    };
    let mut load = initial;
    for _ in 0..STEPS {
        load = load.clamp(STEP, Friction::LOAD_MAX - STEP);
        let (loss, fitted) = evaluate(load, coordinates);
        coordinates = fitted;
        let [above, below] = [STEP, -STEP].map(|step| evaluate(load + step, coordinates));
        let gradient = (above.0 - below.0) / (2.0 * STEP);
        let curvature = (above.0 + below.0 - 2.0 * loss) / (STEP * STEP);
        // Without a minimum near by: downhill.
        let newton = if curvature > 0.0 {
            -gradient / curvature
        } else {
            -gradient.signum() * STEP_MAX
        };
        let step = newton.clamp(-STEP_MAX, STEP_MAX);
        load += step;
        // Predicted reduction of the loss: the last step needs no evaluation of its own.
        let reduction = -0.5 * gradient * step;
        if curvature <= 0.0 || reduction > TOLERANCE {
            coordinates = if above.0 < below.0 { above.1 } else { below.1 };
            continue;
        }
        // The loss is twice the negative logarithm of the likelihood.
        let variance = 2.0 / curvature;
        let sensitivity = profile.sensitivity(&above, &below, 2.0 * STEP);
        let error = variance.sqrt();
        return (load > SIGNIFICANT_SIGMAS * error).then(|| FormFit {
            estimate: LoadEstimate { load, error },
            own_coordinates: profile.own_coordinates(&coordinates, &(sensitivity * step)),
            covariance: sensitivity * sensitivity.transpose() * variance,
        });
    }
    None
}
