//! Acceptance: whether the estimates are certain enough for control.
//!
//! Control tolerates parameters with errors of a few percent. An inertia or a motor gain with
//! an error by a factor of two exhausts its stability margins, however good the estimate.

use super::quantity::Quantity;
use super::report::{Estimate, Report};

/// Largest relative half-width of a 95 % interval for the design of gains: the disc margins
/// of the default gains tolerate an error of the loop gain by half, in part for other errors.
const RELATIVE_MAX: f64 = 0.2;
/// Largest half-width for an encoder zero in counts. Near upright an error of the zero is
/// compensated by an opposite error of the motor offset: the torques are right, but the arm
/// leans by the error. 50 counts are 15°, beyond the vicinity of upright.
const ZERO_MAX_COUNTS: f64 = 50.0;
/// Half-width for an encoder zero worth a note: 10 counts are 3°, a visible lean.
const ZERO_NOTE_COUNTS: f64 = 10.0;

/// Parameters that control needs, their largest half-width, and an experiment that identifies
/// them.
const REQUIRED: [(Quantity, f64, &str); 4] = [
    (
        Quantity::Inertia,
        RELATIVE_MAX,
        "fast motion, such as a multisine up to 2 Hz or a PRBS of the joint",
    ),
    (
        Quantity::Gain,
        RELATIVE_MAX,
        "wide and slow motion against gravity, such as a multisine of the joint",
    ),
    (
        Quantity::Gravity,
        RELATIVE_MAX,
        "wide motion of the joint, and masses and lengths that were measured (--weighed)",
    ),
    (
        Quantity::Zero,
        ZERO_MAX_COUNTS,
        "slow motion to both sides of upright, or `armbridge calibrate`",
    ),
];

/// A parameter that is too uncertain for control.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "joint {joint}'s {name} has a 95 % interval of ±{}, and control needs ±{}; to identify it: \
     {remedy}",
    amount(*.half_width, *.is_relative),
    amount(*.required, *.is_relative)
)]
pub struct UncertainParameter {
    /// Joint, from 1.
    pub joint: usize,
    /// Name of the parameter.
    pub name: &'static str,
    /// Half-width of its 95 % interval: relative, or in counts.
    pub half_width: f64,
    /// Largest half-width for control.
    pub required: f64,
    /// Whether these are relative.
    pub is_relative: bool,
    /// Experiment that identifies it.
    pub remedy: &'static str,
}

fn amount(value: f64, is_relative: bool) -> String {
    if !value.is_finite() {
        "infinity".into()
    } else if is_relative {
        format!("{:.0} %", 100.0 * value)
    } else {
        format!("{value:.1} counts")
    }
}

impl Report {
    /// Parameters that are too uncertain for control.
    pub fn too_uncertain(&self) -> Vec<UncertainParameter> {
        let uncertain = self.estimates.iter().filter_map(|estimate| {
            let (quantity, required, remedy) = REQUIRED
                .into_iter()
                .find(|(quantity, ..)| quantity.name() == estimate.name)?;
            let is_relative = quantity.is_relative();
            let scale = if is_relative {
                estimate.value.abs()
            } else {
                1.0
            };
            let half_width = estimate.half_width_95 / scale;
            // False for NaN, too.
            let is_enough = half_width <= required;
            (!is_enough).then_some(UncertainParameter {
                joint: estimate.joint,
                name: estimate.name,
                half_width: if half_width.is_nan() {
                    f64::INFINITY
                } else {
                    half_width
                },
                required,
                is_relative,
                remedy,
            })
        });
        uncertain.collect()
    }

    /// Notes on encoder zeros that suffice for control but may cause a visible lean, a
    /// sentence each.
    pub fn zero_notes(&self) -> Vec<String> {
        let zeros = self.estimates.iter().filter(|estimate| {
            estimate.name == Quantity::Zero.name() && estimate.half_width_95 > ZERO_NOTE_COUNTS
        });
        let sentence = |estimate: &Estimate| {
            format!(
                "joint {}'s encoder zero has a 95 % interval of ±{:.0} counts: if the upright arm \
                 leans, correct it by eye with `armbridge calibrate`",
                estimate.joint, estimate.half_width_95
            )
        };
        zeros.map(sentence).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn estimate(quantity: Quantity, value: f64, half_width: f64) -> Estimate {
        Estimate {
            joint: 2,
            name: quantity.name(),
            unit: quantity.unit(),
            value,
            half_width_95: half_width,
            prior_mean: Some(value),
            remark: "",
        }
    }

    #[test]
    fn uncertain_parameters_are_named_with_a_remedy() {
        let report = Report {
            static_friction_unidentified: Vec::new(),
            estimates: vec![
                estimate(Quantity::Inertia, 0.03, 0.009),
                estimate(Quantity::Gain, 500.0, 90.0),
                estimate(Quantity::Gravity, 0.5, f64::NAN),
                estimate(Quantity::Zero, 512.0, 56.0),
                // Not used for control.
                estimate(Quantity::DeadAbove, 20.0, 40.0),
            ],
            sliding_s: 10.0,
            windows: 20,
            outliers: 0,
            noise_counts: 1.04,
        };
        let uncertain = report.too_uncertain();
        let names: Vec<&str> = uncertain.iter().map(|uncertain| uncertain.name).collect();
        assert_eq!(names, ["inertia", "gravity", "encoder zero"]);
        let text = uncertain[0].to_string();
        assert!(
            text.starts_with(
                "joint 2's inertia has a 95 % interval of ±30 %, and control needs ±20 %"
            ),
            "{text}"
        );
        assert!(
            report.zero_notes()[0]
                .starts_with("joint 2's encoder zero has a 95 % interval of ±56 counts")
        );
        assert!(uncertain[2].to_string().contains("±56.0 counts"));
    }
}
