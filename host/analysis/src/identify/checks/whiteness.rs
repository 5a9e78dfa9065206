//! Whether what is left is noise: errors that follow each other are of one model's making.
//!
//! A window's own start is fitted to it, which alone makes its errors a little opposite to
//! each other; their autocorrelation is corrected for that before it is judged.

use serde::Serialize;

use super::rollout::Followed;

/// Blocks of ticks that lie between two errors that are compared, at most.
const LAGS: usize = 20;
/// 95 % quantile of the sum of 20 squares of standard normal noise.
const CHI_SQUARED: f64 = 31.41;
/// Standard errors to either side in which noise is with 95 %.
const INTERVAL: f64 = 1.96;

/// What is left of a joint.
#[derive(Clone, Debug, Serialize)]
pub struct Whiteness {
    /// From 1.
    pub joint: usize,
    /// Autocorrelation of the errors of blocks of 5 ticks, at lags from 1.
    pub autocorrelation: Vec<f64>,
    /// Noise stays between this and its negative in 95 of 100 cases.
    pub bound: f64,
    /// Sum of the squares of all of these in their standard errors (Box and Pierce).
    pub portmanteau: f64,
    /// What noise stays below in 95 of 100 cases.
    pub expected: f64,
    /// Root mean square of an error in counts.
    pub rms_counts: f64,
}

impl Whiteness {
    /// Of a joint's windows.
    pub(super) fn of<'a>(joint: usize, windows: impl Iterator<Item = &'a Followed>) -> Self {
        let (mut squares, mut count) = (0.0, 0.0);
        let mut products = [0.0; LAGS];
        let mut hats = [0.0; LAGS];
        let mut pairs = [0.0; LAGS];
        for window in windows {
            let blocks = window.blocks();
            let normal = blocks
                .iter()
                .map(|block| block.slope * block.slope.transpose());
            let inverse = normal.sum::<nalgebra::Matrix2<f64>>().try_inverse();
            squares += blocks.iter().map(|block| block.error.powi(2)).sum::<f64>();
            count += blocks.len() as f64 - if inverse.is_some() { 2.0 } else { 0.0 };
            let inverse = inverse.unwrap_or_else(nalgebra::Matrix2::zeros);
            for lag in 1..=LAGS.min(blocks.len().saturating_sub(1)) {
                for (a, b) in blocks.iter().zip(&blocks[lag..]) {
                    products[lag - 1] += a.error * b.error;
                    hats[lag - 1] += a.slope.dot(&(inverse * b.slope));
                    pairs[lag - 1] += 1.0;
                }
            }
        }
        let variance = squares / count;
        let autocorrelation: Vec<f64> = (0..LAGS)
            .map(|lag| (products[lag] / variance + hats[lag]) / f64::max(pairs[lag], 1.0))
            .collect();
        let terms = autocorrelation.iter().zip(pairs);
        Self {
            joint: joint + 1,
            portmanteau: terms.map(|(r, pairs)| pairs * r * r).sum(),
            expected: CHI_SQUARED,
            bound: INTERVAL / f64::max(pairs[0], 1.0).sqrt(),
            autocorrelation,
            rms_counts: variance.sqrt(),
        }
    }

    /// Whether what is left is as good as noise: some correlation over many ticks does no
    /// harm as long as it is small.
    pub fn is_white(&self) -> bool {
        /// Correlation that is of no matter.
        const SMALL: f64 = 0.05;
        let most = self
            .autocorrelation
            .iter()
            .fold(0.0, |most, r| f64::max(most, r.abs()));
        self.portmanteau < 2.0 * self.expected || most < SMALL
    }
}
