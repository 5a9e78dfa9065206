//! Whether what was found is known well enough to control an arm by.
//!
//! A controller lives with numbers that are a few percent off; with an inertia or a motor
//! gain that may be half or twice as large its margins are used up, and it does not
//! matter how good a guess in the middle looks.

use super::quantity::Quantity;
use super::report::{Number, Report};

/// Half of a 95 % interval, as a share of the number, beyond which no gains are designed
/// with it: disc margins of the standing gains let the loop gain be wrong by half, of
/// which other errors want their part.
const SHARE_MAX: f64 = 0.2;
/// The same of an encoder's zero in counts. Near upright a zero that is off is a motor
/// offset that is off the other way: torques are right all the same, but the arm leans by
/// as much where it is to stand. 50 counts are 15°, and no longer near.
const ZERO_MAX_COUNTS: f64 = 50.0;
/// A zero that is worth a word: 10 counts are 3°, which an eye sees.
const ZERO_SEEN_COUNTS: f64 = 10.0;

/// What control needs, how well, and what else would tell it.
const NEEDED: [(Quantity, f64, &str); 4] = [
    (
        Quantity::Inertia,
        SHARE_MAX,
        "fast motion, such as a multisine up to 2 Hz or a PRBS of the joint",
    ),
    (
        Quantity::Gain,
        SHARE_MAX,
        "wide and slow motion against gravity, such as a multisine of the joint",
    ),
    (
        Quantity::Gravity,
        SHARE_MAX,
        "wide motion of the joint, and masses and lengths that were measured (--weighed)",
    ),
    (
        Quantity::Zero,
        ZERO_MAX_COUNTS,
        "slow motion to both sides of upright, or `armbridge calibrate`",
    ),
];

/// A number that is known too vaguely.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "joint {joint}'s {name} is known to ±{} only, and control needs ±{}; what would tell it: \
     {remedy}",
    amount(*.within, *.is_share),
    amount(*.needed, *.is_share)
)]
pub struct TooVague {
    /// From 1.
    pub joint: usize,
    /// Of the number.
    pub name: &'static str,
    /// Half of its 95 % interval: a share of the number, or in its unit, counts.
    pub within: f64,
    /// What it would have to be.
    pub needed: f64,
    /// Whether these are shares.
    pub is_share: bool,
    /// An experiment.
    pub remedy: &'static str,
}

fn amount(value: f64, is_share: bool) -> String {
    if !value.is_finite() {
        "anything".into()
    } else if is_share {
        format!("{:.0} %", 100.0 * value)
    } else {
        format!("{value:.1} counts")
    }
}

impl Report {
    /// What of it is known too vaguely for control.
    pub fn too_vague(&self) -> Vec<TooVague> {
        let vague = self.numbers.iter().filter_map(|number| {
            let (quantity, needed, remedy) = NEEDED
                .into_iter()
                .find(|(quantity, ..)| quantity.name() == number.name)?;
            let is_share = quantity.is_relative();
            let scale = if is_share { number.value.abs() } else { 1.0 };
            let within = number.within / scale;
            // Not true of what is not a number either.
            let is_enough = within <= needed;
            (!is_enough).then_some(TooVague {
                joint: number.joint,
                name: number.name,
                within: if within.is_nan() {
                    f64::INFINITY
                } else {
                    within
                },
                needed,
                is_share,
                remedy,
            })
        });
        vague.collect()
    }

    /// What an eye may see of what is known well enough all the same, each in a sentence.
    pub fn may_lean(&self) -> Vec<String> {
        let zeros = self.numbers.iter().filter(|number| {
            number.name == Quantity::Zero.name() && number.within > ZERO_SEEN_COUNTS
        });
        let sentence = |number: &Number| {
            format!(
                "joint {}'s zero is known to ±{:.0} counts only: if the arm leans where it is to \
                 stand, `armbridge calibrate` finds it by eye",
                number.joint, number.within
            )
        };
        zeros.map(sentence).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(quantity: Quantity, value: f64, within: f64) -> Number {
        Number {
            joint: 2,
            name: quantity.name(),
            unit: quantity.unit(),
            value,
            within,
            before: Some(value),
            remark: "",
        }
    }

    #[test]
    fn what_is_vague_is_named_with_what_would_help() {
        let report = Report {
            never_gave_way: Vec::new(),
            numbers: vec![
                number(Quantity::Inertia, 0.03, 0.009),
                number(Quantity::Gain, 500.0, 90.0),
                number(Quantity::Gravity, 0.5, f64::NAN),
                number(Quantity::Zero, 512.0, 56.0),
                // Nobody controls by this.
                number(Quantity::DeadAbove, 20.0, 40.0),
            ],
            sliding_s: 10.0,
            windows: 20,
            odd: 0,
            noise_counts: 1.04,
        };
        let vague = report.too_vague();
        let names: Vec<&str> = vague.iter().map(|vague| vague.name).collect();
        assert_eq!(names, ["inertia", "gravity", "encoder zero"]);
        let text = vague[0].to_string();
        assert!(
            text.starts_with("joint 2's inertia is known to ±30 % only, and control needs ±20 %"),
            "{text}"
        );
        assert!(report.may_lean()[0].starts_with("joint 2's zero is known to ±56 counts only"));
        assert!(vague[2].to_string().contains("±56.0 counts"));
    }
}
