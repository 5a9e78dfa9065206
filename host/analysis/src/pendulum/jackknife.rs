//! Intervals of the parameters by a jackknife over recordings.
//!
//! Residuals of a simulation last for seconds: the samples of a recording are worth far fewer
//! than their number, and the curvature of the cost would promise too much. So each recording in
//! turn is left out, and the spread of the estimates is what another choice of recordings would
//! change. The interval has nothing of an error that all recordings have in common, such as that
//! of the known mass.

use serde::Serialize;

use super::parameters::{FrictionForm, Parameters};

/// Quantile of the normal distribution for a 95 % interval.
const Z_95: f64 = 1.959964;

/// An estimate with its interval.
#[derive(Clone, Debug, Serialize)]
pub struct Estimate {
    /// Name.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Value fitted to all recordings.
    pub value: f64,
    /// Half-width of its 95 % interval.
    pub half_width_95: f64,
}

/// Estimates of a form's parameters, and those that follow from them.
pub(super) fn estimates(
    form: FrictionForm,
    fitted: &Parameters,
    without_one: &[Parameters],
) -> Vec<Estimate> {
    let estimate = |name, unit, value: &dyn Fn(&Parameters) -> f64| Estimate {
        name,
        unit,
        value: value(fitted),
        half_width_95: half_width_95(without_one.iter().map(value)),
    };
    let quantities = form.quantities();
    let own = quantities
        .iter()
        .map(|&it| estimate(it.name(), it.unit(), &|parameters| parameters.get(it)));
    let derived = [
        estimate(
            "torque constant",
            "N m/A",
            &Parameters::torque_constant_nm_a,
        ),
        estimate("winding resistance", "ohm", &Parameters::resistance_ohm),
    ];
    own.chain(derived).collect()
}

/// Half-width of a 95 % interval from the estimates with one recording left out of each.
fn half_width_95(estimates: impl Iterator<Item = f64>) -> f64 {
    let estimates: Vec<f64> = estimates.collect();
    let count = estimates.len() as f64;
    let mean = estimates.iter().sum::<f64>() / count;
    let squares = estimates.iter().map(|it| (it - mean).powi(2)).sum::<f64>();
    student_95(count - 1.0) * ((count - 1.0) / count * squares).sqrt()
}

/// Quantile of Student's distribution for a 95 % interval, by its expansion in the reciprocal of
/// the degrees of freedom: to 1 % from three on.
fn student_95(freedom: f64) -> f64 {
    let z = Z_95;
    let first = (z.powi(3) + z) / 4.0;
    let second = (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / 96.0;
    let third = (3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z) / 384.0;
    z + first / freedom + second / freedom.powi(2) + third / freedom.powi(3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_jackknife_of_a_mean_is_its_standard_error() {
        let values = [3.0, 1.0, 4.0, 1.0, 5.0, 9.0];
        let sum: f64 = values.iter().sum();
        let without_one = values.iter().map(|value| (sum - value) / 5.0);
        let mean = sum / 6.0;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        let expected = student_95(5.0) * (squares / 5.0 / 6.0).sqrt();
        assert!((half_width_95(without_one) - expected).abs() < 1e-12);
    }

    #[test]
    fn quantiles_are_those_of_tables() {
        for (freedom, expected) in [(3.0, 3.182), (5.0, 2.571), (15.0, 2.131), (1e6, 1.960)] {
            let relative = student_95(freedom) / expected - 1.0;
            assert!(relative.abs() < 0.01, "{freedom}: {relative}");
        }
    }
}
