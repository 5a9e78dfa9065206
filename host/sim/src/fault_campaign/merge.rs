//! A campaign in parts: cases run apart, on several machines, as one.
//!
//! Each case depends on its seed alone, so that the parts, in the order of their seeds, are what one
//! machine gives, to the byte.

use serde::{Deserialize, Serialize};

use super::outcome::Outcome;
use super::report::Report;

/// A campaign: its results, and every case.
#[derive(Debug, Serialize)]
pub struct Campaign {
    /// Results.
    #[serde(flatten)]
    pub report: Report,
    /// Cases, in the order of their seeds.
    pub outcomes: Vec<Outcome>,
}

/// Of a campaign's JSON, what its report follows from.
#[derive(Debug, Deserialize)]
struct Part {
    outcomes: Vec<Outcome>,
}

/// Reason for which parts are no campaign.
#[derive(Debug, thiserror::Error)]
pub enum MergeError {
    /// A part is no JSON of a campaign.
    #[error("it is no JSON of a fault campaign: {0}")]
    Json(#[from] serde_json::Error),
    /// Two parts have the same case.
    #[error("seed {0} is in two parts: run each seed once")]
    Twice(u64),
}

impl Campaign {
    /// Summarises these cases.
    ///
    /// # Errors
    /// If a seed occurs twice.
    pub fn new(mut outcomes: Vec<Outcome>) -> Result<Self, MergeError> {
        outcomes.sort_by_key(|outcome| outcome.seed);
        if let Some(pair) = outcomes.windows(2).find(|it| it[0].seed == it[1].seed) {
            return Err(MergeError::Twice(pair[0].seed));
        }
        let report = Report::new(&outcomes);
        Ok(Self { report, outcomes })
    }

    /// The cases of a part, as `--json` printed it.
    ///
    /// # Errors
    /// If it is none.
    pub fn cases_of(part: &str) -> Result<Vec<Outcome>, MergeError> {
        Ok(serde_json::from_str::<Part>(part)?.outcomes)
    }

    /// The campaign as a line of JSON.
    ///
    /// # Errors
    /// Never: a number of a case is finite.
    pub fn to_json(&self) -> Result<String, MergeError> {
        Ok(serde_json::to_string(self)? + "\n")
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Case, run};
    use super::*;

    #[test]
    fn parts_are_the_whole_to_the_byte() {
        let outcomes = |seeds: std::ops::Range<u64>| seeds.map(|it| run(&Case::new(it))).collect();
        let whole = Campaign::new(outcomes(0..12)).unwrap().to_json().unwrap();
        let parts = [5..12, 0..5].map(|seeds| {
            let part = Campaign::new(outcomes(seeds)).unwrap();
            Campaign::cases_of(&part.to_json().unwrap()).unwrap()
        });
        assert_eq!(
            Campaign::new(parts.concat()).unwrap().to_json().unwrap(),
            whole
        );
        let twice = Campaign::new([parts[0].clone(), parts[0].clone()].concat());
        assert!(matches!(twice, Err(MergeError::Twice(5))));
        assert!(Campaign::cases_of("{}").is_err());
    }
}
