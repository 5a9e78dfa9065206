//! Random numbers that depend on the seed alone.

use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg32;

/// Stream of the generator; the bench uses 0 to 5.
const STREAM: u64 = 6;

/// Generator of random numbers.
#[derive(Clone, Debug)]
pub(super) struct Random(Pcg32);

impl Random {
    pub(super) fn new(seed: u64) -> Self {
        Self(Pcg32::new(seed, STREAM))
    }

    /// From 0 to `end` - 1.
    pub(super) fn below(&mut self, end: u64) -> u64 {
        Uniform::new(0, end).map_or(0, |range| range.sample(&mut self.0))
    }

    /// From `least` to `most`.
    pub(super) fn uniform(&mut self, least: f64, most: f64) -> f64 {
        Uniform::new_inclusive(least, most).map_or(least, |range| range.sample(&mut self.0))
    }

    /// From `least` to `most`, uniform in the logarithm.
    pub(super) fn log_uniform(&mut self, least: f64, most: f64) -> f64 {
        self.uniform(least.ln(), most.ln()).exp()
    }

    /// A time from `least` to `most` milliseconds, in µs, uniform in the logarithm.
    pub(super) fn log_uniform_us(&mut self, least: f64, most: f64) -> u64 {
        (1e3 * self.log_uniform(least, most)) as u64
    }

    /// 1 or -1.
    pub(super) fn sign(&mut self) -> f64 {
        if self.coin() { 1.0 } else { -1.0 }
    }

    /// True with probability 0.5.
    pub(super) fn coin(&mut self) -> bool {
        self.below(2) == 0
    }
}
