//! Identifiability: combinations of parameters that the logs determine, and those that are
//! left to the prior.
//!
//! Coordinates are scaled by their prior standard deviations, gravity by that of inertia. An
//! eigenvector of the logs' information matrix with a small eigenvalue is then an
//! unidentifiable direction, described by its largest components.

use armbridge_servo::JOINTS;
use nalgebra::{DMatrix, SMatrix};
use serde::Serialize;

use super::super::fit_result::FitResult;
use super::super::prior::Prior;
use super::super::quantity::{COUNT, PER_JOINT, Quantity};

/// Magnitude above which a correlation is strong.
const CORRELATED: f64 = 0.9;
/// Standard deviation by the logs alone, in prior standard deviations, above which a
/// direction is unidentifiable.
const UNIDENTIFIABLE: f64 = 0.2;
/// Smallest component of a direction that is named, over the largest.
const NAMED: f64 = 0.25;

/// Two strongly correlated parameters, given logs and prior.
#[derive(Clone, Debug, Serialize)]
pub struct Correlation {
    /// The first, with its joint.
    pub first: String,
    /// The second, with its joint.
    pub second: String,
    /// Correlation coefficient.
    pub coefficient: f64,
}

/// A combination of parameters that the logs do not identify.
#[derive(Clone, Debug, Serialize)]
pub struct Combination {
    /// Description in words.
    pub description: String,
    /// Prior that fixes it, in words.
    pub fixed_by: String,
    /// Standard deviation by the logs alone, in prior standard deviations; infinite without
    /// information.
    pub deviation: f64,
    /// Names and values of its components.
    pub components: Vec<(String, f64)>,
}

/// Name of a coordinate.
pub(super) fn name(index: usize) -> String {
    let quantity = Quantity::ALL[index % PER_JOINT];
    format!("{} of joint {}", quantity.name(), index / PER_JOINT + 1)
}

/// Correlation matrix of all parameters.
pub(in super::super) fn correlation_matrix(fit: &FitResult) -> SMatrix<f64, COUNT, COUNT> {
    let deviation = fit
        .covariance
        .diagonal()
        .map(|variance| variance.max(1e-300).sqrt());
    SMatrix::from_fn(|i, j| fit.covariance[(i, j)] / (deviation[i] * deviation[j]))
}

/// Strong correlations, the strongest first.
pub(super) fn strong_correlations(fit: &FitResult) -> Vec<Correlation> {
    let all = correlation_matrix(fit);
    let mut strong_correlations = Vec::new();
    for i in 0..COUNT {
        for j in 0..i {
            if all[(i, j)].abs() > CORRELATED {
                strong_correlations.push(Correlation {
                    first: name(j),
                    second: name(i),
                    coefficient: all[(i, j)],
                });
            }
        }
    }
    strong_correlations.sort_by(|a, b| b.coefficient.abs().total_cmp(&a.coefficient.abs()));
    strong_correlations
}

/// Combinations that the logs do not identify, by their information matrix alone (without
/// the prior), of an arm with this number of joints.
pub(super) fn unidentifiable(
    information: &SMatrix<f64, COUNT, COUNT>,
    prior: &Prior,
    joints: usize,
) -> Vec<Combination> {
    let scale: Vec<f64> = (0..COUNT)
        .map(|i| match Quantity::ALL[i % PER_JOINT] {
            Quantity::Gravity => prior.deviation[Quantity::Inertia.index(0)],
            Quantity::Inertia
            | Quantity::Viscous
            | Quantity::Coulomb
            | Quantity::Gain
            | Quantity::Offset
            | Quantity::DeadBelow
            | Quantity::DeadAbove
            | Quantity::Zero
            | Quantity::Delay => prior.deviation[i],
        })
        .collect();
    let scaled = |i: usize, j: usize| information[(i, j)] * scale[i] * scale[j];
    // A coordinate without information is unidentifiable by itself.
    let least = UNIDENTIFIABLE.powi(-2);
    let (informed, uninformed): (Vec<usize>, Vec<usize>) =
        (0..COUNT).partition(|&i| scaled(i, i) > least);
    let mut combinations: Vec<Combination> = uninformed
        .into_iter()
        .filter(|i| *i < PER_JOINT * joints)
        .map(|i| combination(&[(i, 1.0)], scaled(i, i), prior))
        .collect();
    let matrix = DMatrix::from_fn(informed.len(), informed.len(), |a, b| {
        scaled(informed[a], informed[b])
    });
    let eigen = matrix.symmetric_eigen();
    let mut directions: Vec<(f64, usize)> = eigen
        .eigenvalues
        .iter()
        .copied()
        .zip(0..)
        .filter(|(value, _)| *value < least)
        .collect();
    directions.sort_by(|a, b| a.0.total_cmp(&b.0));
    combinations.extend(directions.into_iter().map(|(value, column)| {
        let vector = eigen.eigenvectors.column(column);
        let components: Vec<(usize, f64)> = informed
            .iter()
            .copied()
            .zip(vector.iter().copied())
            .collect();
        combination(&components, value, prior)
    }));
    combinations
}

