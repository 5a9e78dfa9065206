//! Power spectral density by Welch's method: the mean over segments that overlap by
//! half, each with its mean removed and a Hann window applied.

use realfft::RealFftPlanner;

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

/// Spectrum of samples at `rate_hz`, in pieces without gaps; none if there are too few.
pub(super) fn spectrum(pieces: &[Vec<f64>], rate_hz: f64) -> Option<Spectrum> {
    let longest = pieces.iter().map(Vec::len).max()?;
    if longest < SHORTEST {
        return None;
    }
    // Several segments in the longest piece, if possible.
    let length = (longest / 4).clamp(SHORTEST, LONGEST);
    let length = 1 << length.ilog2();
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(length);
    let phase = |i| std::f64::consts::TAU * i as f64 / length as f64;
    let window: Vec<f64> = (0..length).map(|i| 0.5 - 0.5 * phase(i).cos()).collect();
    let (mut input, mut output) = (transform.make_input_vec(), transform.make_output_vec());
    let mut sums = vec![0.0; output.len()];
    let mut segments = 0;
    for segment in pieces.iter().flat_map(|piece| {
        let starts = (0..=piece.len().saturating_sub(length)).step_by(length / 2);
        starts.filter_map(|start| piece.get(start..start + length))
    }) {
        let mean = segment.iter().sum::<f64>() / length as f64;
        for ((input, sample), weight) in input.iter_mut().zip(segment).zip(&window) {
            *input = (sample - mean) * weight;
        }
        // Fails only on vectors of the wrong length.
        transform.process(&mut input, &mut output).ok()?;
        for (sum, value) in sums.iter_mut().zip(&output) {
            *sum += value.norm_sqr();
        }
        segments += 1;
    }
    // Positive and negative frequencies together, divided by the window's power.
    let power: f64 = window.iter().map(|weight| weight * weight).sum();
    let scale = 2.0 / (rate_hz * power * f64::from(segments));
    let step_hz = rate_hz / length as f64;
    let density = sums.iter().enumerate().skip(1);
    Some(Spectrum {
        density: density
            .map(|(i, sum)| (i as f64 * step_hz, sum * scale))
            .collect(),
        segments: segments as usize,
        segment_s: length as f64 / rate_hz,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

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
    }
}
