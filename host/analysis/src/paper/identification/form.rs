//! Is a model of the wrong form? What its residuals say of it.
//!
//! Residuals of the right form are the encoder's noise: they go up and down from one sample
//! to the next, and a number that the arm does not have takes no more of them away than
//! chance does. Two signs of the contrary, and both are asked for: residuals that wander,
//! their means over a twentieth of the samples being larger than noise leaves them; and dry
//! friction explaining more than chance would, an F ratio. That is taken for as many
//! samples as tell something new: where an encoder's noise is less than a count, rounding
//! repeats itself.

use serde::Serialize;

use super::fit::Fit;

/// Blocks of samples of which the means are looked at.
const BLOCKS: usize = 20;
/// Standard deviations by which their squares are more than noise leaves them: chance does
/// that once in 150 times.
const WANDERS: f64 = 3.0;
/// F ratio that chance exceeds once in ten thousand times.
const MORE: f64 = 15.0;

/// What residuals say of a model's form.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Form {
    /// Squares of the residuals' means over a twentieth of the samples beyond those of
    /// noise, in standard deviations.
    pub wander_sigma: f64,
    /// Correlation of a residual with the next.
    pub autocorrelation: f64,
    /// What dry friction in the model takes off the sum of squares, over what a number
    /// that is not there would.
    pub f_ratio: f64,
    /// Viscous friction alone is not what the arm has.
    pub is_wrong: bool,
}

impl Form {
    /// Of a model with viscous friction only, and of the same with dry friction.
    pub fn of(viscous: &Fit, dry: &Fit) -> Self {
        let [squares, left] = [viscous, dry].map(Fit::squares);
        let numbers = dry.covariance.nrows();
        let spare = dry.count().saturating_sub(numbers).max(1) as f64;
        let alike = autocorrelation(dry).clamp(0.0, 0.99);
        let fresh = spare * (1.0 - alike) / (1.0 + alike);
        let wander_sigma = wander_sigma(viscous);
        let f_ratio = (squares - left) / left.max(f64::MIN_POSITIVE) * fresh;
        Self {
            wander_sigma,
            autocorrelation: autocorrelation(viscous),
            f_ratio,
            is_wrong: wander_sigma > WANDERS && f_ratio > MORE,
        }
    }
}

/// Residuals that follow each other.
fn stretches(fit: &Fit) -> impl Iterator<Item = &[Option<f64>]> {
    fit.residuals_rad
        .iter()
        .flat_map(|residuals| residuals.split(Option::is_none))
}

fn autocorrelation(fit: &Fit) -> f64 {
    let mut products = 0.0;
    for pair in stretches(fit).flat_map(|stretch| stretch.windows(2)) {
        if let [Some(a), Some(b)] = pair {
            products += a * b;
        }
    }
    products / fit.squares().max(f64::MIN_POSITIVE)
}

/// Noise is what changes from one sample to the next.
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
            let seen = block.iter().flatten().count() as f64;
            let sum: f64 = block.iter().flatten().sum();
            if seen > 0.0 {
                squares += sum * sum / seen / variance;
                blocks += 1.0;
            }
        }
    }
    (squares - blocks) / f64::sqrt(2.0 * f64::max(blocks, 1.0))
}

#[cfg(test)]
mod tests {
    use super::super::{
        Numbers, Sampled, Unknown, VISCOUS, VISCOUS_COULOMB, VISCOUS_TORQUE, VirtualArm, fit,
    };
    use super::*;
    use armbridge_shared::arm::Parameters;

    fn form(fall: &Sampled) -> Form {
        let fall = std::slice::from_ref(fall);
        let numbers = Numbers::of(&Parameters::paper());
        let [viscous, dry] =
            [VISCOUS, VISCOUS_COULOMB].map(|unknowns| fit(fall, unknowns, &numbers).unwrap());
        Form::of(&viscous, &dry)
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
        // Of F ratios of 200 draws, the largest is some 8.
        assert!((2.0..MORE).contains(&largest), "{largest}");
    }

    #[test]
    fn dry_friction_shows_from_a_twelfth_of_the_papers_dead_zone() {
        for seed in 1..=20 {
            for coulomb_nm in [0.005, 0.01, 0.04, 0.107] {
                let arm = VirtualArm::paper(0.24, coulomb_nm, seed);
                let form = form(&arm.free_fall(arm.loose_rad() + 0.1, 4.0));
                assert!(form.is_wrong, "{coulomb_nm} N m, seed {seed}: {form:?}");
            }
        }
    }

    /// A motion one way takes it for torque: nothing is wrong with the form.
    #[test]
    fn a_constant_input_does_not_show_it() {
        for seed in 1..=20 {
            let push = VirtualArm::paper(0.24, 0.05, seed).constant_input(-0.45, 1.3);
            let numbers = Numbers {
                torque_nm: -0.4,
                ..Numbers::of(&Parameters::paper())
            };
            let push = [push];
            let viscous = fit(&push, VISCOUS_TORQUE, &numbers).unwrap();
            let all = [Unknown::Viscous, Unknown::Torque, Unknown::Coulomb];
            let dry = fit(&push, &all, &numbers).unwrap();
            let form = Form::of(&viscous, &dry);
            assert!(!form.is_wrong, "seed {seed}: {form:?}");
        }
    }
}
