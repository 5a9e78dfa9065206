//! Power spectral density by Welch's method: the mean over segments that overlap by
//! half, each with its mean removed and a Hann window applied.
//!
//! Samples are added one by one, and memory does not grow with the signal. The length of a
//! segment is a quarter of the longest piece without a gap, a power of two between [`SHORTEST`]
//! and [`LONGEST`]; that is known at the end only, so shorter segments are averaged as well
//! until the signal is long enough for longer ones.

use std::fmt;
use std::sync::Arc;

use realfft::{RealFftPlanner, RealToComplex};

/// Longest segment in samples: 4 s at 1 kHz, a resolution of 0.24 Hz.
const LONGEST: usize = 4096;

/// Shortest segment in samples.
const SHORTEST: usize = 64;

/// Power spectral density of a signal.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Spectrum {
    /// Frequency in Hz and power density in unit²/Hz, from the first frequency
    /// above zero on.
    pub(super) density: Vec<(f64, f64)>,
    /// Number of segments averaged.
    pub(super) segments: usize,
    /// Length of a segment in s.
    pub(super) segment_s: f64,
}

/// Spectrum of a signal, sample by sample.
#[derive(Debug)]
pub(super) struct Welch {
    /// One for each length of segments that may be used.
    sums: Vec<SegmentSum>,
    /// Samples since the last gap, and most between two gaps.
    piece: usize,
    longest: usize,
}

impl Default for Welch {
    fn default() -> Self {
        let mut planner = RealFftPlanner::new();
        let lengths = (SHORTEST.ilog2()..=LONGEST.ilog2()).map(|power| 1 << power);
        Self {
            sums: lengths
                .map(|length| SegmentSum::new(planner.plan_fft_forward(length)))
                .collect(),
            piece: 0,
            longest: 0,
        }
    }
}

impl Welch {
    /// Adds the next sample.
    pub(super) fn add(&mut self, sample: f64) {
        self.piece += 1;
        if self.piece > self.longest {
            self.longest = self.piece;
            let length = self.segment_length();
            self.sums.retain(|sum| sum.length() >= length);
        }
        for sum in &mut self.sums {
            sum.add(sample);
        }
    }

    /// Ends a piece of the signal.
    pub(super) fn gap(&mut self) {
        self.piece = 0;
        for sum in &mut self.sums {
            sum.samples.clear();
        }
    }

    /// Several segments in the longest piece, if possible.
    fn segment_length(&self) -> usize {
        1 << (self.longest / 4).clamp(SHORTEST, LONGEST).ilog2()
    }

    /// Spectrum of the samples, which are taken at `rate_hz`; none if there are too few.
    pub(super) fn spectrum(&self, rate_hz: f64) -> Option<Spectrum> {
        let length = self.segment_length();
        let sum = self.sums.iter().find(|sum| sum.length() == length)?;
        (sum.segments > 0).then(|| sum.spectrum(rate_hz))
    }
}

/// Sum over segments of one length.
struct SegmentSum {
    transform: Arc<dyn RealToComplex<f64>>,
    window: Vec<f64>,
    /// Latest samples, fewer than a segment.
    samples: Vec<f64>,
    powers: Vec<f64>,
    segments: usize,
}

impl fmt::Debug for SegmentSum {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{} segments of {}", self.segments, self.length())
    }
}

impl SegmentSum {
    fn new(transform: Arc<dyn RealToComplex<f64>>) -> Self {
        let length = transform.len();
        let phase = |i| std::f64::consts::TAU * i as f64 / length as f64;
        Self {
            window: (0..length).map(|i| 0.5 - 0.5 * phase(i).cos()).collect(),
            samples: Vec::with_capacity(length),
            powers: vec![0.0; length / 2 + 1],
            segments: 0,
            transform,
        }
    }

    fn length(&self) -> usize {
        self.window.len()
    }

    fn add(&mut self, sample: f64) {
        self.samples.push(sample);
        if self.samples.len() < self.length() {
            return;
        }
        let mean = self.samples.iter().sum::<f64>() / self.length() as f64;
        let weighted = self.samples.iter().zip(&self.window);
        let mut input: Vec<f64> = weighted.map(|(s, weight)| (s - mean) * weight).collect();
        let mut output = self.transform.make_output_vec();
        // Fails only on vectors of the wrong length.
        if self.transform.process(&mut input, &mut output).is_ok() {
            for (power, value) in self.powers.iter_mut().zip(&output) {
                *power += value.norm_sqr();
            }
            self.segments += 1;
        }
        self.samples.drain(..self.window.len() / 2);
    }

    fn spectrum(&self, rate_hz: f64) -> Spectrum {
        // Positive and negative frequencies together, divided by the window's power.
        let power: f64 = self.window.iter().map(|weight| weight * weight).sum();
        let scale = 2.0 / (rate_hz * power * self.segments as f64);
        let step_hz = rate_hz / self.length() as f64;
        let powers = self.powers.iter().enumerate().skip(1);
        Spectrum {
            density: powers
                .map(|(i, power)| (i as f64 * step_hz, power * scale))
                .collect(),
            segments: self.segments,
            segment_s: self.length() as f64 / rate_hz,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spectrum(pieces: &[Vec<f64>], rate_hz: f64) -> Option<Spectrum> {
        let mut welch = Welch::default();
        for piece in pieces {
            for sample in piece {
                welch.add(*sample);
            }
            welch.gap();
        }
        welch.spectrum(rate_hz)
    }

    #[test]
    fn the_power_of_a_sine_and_of_noise_is_where_it_belongs() {
        let mut state = 1_u64;
        let mut noise = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1);
            (state >> 40) as f64 / (1_u64 << 24) as f64 - 0.5
        };
        // 3 at 50 Hz, and evenly distributed noise of variance 1/12.
        let sample = |i| 3.0 * (std::f64::consts::TAU * 50.0 * f64::from(i) * 1e-3).sin();
        let signal: Vec<f64> = (0..60_000).map(|i| sample(i) + noise()).collect();
        let spectrum = spectrum(&[signal], 1000.0).unwrap();
        let step_hz = spectrum.density[0].0;
        let total: f64 = spectrum.density.iter().map(|(_, d)| d * step_hz).sum();
        assert!((total - (4.5 + 1.0 / 12.0)).abs() < 0.05, "{total}");
        let peak = spectrum.density.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        assert!((peak.unwrap().0 - 50.0).abs() < step_hz, "{peak:?}");
        let high = spectrum.density.iter().filter(|(hz, _)| *hz > 100.0);
        let floor = high.clone().map(|(_, d)| d).sum::<f64>() / high.count() as f64;
        // The variance is spread over half the sampling rate.
        assert!((floor * 500.0 * 12.0 - 1.0).abs() < 0.05, "{floor}");
    }

    #[test]
    fn a_signal_that_is_too_short_has_no_spectrum() {
        assert_eq!(spectrum(&[vec![1.0; SHORTEST - 1]], 1000.0), None);
        assert_eq!(spectrum(&[], 1000.0), None);
        let gaps = vec![vec![1.0; SHORTEST - 1]; 9];
        assert_eq!(spectrum(&gaps, 1000.0), None);
    }
}
