//! Whiteness test of the residuals: a wrong model correlates successive residuals.
//!
//! The fit of a window's initial state makes its residuals slightly anticorrelated; the
//! autocorrelation is corrected for that.

use serde::Serialize;

use super::rollout::Rollout;

/// Largest lag, in blocks of ticks.
const LAGS: usize = 20;
/// 95 % quantile of the sum of 20 squares of standard normal noise.
const CHI_SQUARED: f64 = 31.41;
/// Standard errors on either side of a 95 % interval.
const INTERVAL: f64 = 1.96;

/// Whiteness of a joint's residuals.
#[derive(Clone, Debug, Serialize)]
pub struct Whiteness {
    /// Joint, from 1.
    pub joint: usize,
    /// Autocorrelation of the residuals of blocks of 5 ticks, at lags from 1.
    pub autocorrelation: Vec<f64>,
    /// 95 % bound on the magnitude of white noise's autocorrelation.
    pub bound: f64,
    /// Portmanteau statistic of Box and Pierce: sum of the squared autocorrelations, each
    /// over its standard error.
    pub portmanteau: f64,
    /// 95 % quantile of the statistic for white noise.
    pub critical_value: f64,
    /// Root mean square of a residual in counts.
    pub rms_counts: f64,
}

impl Whiteness {
    /// Tests the rollouts of a joint's windows.
    pub(super) fn new<'a>(joint: usize, windows: impl Iterator<Item = &'a Rollout>) -> Self {
        let (mut squares, mut count) = (0.0, 0.0);
        let mut products = [0.0; LAGS];
        let mut leverages = [0.0; LAGS];
        let mut pairs = [0.0; LAGS];
        for window in windows {
            let blocks = window.blocks();
            let normal = blocks
                .iter()
                .map(|block| block.sensitivity * block.sensitivity.transpose());
            let inverse = normal.sum::<nalgebra::Matrix2<f64>>().try_inverse();
            squares += blocks
                .iter()
                .map(|block| block.residual.powi(2))
                .sum::<f64>();
            count += blocks.len() as f64 - if inverse.is_some() { 2.0 } else { 0.0 };
            let inverse = inverse.unwrap_or_else(nalgebra::Matrix2::zeros);
            for lag in 1..=LAGS.min(blocks.len().saturating_sub(1)) {
                for (a, b) in blocks.iter().zip(&blocks[lag..]) {
                    products[lag - 1] += a.residual * b.residual;
                    leverages[lag - 1] += a.sensitivity.dot(&(inverse * b.sensitivity));
                    pairs[lag - 1] += 1.0;
                }
            }
        }
        let variance = squares / count;
        let autocorrelation: Vec<f64> = (0..LAGS)
            .map(|lag| (products[lag] / variance + leverages[lag]) / f64::max(pairs[lag], 1.0))
            .collect();
        let terms = autocorrelation.iter().zip(pairs);
        Self {
            joint: joint + 1,
            portmanteau: terms.map(|(r, pairs)| pairs * r * r).sum(),
            critical_value: CHI_SQUARED,
            bound: INTERVAL / f64::max(pairs[0], 1.0).sqrt(),
            autocorrelation,
            rms_counts: variance.sqrt(),
        }
    }

    /// Whether the residuals are as good as white: a significant correlation over many ticks
    /// is tolerated while it is small.
    pub fn is_white(&self) -> bool {
        /// Negligible correlation.
        const NEGLIGIBLE: f64 = 0.05;
        let largest = self
            .autocorrelation
            .iter()
            .fold(0.0, |largest, r| f64::max(largest, r.abs()));
        self.portmanteau < 2.0 * self.critical_value || largest < NEGLIGIBLE
    }
}
