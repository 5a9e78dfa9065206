//! What is to be kept in mind of a fit, in words.

use super::super::fit_result::Found;
use super::Checks;
use super::model_errors::{SMALL_NM, SURE};

/// Noise in counts beyond which something other than noise is in it.
const NOISE_COUNTS: f64 = 1.2;
/// Share of the windows that may be without explanation.
const ODD: f64 = 0.05;

/// One sentence for each.
pub(super) fn warnings(found: &Found, checks: &Checks) -> Vec<String> {
    let mut warnings = Vec::new();
    if found.noise_counts > NOISE_COUNTS {
        warnings.push(format!(
            "errors of {:.2} counts are more than an encoder's noise: the model is not quite this \
             arm, and intervals may be too narrow",
            found.noise_counts
        ));
    }
    let (odd, windows) = (found.odd(), found.stretches.len());
    if odd as f64 > ODD * windows as f64 {
        warnings.push(format!(
            "{odd} of {windows} windows are not explained, and count less: the joint met \
             something, or its friction changed"
        ));
    }
    for whiteness in checks
        .whiteness
        .iter()
        .filter(|whiteness| !whiteness.is_white())
    {
        warnings.push(format!(
            "joint {}: errors follow from those before (portmanteau {:.0}, noise stays below \
             {:.0}): the form of the model, or its delay, is not quite right",
            whiteness.joint, whiteness.portmanteau, whiteness.expected
        ));
    }
    for joint in 1..=checks.whiteness.len() {
        let of_joint = checks.forms.iter().filter(|form| form.joint == joint);
        let matters = of_joint.filter(|f| f.improvement > SURE && f.torque_nm > SMALL_NM);
        let most = matters.max_by(|a, b| a.improvement.total_cmp(&b.improvement));
        warnings.extend(most.map(|form| {
            format!(
                "joint {joint}: the model lacks {} (sum of squares lower by {:.0} variances, \
                 torque up to {:.3} N m)",
                form.what, form.improvement, form.torque_nm
            )
        }));
    }
    for dry in &checks.dry {
        if dry.worse < SURE {
            warnings.push(format!(
                "joint {}: dry friction is not identified; move the joint slower",
                dry.joint
            ));
        }
    }
    warnings
}
