//! A claim of the paper, the numbers that test it, and the verdict they give.
//!
//! No verdict is written by hand. Every [`Number`] carries the [`Rule`] that it
//! must meet; a [`Claim`] holds the numbers that follow from the paper *as printed*
//! and those of our reading of it, and [`Claim::verdict`] evaluates both.

use serde::Serialize;

use super::chart::Figure;
use super::text::{number, plain};

/// Condition on a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rule {
    /// Rounded to this number of decimals, it equals the printed value.
    RoundsTo(f64, u8),
    /// Truncated to this number of decimals, it equals the printed value.
    CutsTo(f64, u8),
    /// It differs from the first value by no more than the second.
    Within(f64, f64),
    /// It is no larger.
    AtMost(f64),
    /// It is no smaller.
    AtLeast(f64),
}

impl Rule {
    /// Whether a value meets the rule; NaN meets none.
    pub fn holds(self, value: f64) -> bool {
        /// Tolerance for decimal fractions, which are not exact in binary.
        const ROUNDING: f64 = 1e-9;
        let at = |decimals: u8| 10f64.powi(decimals.into());
        let same = |scaled: f64, printed: f64, decimals| {
            (scaled - printed * at(decimals)).abs() < ROUNDING * at(decimals)
        };
        match self {
            Self::RoundsTo(printed, decimals) => {
                same((value * at(decimals)).round(), printed, decimals)
            }
            Self::CutsTo(printed, decimals) => {
                same((value * at(decimals)).trunc(), printed, decimals)
            }
            Self::Within(expected, tolerance) => (value - expected).abs() <= tolerance,
            Self::AtMost(limit) => value <= limit,
            Self::AtLeast(limit) => value >= limit,
        }
    }

    /// Expected value; none for a limit.
    pub fn expected(self) -> Option<f64> {
        match self {
            Self::RoundsTo(value, _) | Self::CutsTo(value, _) | Self::Within(value, _) => {
                Some(value)
            }
            Self::AtMost(_) | Self::AtLeast(_) => None,
        }
    }

    /// The rule in words.
    pub fn words(self) -> String {
        match self {
            Self::RoundsTo(printed, decimals) => {
                format!("rounds to {}", number(printed, decimals.into()))
            }
            Self::CutsTo(printed, decimals) => {
                format!(
                    "{} when cut to {decimals} decimals",
                    number(printed, decimals.into())
                )
            }
            Self::Within(expected, tolerance) => {
                format!("{} ± {}", plain(expected), plain(tolerance))
            }
            Self::AtMost(limit) => format!("≤ {}", plain(limit)),
            Self::AtLeast(limit) => format!("≥ {}", plain(limit)),
        }
    }
}

/// A number computed by the run.
#[derive(Clone, Debug, PartialEq)]
pub struct Number {
    /// Name of the quantity.
    pub quantity: String,
    /// Its unit; empty for a pure number.
    pub unit: &'static str,
    /// Its value.
    pub found: f64,
    /// Condition that it must meet.
    pub rule: Rule,
}

impl Number {
    /// Number with its rule.
    pub fn new(quantity: impl Into<String>, unit: &'static str, found: f64, rule: Rule) -> Self {
        Self {
            quantity: quantity.into(),
            unit,
            found,
            rule,
        }
    }

    /// Whether the number meets its rule.
    pub fn holds(&self) -> bool {
        self.rule.holds(self.found)
    }

    /// Found value minus expected value; none for a limit.
    pub fn deviation(&self) -> Option<f64> {
        self.rule.expected().map(|expected| self.found - expected)
    }
}

/// Verdict on a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The claim follows from the paper as printed.
    Reproduced,
    /// The claim does not follow from the paper as printed, but from our reading.
    Explained,
    /// The claim follows from neither.
    NotReproduced,
}

impl Verdict {
    /// The verdict in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Reproduced => "reproduced",
            Self::Explained => "not as printed, but explained",
            Self::NotReproduced => "not reproduced",
        }
    }

    /// Short name for style sheets and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Reproduced => "reproduced",
            Self::Explained => "explained",
            Self::NotReproduced => "not-reproduced",
        }
    }
}

/// One claim of the paper.
#[derive(Clone, Debug)]
pub struct Claim {
    /// Anchor in the page.
    pub id: &'static str,
    /// Title of its section.
    pub title: &'static str,
    /// The claim in the paper's terms.
    pub paper: String,
    /// Result of the run.
    pub finding: String,
    /// Reason why the two differ, or agree.
    pub explanation: String,
    /// Correction of the difference.
    pub remedy: String,
    /// Numbers that must hold if the paper is right as printed.
    pub printed: Vec<Number>,
    /// Numbers that must hold if our reading is right.
    pub reading: Vec<Number>,
    /// Figures of its section.
    pub figures: Vec<Figure>,
}

impl Claim {
    /// Verdict that follows from the numbers.
    pub fn verdict(&self) -> Verdict {
        let all = |numbers: &[Number]| !numbers.is_empty() && numbers.iter().all(Number::holds);
        let reading_holds = self.reading.is_empty() || all(&self.reading);
        match (all(&self.printed), reading_holds) {
            (true, true) => Verdict::Reproduced,
            (false, true) if !self.reading.is_empty() => Verdict::Explained,
            _ => Verdict::NotReproduced,
        }
    }

    /// All numbers, those as printed first.
    pub fn numbers(&self) -> impl Iterator<Item = &Number> {
        self.printed.iter().chain(&self.reading)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_hold_inside_and_fail_outside() {
        for (rule, inside, outside) in [
            (Rule::RoundsTo(0.8355, 4), 0.83549, 0.83556),
            (Rule::CutsTo(1.10, 2), 1.1069, 1.0999),
            (Rule::CutsTo(-1.10, 2), -1.1069, 1.1069),
            (Rule::Within(0.421, 0.002), 0.4225, 0.424),
            (Rule::AtMost(1.0), 1.0, 1.1),
            (Rule::AtLeast(1.0), 1.0, 0.9),
        ] {
            assert!(rule.holds(inside), "{rule:?}");
            assert!(!rule.holds(outside) && !rule.holds(f64::NAN), "{rule:?}");
        }
    }

    #[test]
    fn verdicts_follow_the_numbers() {
        let numbers = |found| vec![Number::new("", "", found, Rule::AtMost(1.0))];
        let (yes, no, none) = (numbers(0.0), numbers(2.0), Vec::new());
        for (printed, reading, verdict) in [
            (&yes, &none, Verdict::Reproduced),
            (&yes, &yes, Verdict::Reproduced),
            (&no, &yes, Verdict::Explained),
            (&no, &no, Verdict::NotReproduced),
            (&yes, &no, Verdict::NotReproduced),
            (&no, &none, Verdict::NotReproduced),
        ] {
            let claim = Claim {
                id: "",
                title: "",
                paper: String::new(),
                finding: String::new(),
                explanation: String::new(),
                remedy: String::new(),
                printed: printed.clone(),
                reading: reading.clone(),
                figures: Vec::new(),
            };
            assert_eq!(claim.verdict(), verdict);
        }
    }
}
