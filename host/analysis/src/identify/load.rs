//! Fit of load friction, dry friction that grows with the torque on the gears, where the logs show it.
//!
//! ```text
//! F = coulomb + load |motor - viscous v + weight|
//! ```
//!
//! Most arms have none, or too little to be seen. So it is fitted after all other parameters, and only
//! where the linear test of [`Checks`](super::Checks) for such a torque is significant. For each load
//! the other parameters are fitted again, in the joint's own windows. Near the minimum the loss is a
//! quadratic form in the load: a few Newton steps find it, and its curvature gives the variance.

use armbridge_sim::plant::Friction;
use nalgebra::{SMatrix, SVector};
use serde::Serialize;

use super::cost::WindowFit;
use super::quantity::{COUNT, PER_JOINT};
use super::stage::Stage;

/// Estimated load friction of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LoadEstimate {
    /// Dry friction in N m per N m that the gears transmit.
    pub load: f64,
    /// Its standard error.
    pub error: f64,
}

/// Result of the fit.
pub(super) struct LoadFit {
    pub(super) estimate: LoadEstimate,
    /// The joint's other coordinates at the minimum.
    pub(super) own_coordinates: [f64; PER_JOINT],
    /// Covariance that the uncertainty of the load adds to the other parameters.
    pub(super) covariance: SMatrix<f64, COUNT, COUNT>,
}

/// Step for finite differences.
const STEP: f64 = 0.01;
/// Longest Newton step.
const STEP_MAX: f64 = 0.1;
/// Most Newton steps.
const STEPS: usize = 8;
/// Reduction of the loss by the last step: a third of a standard error.
const TOLERANCE: f64 = 0.1;
/// Standard errors by which a significant load exceeds zero.
const SIGNIFICANT_SIGMAS: f64 = 3.0;

/// Loss as a function of the load.
struct LossCurve<'a> {
    stage: &'a Stage<'a>,
    window_fits: Vec<WindowFit>,
    joint: usize,
}

impl LossCurve<'_> {
    /// Loss at this load, and the other coordinates fitted there.
    fn evaluate(&self, load: f64, coordinates: [f64; COUNT]) -> (f64, [f64; COUNT]) {
        let mut known = *self.stage.known;
        known.load[self.joint] = load;
        let stage = Stage {
            known: &known,
            window_fits: Vec::new(),
            ..*self.stage
        };
        let search = stage.search_in(self.window_fits.clone(), coordinates);
        let search = search.minimise_briefly();
        (search.loss(), search.coordinates())
    }
}

/// Fits the load friction of a joint; `None` if it is not identifiable.
pub(super) fn fit_load(
    stage: &Stage<'_>,
    mut coordinates: [f64; COUNT],
    joint: usize,
    initial: f64,
) -> Option<LoadFit> {
    let curve = LossCurve {
        stage,
        window_fits: stage.joint_window_fits(joint),
        joint,
    };
    let mut load = initial;
    for _ in 0..STEPS {
        load = load.clamp(STEP, Friction::LOAD_MAX - STEP);
        let (loss, fitted) = curve.evaluate(load, coordinates);
        coordinates = fitted;
        let [above, below] = [STEP, -STEP].map(|step| curve.evaluate(load + step, coordinates));
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
        let sensitivity = SVector::<f64, COUNT>::from_fn(|i, _| {
            let is_own = i / PER_JOINT == joint;
            if is_own {
                (above.1[i] - below.1[i]) / (2.0 * STEP)
            } else {
                0.0
            }
        });
        let error = variance.sqrt();
        return (load > SIGNIFICANT_SIGMAS * error).then(|| LoadFit {
            estimate: LoadEstimate { load, error },
            own_coordinates: core::array::from_fn(|i| {
                let i = joint * PER_JOINT + i;
                coordinates[i] + sensitivity[i] * step
            }),
            covariance: sensitivity * sensitivity.transpose() * variance,
        });
    }
    None
}
