//! Random numbers that depend on the seed alone.

use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg32;

/// Stream of the generator; the bench uses 0 to 5.
const STREAM: u64 = 6;

/// A sequence of random numbers.
#[derive(Clone, Debug)]
pub(super) struct Draw(Pcg32);

impl Draw {
    pub(super) fn new(seed: u64) -> Self {
        Self(Pcg32::new(seed, STREAM))
    }

    /// From 0 to `end` - 1.
    pub(super) fn below(&mut self, end: u64) -> u64 {
        Uniform::new(0, end).map_or(0, |range| range.sample(&mut self.0))
    }

    /// From `least` to `most`.
    pub(super) fn within(&mut self, least: f64, most: f64) -> f64 {
        Uniform::new_inclusive(least, most).map_or(least, |range| range.sample(&mut self.0))
    }

    /// The same, each power of ten as likely as the next.
    pub(super) fn magnitude(&mut self, least: f64, most: f64) -> f64 {
        self.within(least.ln(), most.ln()).exp()
    }

    /// A time from `least` to `most` milliseconds, in µs, short ones as likely as
    /// long ones.
    pub(super) fn us_of_ms(&mut self, least: f64, most: f64) -> u64 {
        (1e3 * self.magnitude(least, most)) as u64
    }

    pub(super) fn either(&mut self) -> bool {
        self.below(2) == 0
    }
}
