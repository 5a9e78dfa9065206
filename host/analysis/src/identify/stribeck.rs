//! Fit of a Stribeck curve, dry friction that falls with speed, where the logs show one.
//!
//! ```text
//! F(v) = coulomb + drop exp(-(v / speed)²)
//! ```
//!
//! The curve has two more parameters per joint. Most arms have none, and without a drop the
//! speed is not identifiable. So they are fitted after all others, and only where the linear
//! test of [`Checks`](super::Checks) for such a torque is significant. For each drop and
//! speed the other parameters are fitted again ([`Profile`]), in the logarithms of both.

use nalgebra::{Matrix2, SMatrix, Vector2};
use serde::Serialize;

use super::profile::{FormFit, Point, Profile, SIGNIFICANT_SIGMAS, STEPS, TOLERANCE};
use super::quantity::COUNT;
use super::stage::Stage;
use super::stribeck_curve::StribeckCurve;

/// Estimated Stribeck curve of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StribeckEstimate {
    /// Drop of dry friction from rest to full speed, in N m.
    pub drop_nm: f64,
    /// Standard error of the drop.
    pub drop_error_nm: f64,
    /// Speed at which it has fallen to 1/e, in rad/s.
    pub speed_rad_s: f64,
    /// Standard error of the speed.
    pub speed_error_rad_s: f64,
}

impl StribeckEstimate {
    pub(super) fn curve(&self) -> StribeckCurve {
        StribeckCurve {
            drop_nm: self.drop_nm,
            speed_rad_s: self.speed_rad_s,
        }
    }
}

/// Step of a logarithm for finite differences.
const STEP: f64 = 0.15;
/// Longest Newton step.
const STEP_MAX: f64 = 0.8;
/// Largest relative standard error of the speed.
const SPEED_ERROR_MAX: f64 = 0.5;

/// Fits the Stribeck curve of a joint; `None` if it is not identifiable.
pub(super) fn fit_stribeck(
    stage: &Stage<'_>,
    mut coordinates: [f64; COUNT],
    joint: usize,
    initial: StribeckCurve,
) -> Option<FormFit<StribeckEstimate>> {
    let profile = Profile::new(stage, joint);
    let evaluate = |logarithms: Vector2<f64>, coordinates: [f64; COUNT]| -> Point {
        let mut known = profile.known();
        known.stribeck[joint] = Some(curve(logarithms));
        profile.evaluate(&known, coordinates)
    };
    let mut logarithms = Vector2::new(initial.drop_nm, initial.speed_rad_s).map(f64::ln);
    let [e1, e2] = [Vector2::x(), Vector2::y()].map(|e| e * STEP);
    for _ in 0..STEPS {
        let middle = evaluate(logarithms, coordinates);
        let loss = middle.loss;
        coordinates = middle.coordinates;
        let sides = [e1, -e1, e2, -e2, e1 + e2, -e1 - e2];
        let neighbours = sides.map(|side| evaluate(logarithms + side, coordinates));
        let [right, left, up, down, one, two] =
            neighbours.each_ref().map(|neighbour| neighbour.loss);
        let gradient = Vector2::new(right - left, up - down) / (2.0 * STEP);
        let square = STEP * STEP;
        let by_drop = (right + left - 2.0 * loss) / square;
        let by_speed = (up + down - 2.0 * loss) / square;
        let by_both = ((one + two - 2.0 * loss) / square - by_drop - by_speed) / 2.0;
        let hessian = Matrix2::new(by_drop, by_both, by_both, by_speed);
        let inverse = hessian.cholesky().map(|cholesky| cholesky.inverse());
        // Without a minimum near by: steepest descent.
        let newton = inverse.map_or(gradient * -1e6, |inverse| -(inverse * gradient));
        let step = newton * (STEP_MAX / newton.norm()).min(1.0);
        let best = neighbours.iter().min_by(|a, b| a.loss.total_cmp(&b.loss));
        logarithms += step;
        // Predicted reduction of the loss: the last step needs no evaluation of its own.
        let reduction = -0.5 * gradient.dot(&step);
        if inverse.is_none() || reduction > TOLERANCE {
            coordinates = best.map_or(coordinates, |best| best.coordinates);
            continue;
        }
        // The loss is twice the negative logarithm of the likelihood.
        let covariance = inverse? * 2.0;
        let curve = curve(logarithms);
        let [drop, speed] = [0, 1].map(|i| covariance[(i, i)].sqrt());
        let [right, left, up, down, ..] = &neighbours;
        let sensitivity = SMatrix::from_columns(&[
            profile.sensitivity(right, left, 2.0 * STEP),
            profile.sensitivity(up, down, 2.0 * STEP),
        ]);
        let estimate = StribeckEstimate {
            drop_nm: curve.drop_nm,
            drop_error_nm: curve.drop_nm * drop,
            speed_rad_s: curve.speed_rad_s,
            speed_error_rad_s: curve.speed_rad_s * speed,
        };
        let is_identified = SIGNIFICANT_SIGMAS * drop < 1.0 && speed < SPEED_ERROR_MAX;
        return is_identified.then(|| FormFit {
            estimate,
            own_coordinates: profile.own_coordinates(&coordinates, &(sensitivity * step)),
            covariance: sensitivity * covariance * sensitivity.transpose(),
        });
    }
    None
}

/// Curve of these logarithms of drop and speed.
fn curve(logarithms: Vector2<f64>) -> StribeckCurve {
    let [drop_nm, speed_rad_s] = logarithms.map(f64::exp).into();
    StribeckCurve {
        drop_nm,
        speed_rad_s,
    }
}
