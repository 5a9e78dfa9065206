//! What the logs tell of the numbers, and what they leave to what was believed before.
//!
//! Numbers are measured in what was believed of them, gravity in what is of the others; so
//! a direction among them along which the logs' information is small is one that they
//! cannot tell, and its largest parts are its name.

use armbridge_shared::JOINTS;
use nalgebra::{DMatrix, SMatrix};
use serde::Serialize;

use super::super::fit_result::Found;
use super::super::quantity::{COUNT, PER_JOINT, Quantity};
use super::super::search::Prior;

/// Correlation from which two numbers count as strongly correlated.
const CORRELATED: f64 = 0.9;
/// Standard deviation by the logs alone, in what was believed, from which a direction
/// counts as not identifiable.
const UNTOLD: f64 = 0.2;
/// Share of the largest part of a direction that is still named.
const NAMED: f64 = 0.25;

/// Two numbers that are strongly correlated, given logs and prior.
#[derive(Clone, Debug, Serialize)]
pub struct Pair {
    /// The one, with its joint.
    pub one: String,
    /// The other.
    pub other: String,
    /// From -1 to 1.
    pub correlation: f64,
}

/// A combination of numbers that the logs do not tell.
#[derive(Clone, Debug, Serialize)]
pub struct Combination {
    /// What it is, in words.
    pub what: String,
    /// What settled it.
    pub settled_by: String,
    /// How far off it would be by the logs alone, in what was believed of it before;
    /// infinite for what they say nothing about.
    pub deviation: f64,
    /// The numbers in it and their parts.
    pub parts: Vec<(String, f64)>,
}

/// A coordinate's name.
pub(super) fn name(index: usize) -> String {
    let quantity = Quantity::ALL[index % PER_JOINT];
    format!("{} of joint {}", quantity.name(), index / PER_JOINT + 1)
}

/// Correlations of all numbers.
pub fn correlations(found: &Found) -> SMatrix<f64, COUNT, COUNT> {
    let deviation = found
        .covariance
        .diagonal()
        .map(|variance| variance.max(1e-300).sqrt());
    SMatrix::from_fn(|i, j| found.covariance[(i, j)] / (deviation[i] * deviation[j]))
}

/// Pairs that are correlated closely, the closest first.
pub(super) fn pairs(found: &Found) -> Vec<Pair> {
    let all = correlations(found);
    let mut pairs = Vec::new();
    for i in 0..COUNT {
        for j in 0..i {
            if all[(i, j)].abs() > CORRELATED {
                pairs.push(Pair {
                    one: name(j),
                    other: name(i),
                    correlation: all[(i, j)],
                });
            }
        }
    }
    pairs.sort_by(|a, b| b.correlation.abs().total_cmp(&a.correlation.abs()));
    pairs
}

/// What the logs do not tell, by their information alone (no beliefs in it).
pub fn untold(information: &SMatrix<f64, COUNT, COUNT>, prior: &Prior) -> Vec<Combination> {
    let scale: Vec<f64> = (0..COUNT)
        .map(|i| match Quantity::ALL[i % PER_JOINT] {
            Quantity::Gravity => prior.deviation[Quantity::Inertia.at(0)],
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
    // What they say nothing about needs no company to be unknown.
    let least = UNTOLD.powi(-2);
    let (seen, unseen): (Vec<usize>, Vec<usize>) = (0..COUNT).partition(|&i| scaled(i, i) > least);
    let mut combinations: Vec<Combination> = unseen
        .into_iter()
        .map(|i| combination(&[(i, 1.0)], scaled(i, i), prior))
        .collect();
    let matrix = DMatrix::from_fn(seen.len(), seen.len(), |a, b| scaled(seen[a], seen[b]));
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
        let parts: Vec<(usize, f64)> = seen.iter().copied().zip(vector.iter().copied()).collect();
        combination(&parts, value, prior)
    }));
    combinations
}

/// A direction by name.
fn combination(parts: &[(usize, f64)], information: f64, prior: &Prior) -> Combination {
    let most = parts
        .iter()
        .fold(0.0, |most, (_, part)| f64::max(most, part.abs()));
    let mut named: Vec<(usize, f64)> = parts
        .iter()
        .copied()
        .filter(|(_, part)| part.abs() > NAMED * most)
        .collect();
    named.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    Combination {
        what: what(&named),
        settled_by: settled_by(&named, prior),
        deviation: information.max(0.0).sqrt().recip(),
        parts: named.iter().map(|(i, part)| (name(*i), *part)).collect(),
    }
}

/// The scale of torques has a name of its own: what grows with it grows, and the counts
/// for a N m fall.
fn what(named: &[(usize, f64)]) -> String {
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
        [Some(one), Some(other)] if one * other > 0.0 => Some("both joints"),
        [Some(one), Some(other)] if one * other < 0.0 => Some("joint 1 against joint 2"),
        [Some(sign), None] if sign.is_finite() => Some("joint 1"),
        [None, Some(sign)] if sign.is_finite() => Some("joint 2"),
        [Some(_) | None, Some(_) | None] => None,
    };
    if let Some(scale) = scale.filter(|_| named.len() >= 3) {
        return format!("scale of all torques of {scale}: inertia, weight, friction and motor");
    }
    let names: Vec<String> = named.iter().map(|(i, _)| name(*i)).collect();
    match names.as_slice() {
        [one] => format!("{one} alone"),
        [all @ .., last] => format!("{} and {last} together", all.join(", ")),
        [] => "nothing".into(),
    }
}

/// Of the beliefs, the one that weighs most along a direction.
fn settled_by(parts: &[(usize, f64)], prior: &Prior) -> String {
    let weight = |(i, part): &(usize, f64)| (part / prior.deviation[*i]).powi(2);
    let most = parts.iter().max_by(|a, b| weight(a).total_cmp(&weight(b)));
    let Some((i, _)) = most else {
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
    use armbridge_shared::link::message::Setup;
    use nalgebra::SVector;

    #[test]
    fn a_direction_without_information_has_a_name_and_a_belief_that_settles_it() {
        let prior = Prior::of(&Setup::default(), 0.02);
        // All is known well, but for the scale of joint 2's torques and one dead zone.
        let mut scale = SVector::<f64, COUNT>::zeros();
        for quantity in [
            Quantity::Inertia,
            Quantity::Gravity,
            Quantity::Viscous,
            Quantity::Coulomb,
        ] {
            scale[quantity.at(1)] = 1.0;
        }
        scale[Quantity::Gain.at(1)] = -1.0;
        scale.normalize_mut();
        let dead = Quantity::DeadAbove.at(0);
        let mut known = SMatrix::identity() - scale * scale.transpose();
        known.fill_row(dead, 0.0);
        known.fill_column(dead, 0.0);
        let untold = untold(&(known * 1e6), &prior);
        let [first, second] = untold.as_slice() else {
            panic!("{untold:?}");
        };
        assert_eq!(first.what, "dead zone above of joint 1 alone");
        assert_eq!(
            first.settled_by,
            "the prior, which prefers the smallest dead zone that explains the logs"
        );
        assert_eq!(
            second.what,
            "scale of all torques of joint 2: inertia, weight, friction and motor"
        );
        assert_eq!(second.settled_by, "the arm's weight, known to 2.0 %");
        assert!(
            first.deviation > 1e3 && second.deviation > 1e3,
            "{untold:?}"
        );
    }
}