/// Describes a direction.
fn combination(components: &[(usize, f64)], information: f64, prior: &Prior) -> Combination {
    let largest = components
        .iter()
        .fold(0.0, |largest, (_, part)| f64::max(largest, part.abs()));
    let mut named: Vec<(usize, f64)> = components
        .iter()
        .copied()
        .filter(|(_, part)| part.abs() > NAMED * largest)
        .collect();
    named.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    Combination {
        description: description(&named),
        fixed_by: fixed_by(&named, prior),
        deviation: information.max(0.0).sqrt().recip(),
        components: named.iter().map(|(i, part)| (name(*i), *part)).collect(),
    }
}

/// Description of a direction. The common scale of all torques is named as such: inertia,
/// weight and friction grow with it, and the counts per N m fall.
fn description(named: &[(usize, f64)]) -> String {
    let signs: [Option<f64>; JOINTS] = core::array::from_fn(|joint| {
        let of_joint = named.iter().filter(|(i, _)| i / PER_JOINT == joint);
        let mut signs = of_joint.map(|(i, part)| match Quantity::ALL[i % PER_JOINT] {
            Quantity::Gain => -part.signum(),
            Quantity::Inertia | Quantity::Gravity | Quantity::Viscous | Quantity::Coulomb => {
                part.signum()
            }
            Quantity::Offset
            | Quantity::DeadBelow
            | Quantity::DeadAbove
            | Quantity::Zero
            | Quantity::Delay => f64::NAN,
        });
        let first = signs.next()?;
        let is_one = signs.all(|sign| sign.total_cmp(&first).is_eq());
        Some(if is_one { first } else { f64::NAN })
    });
    let scale = match signs {
        [Some(first), Some(second)] if first * second > 0.0 => Some("both joints"),
        [Some(first), Some(second)] if first * second < 0.0 => Some("joint 1 against joint 2"),
        [Some(sign), None] if sign.is_finite() => Some("joint 1"),
        [None, Some(sign)] if sign.is_finite() => Some("joint 2"),
        [Some(_) | None, Some(_) | None] => None,
    };
    if let Some(scale) = scale.filter(|_| named.len() >= 3) {
        return format!("scale of all torques of {scale}: inertia, weight, friction and motor");
    }
    let names: Vec<String> = named.iter().map(|(i, _)| name(*i)).collect();
    match names.as_slice() {
        [first] => format!("{first} alone"),
        [all @ .., last] => format!("{} and {last} together", all.join(", ")),
        [] => "nothing".into(),
    }
}

/// Prior that dominates along a direction.
fn fixed_by(components: &[(usize, f64)], prior: &Prior) -> String {
    let weight = |(i, part): &(usize, f64)| (part / prior.deviation[*i]).powi(2);
    let largest = components
        .iter()
        .max_by(|a, b| weight(a).total_cmp(&weight(b)));
    let Some((i, _)) = largest else {
        return "nothing".into();
    };
    match Quantity::ALL[i % PER_JOINT] {
        Quantity::Gravity => {
            format!(
                "the arm's weight, known to {:.1} %",
                100.0 * prior.deviation[*i]
            )
        }
        quantity @ (Quantity::Inertia | Quantity::Viscous | Quantity::Coulomb | Quantity::Gain) => {
            format!(
                "the prior of the {}: within a factor of {:.1}",
                quantity.name(),
                prior.deviation[*i].exp()
            )
        }
        Quantity::DeadBelow | Quantity::DeadAbove => {
            "the prior, which prefers the smallest dead zone that explains the logs".into()
        }
        quantity @ (Quantity::Offset | Quantity::Zero | Quantity::Delay) => format!(
            "the prior of the {}: ± {} {}",
            quantity.name(),
            quantity.value(prior.deviation[*i]),
            quantity.unit()
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use armbridge_link::message::Setup;
    use nalgebra::SVector;

    #[test]
    fn a_direction_without_information_is_named_with_the_prior_that_fixes_it() {
        let prior = Prior::from_setup(&Setup::default(), 0.02);
        // All is identified but the scale of joint 2's torques and one dead zone.
        let mut scale = SVector::<f64, COUNT>::zeros();
        for quantity in [
            Quantity::Inertia,
            Quantity::Gravity,
            Quantity::Viscous,
            Quantity::Coulomb,
        ] {
            scale[quantity.index(1)] = 1.0;
        }
        scale[Quantity::Gain.index(1)] = -1.0;
        scale.normalize_mut();
        let dead = Quantity::DeadAbove.index(0);
        let mut known = SMatrix::identity() - scale * scale.transpose();
        known.fill_row(dead, 0.0);
        known.fill_column(dead, 0.0);
        let unidentifiable = unidentifiable(&(known * 1e6), &prior, JOINTS);
        let [first, second] = unidentifiable.as_slice() else {
            panic!("{unidentifiable:?}");
        };
        assert_eq!(first.description, "dead zone above of joint 1 alone");
        assert_eq!(
            first.fixed_by,
            "the prior, which prefers the smallest dead zone that explains the logs"
        );
        assert_eq!(
            second.description,
            "scale of all torques of joint 2: inertia, weight, friction and motor"
        );
        assert_eq!(second.fixed_by, "the arm's weight, known to 2.0 %");
        assert!(
            first.deviation > 1e3 && second.deviation > 1e3,
            "{unidentifiable:?}"
        );
    }
}
