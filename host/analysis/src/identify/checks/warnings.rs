//! Warnings about a fit, in words.

use super::super::dataset::encoder_noise_counts;
use super::super::fit_result::FitResult;
use super::Checks;
use super::model_errors::{NEGLIGIBLE_NM, SIGNIFICANT};

/// Ratio of residual to encoder noise above which it is not that noise alone.
const NOISE_RATIO: f64 = 1.15;
/// Largest tolerated fraction of outliers among the windows.
const OUTLIER_FRACTION: f64 = 0.05;

/// Warnings, a sentence each.
pub(super) fn warnings(fit: &FitResult, checks: &Checks) -> Vec<String> {
    let mut warnings = Vec::new();
    let encoder_counts = encoder_noise_counts(&checks.traces, checks.whiteness.len());
    if fit.noise_counts > NOISE_RATIO * encoder_counts {
        warnings.push(format!(
            "residual of {:.2} counts, above the encoders' noise of {encoder_counts:.2}: the model is \
             not quite this arm, and intervals may be too narrow",
            fit.noise_counts
        ));
    }
    let (outliers, windows) = (fit.outliers(), fit.window_fits.len());
    if outliers as f64 > OUTLIER_FRACTION * windows as f64 {
        warnings.push(format!(
            "{outliers} of {windows} windows are outliers, with less weight: the joint touched \
             something, or its friction changed"
        ));
    }
    for whiteness in checks
        .whiteness
        .iter()
        .filter(|whiteness| !whiteness.is_white())
    {
        warnings.push(format!(
            "joint {}: residuals are autocorrelated (portmanteau {:.0}; white noise: below \
             {:.0}): the model, or its delay, is not quite right",
            whiteness.joint, whiteness.portmanteau, whiteness.critical_value
        ));
    }
    for joint in 1..=checks.whiteness.len() {
        let of_joint = checks
            .missing_torques
            .iter()
            .filter(|missing| missing.joint == joint);
        let significant =
            of_joint.filter(|f| f.improvement > SIGNIFICANT && f.torque_nm > NEGLIGIBLE_NM);
        let largest = significant.max_by(|a, b| a.improvement.total_cmp(&b.improvement));
        warnings.extend(largest.map(|missing| {
            format!(
                "joint {joint}: the model lacks {} (sum of squares lower by {:.0} variances, \
                 torque up to {:.3} N m)",
                missing.description, missing.improvement, missing.torque_nm
            )
        }));
    }
    for fit in &checks.without_dry_friction {
        if fit.loss_increase < SIGNIFICANT {
            warnings.push(format!(
                "joint {}: dry friction is not identified; move the joint slower",
                fit.joint
            ));
        }
    }
    warnings
}
