//! Distribution of a quantity over the ticks of a run.

use std::collections::BTreeMap;

use serde::Serialize;

/// Distribution of a quantity over the ticks of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub std: f64,
    /// Smallest value that 99 % of the ticks do not exceed.
    pub p99: u32,
    /// Largest value.
    pub max: u32,
}

/// Count of each value, for exact results; memory grows with the number of different
/// values, not with the run.
#[derive(Clone, Debug, Default)]
pub struct Counts(BTreeMap<u32, u64>);

impl Counts {
    /// Adds a value.
    pub fn add(&mut self, value: u32) {
        *self.0.entry(value).or_default() += 1;
    }

    /// Each value, in ascending order, with its count.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = (u32, u64)> {
        self.0.iter().map(|(&value, &count)| (value, count))
    }

    /// Whether there is no value.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Distribution of the values.
    pub fn spread(&self) -> Spread {
        let Some((&max, _)) = self.0.last_key_value() else {
            return Spread::default();
        };
        let weighted = || self.0.iter().map(|(&v, &n)| (f64::from(v), n as f64));
        let total = self.0.values().sum::<u64>();
        let mean = weighted().map(|(v, n)| v * n).sum::<f64>() / total as f64;
        let squares = weighted().map(|(v, n)| (v - mean).powi(2) * n);
        let variance = squares.sum::<f64>() / total as f64;
        // For a million ticks, the one with 10 000 above it.
        let within = (total as f64 * 0.99).ceil() as u64;
        let mut cumulative = 0;
        let p99 = self.0.iter().find(|(_, n)| {
            cumulative += **n;
            cumulative >= within
        });
        Spread {
            mean,
            std: variance.sqrt(),
            p99: p99.map_or(max, |(&v, _)| v),
            max,
        }
    }
}
