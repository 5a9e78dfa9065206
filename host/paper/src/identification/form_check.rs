//! Test of the model with viscous friction alone for a wrong form, by its residuals.
//!
//! Residuals of a correct model are encoder noise: they are uncorrelated, and a superfluous
//! parameter reduces them no more than by chance. The form is wrong if two tests agree:
//! the residuals wander, so that their means over a twentieth of the samples exceed those of
//! noise; and dry friction explains more than chance, by an F ratio. The F ratio uses the
//! effective number of independent samples: if encoder noise is less than a count, rounding
//! repeats itself.

use serde::Serialize;

use super::fit::Fit;

/// Number of blocks of samples whose mean residuals are tested.
const BLOCKS: usize = 20;
/// Threshold of [`FormCheck::wander_sigma`], which chance exceeds once in 150 times.
const WANDER_LIMIT: f64 = 3.0;
/// F ratio that chance exceeds once in ten thousand times.
const F_LIMIT: f64 = 15.0;

/// Result of the test.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FormCheck {
    /// Excess of the squared mean residuals over a twentieth of the samples above those of
    /// noise, in standard deviations.
    pub wander_sigma: f64,
    /// Correlation of successive residuals.
    pub autocorrelation: f64,
    /// Reduction of the sum of squares by dry friction in the model, relative to that by a
    /// superfluous parameter.
    pub f_ratio: f64,
    /// The arm's friction is not viscous alone.
    pub is_wrong: bool,
}

impl FormCheck {
    /// Compares the fit of viscous friction alone with that of viscous and dry friction.
    pub fn compare(viscous: &Fit, dry: &Fit) -> Self {
        let [viscous_squares, dry_squares] = [viscous, dry].map(Fit::sum_of_squares);
        let unknowns = dry.covariance.nrows();
        let degrees = dry.count().saturating_sub(unknowns).max(1) as f64;
        let correlation = autocorrelation(dry).clamp(0.0, 0.99);
        let effective_degrees = degrees * (1.0 - correlation) / (1.0 + correlation);
        let wander_sigma = wander_sigma(viscous);
        let f_ratio = (viscous_squares - dry_squares) / dry_squares.max(f64::MIN_POSITIVE)
            * effective_degrees;
        Self {
            wander_sigma,
            autocorrelation: autocorrelation(viscous),
            f_ratio,
            is_wrong: wander_sigma > WANDER_LIMIT && f_ratio > F_LIMIT,
        }
    }
}

/// Runs of residuals without a missing sample.
fn stretches(fit: &Fit) -> impl Iterator<Item = &[Option<f64>]> {
    fit.residuals_rad
        .iter()
        .flat_map(|residuals| residuals.split(Option::is_none))
}

/// Correlation of successive residuals.
fn autocorrelation(fit: &Fit) -> f64 {
    let mut products = 0.0;
    for pair in stretches(fit).flat_map(|stretch| stretch.windows(2)) {
        if let [Some(a), Some(b)] = pair {
            products += a * b;
        }
    }
    products / fit.sum_of_squares().max(f64::MIN_POSITIVE)
}

/// Excess of the squared block means; the differences of successive residuals give the noise.
fn wander_sigma(fit: &Fit) -> f64 {
    let (mut changes, mut pairs) = (0.0, 0.0);
    for pair in stretches(fit).flat_map(|stretch| stretch.windows(2)) {
        if let [Some(a), Some(b)] = pair {
            changes += (b - a) * (b - a);
            pairs += 1.0;
        }
    }
    let variance = f64::max(changes / (2.0 * f64::max(pairs, 1.0)), f64::MIN_POSITIVE);
    let (mut squares, mut blocks) = (0.0, 0.0);
    for residuals in &fit.residuals_rad {
        for block in residuals.chunks(residuals.len().div_ceil(BLOCKS).max(1)) {
            let count = block.iter().flatten().count() as f64;
            let sum: f64 = block.iter().flatten().sum();
            if count > 0.0 {
                squares += sum * sum / count / variance;
                blocks += 1.0;
            }
        }
    }
    (squares - blocks) / f64::sqrt(2.0 * f64::max(blocks, 1.0))
}

#[cfg(test)]
mod tests {
    use super::super::{
        JointParameters, SampledExperiment, Unknown, VISCOUS, VISCOUS_COULOMB, VISCOUS_TORQUE,
        VirtualArm, fit,
    };
    use super::*;
    use armbridge_control::arm::Parameters;

    fn form(fall: &SampledExperiment) -> FormCheck {
        let fall = std::slice::from_ref(fall);
        let guess = JointParameters::from_arm(&Parameters::paper());
        let [viscous, dry] =
            [VISCOUS, VISCOUS_COULOMB].map(|unknowns| fit(fall, unknowns, &guess).unwrap());
        FormCheck::compare(&viscous, &dry)
    }

    #[test]
    fn an_arm_without_dry_friction_is_of_the_right_form() {
        let mut largest = 0.0_f64;
        for seed in 1..=200 {
            let fall = VirtualArm::paper(0.24, 0.0, seed).free_fall(0.1, 4.0);
            let form = form(&fall);
            assert!(!form.is_wrong, "seed {seed}: {form:?}");
            largest = largest.max(form.f_ratio);
        }
        // The largest of the F ratios of 200 draws is about 8.
        assert!((2.0..F_LIMIT).contains(&largest), "{largest}");
    }

    #[test]
    fn dry_friction_shows_from_a_twelfth_of_the_papers_dead_zone() {
        for seed in 1..=20 {
            for coulomb_nm in [0.005, 0.01, 0.04, 0.107] {
                let arm = VirtualArm::paper(0.24, coulomb_nm, seed);
                let form = form(&arm.free_fall(arm.breakaway_rad() + 0.1, 4.0));
                assert!(form.is_wrong, "{coulomb_nm} N m, seed {seed}: {form:?}");
            }
        }
    }

    /// In a motion in one direction dry friction is part of the torque: the form is right.
    #[test]
    fn a_constant_input_does_not_show_dry_friction() {
        for seed in 1..=20 {
            let push = VirtualArm::paper(0.24, 0.05, seed).constant_input(-0.45, 1.3);
            let guess = JointParameters {
                torque_nm: -0.4,
                ..JointParameters::from_arm(&Parameters::paper())
            };
            let push = [push];
            let viscous = fit(&push, VISCOUS_TORQUE, &guess).unwrap();
            let unknowns = [Unknown::Viscous, Unknown::Torque, Unknown::Coulomb];
            let dry = fit(&push, &unknowns, &guess).unwrap();
            let form = FormCheck::compare(&viscous, &dry);
            assert!(!form.is_wrong, "seed {seed}: {form:?}");
        }
    }
}
