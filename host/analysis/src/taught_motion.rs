//! Taught motion: the path along which a hand led an arm that floats, as samples to be replayed.
//!
//! ```text
//! records of the float -> smooth -> trim -> CSV of time_s, q1_rad, q2_rad
//! ```
//!
//! The estimated angles are averaged with Gaussian weights on a grid of [`SPACING_S`]; the
//! weights are as narrow as the bounds of a motion allow, so that the noise of the encoders and the
//! tremor of a hand do not become accelerations. Rests before and after the motion are cut off, but
//! for [`REST_S`]. Angles beyond the board's range are held at its end.

use std::fmt::Write as _;

use armbridge_board::bridge::limits::{MOTION, REFERENCE_MAX_RAD};
use armbridge_link::message::{Drive, Record};
use armbridge_servo::JOINTS;
use thiserror::Error;

/// Time between samples in s.
pub const SPACING_S: f64 = 0.01;
/// Rest in s that is left before and after the motion.
pub const REST_S: f64 = 0.3;
/// Distance in rad from its first place, and from its last, at which an arm moves: three encoder
/// counts.
const MOVED_RAD: f64 = 0.015;
/// Distance in rad from the end of the board's range at which angles are held: a replay
/// interpolates.
const MARGIN_RAD: f64 = 0.01;
/// Standard deviations of the weights in s that are tried, from narrow to wide.
const WIDTHS_S: [f64; 5] = [0.02, 0.035, 0.06, 0.1, 0.16];
/// Weights beyond so many standard deviations are left out.
const WIDTHS: f64 = 3.0;
/// Share of the bounds that is used: points of a replay are a little farther apart.
const SHARE: f64 = 0.8;
/// Time in s over which accelerations are taken.
const SLOPE_S: f64 = 0.05;

/// Reason for which there is no taught motion.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum TeachError {
    /// The board has not floated.
    #[error("the arm has not floated: there is nothing to learn from")]
    NoFloat,
    /// The arm has not been moved.
    #[error(
        "the arm was moved by {moved_rad:.3} rad only, within {seconds:.1} s; lead it farther than \
         {MOVED_RAD} rad"
    )]
    NoMotion {
        /// Farthest distance from its first place, in rad.
        moved_rad: f64,
        /// Duration of the float in s.
        seconds: f64,
    },
}

/// A taught motion.
#[derive(Clone, Debug, PartialEq)]
pub struct TaughtMotion {
    /// Angles of both joints in rad, [`SPACING_S`] apart.
    pub angle_rad: Vec<[f64; JOINTS]>,
    /// Rests that were cut off before and after it, in s.
    pub cut_s: [f64; 2],
    /// Standard deviation of the weights in s.
    pub width_s: f64,
    /// Whether it was led beyond the board's range, at whose end it is held.
    pub is_clamped: bool,
}

/// Time in s and angles in rad.
type Sample = (f64, [f64; JOINTS]);

/// Samples of a board's last float.
#[derive(Clone, Debug, Default)]
pub struct FloatSamples {
    samples: Vec<Sample>,
    is_under_way: bool,
}

impl FloatSamples {
    /// Takes the record of a tick, in order.
    pub fn take(&mut self, record: &Record) {
        let is_floating = record.mode.drive() == Some(Drive::Float);
        if is_floating && !self.is_under_way {
            self.samples.clear();
        }
        self.is_under_way = is_floating;
        if is_floating {
            let at_s = record.input.start_us as f64 * 1e-6;
            let angle_rad = record.output.angle_rad.map(f64::from);
            self.samples.push((at_s, angle_rad));
        }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.samples.len()
    }

    /// Whether there was no float.
    pub fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// The motion along them.
    ///
    /// # Errors
    /// See [`TeachError`].
    pub fn motion(&self) -> Result<TaughtMotion, TeachError> {
        TaughtMotion::from_samples(&self.samples)
    }
}

impl TaughtMotion {
    /// The motion of the last float in these records.
    ///
    /// # Errors
    /// See [`TeachError`].
    pub fn from_records<'a>(
        records: impl IntoIterator<Item = &'a Record>,
    ) -> Result<Self, TeachError> {
        let mut float = FloatSamples::default();
        for record in records {
            float.take(record);
        }
        float.motion()
    }

    /// The motion along these samples of a float.
    fn from_samples(samples: &[Sample]) -> Result<Self, TeachError> {
        let (Some(first), Some(last)) = (samples.first(), samples.last()) else {
            return Err(TeachError::NoFloat);
        };
        let beyond = |q: &f64| (hold_in_range(*q) - q).abs() > 0.0;
        let is_clamped = samples.iter().any(|(_, q)| q.iter().any(beyond));
        let samples: Vec<Sample> = samples
            .iter()
            .map(|(at_s, q)| (*at_s, q.map(hold_in_range)))
            .collect();
        let (mut angle_rad, mut width_s) = (Vec::new(), 0.0);
        for width in WIDTHS_S {
            (angle_rad, width_s) = (smooth(&samples, width), width);
            if is_within_bounds(&angle_rad) {
                break;
            }
        }
        let is_away = |from: &[f64; JOINTS], q: &[f64; JOINTS]| distance(from, q) > MOVED_RAD;
        let (begin, end) = (angle_rad[0], angle_rad[angle_rad.len() - 1]);
        let moves = |q: &&[f64; JOINTS]| is_away(&begin, q);
        let Some(starts) = angle_rad.iter().position(|q| moves(&q)) else {
            let moved_rad = angle_rad.iter().map(|q| distance(&begin, q));
            return Err(TeachError::NoMotion {
                moved_rad: moved_rad.fold(0.0, f64::max),
                seconds: last.0 - first.0,
            });
        };
        let stops = angle_rad.iter().rposition(|q| is_away(&end, q));
        let stops = stops.unwrap_or(angle_rad.len() - 1);
        let rest = (REST_S / SPACING_S) as usize;
        let from = starts.saturating_sub(rest);
        let to = (stops.max(starts) + rest).min(angle_rad.len() - 1);
        let cut_s = [from, angle_rad.len() - 1 - to].map(|count| count as f64 * SPACING_S);
        Ok(Self {
            is_clamped,
            angle_rad: angle_rad[from..=to].to_vec(),
            cut_s,
            width_s,
        })
    }

    /// Duration in s.
    pub fn duration_s(&self) -> f64 {
        (self.angle_rad.len() - 1) as f64 * SPACING_S
    }

    /// The motion as a file that `armbridge run` takes.
    pub fn csv(&self) -> String {
        let mut text = format!(
            "# A motion that a hand has taught, smoothed over {} ms.\ntime_s,q1_rad,q2_rad\n",
            self.width_s * 1e3
        );
        for (number, [a, b]) in self.angle_rad.iter().enumerate() {
            // A string takes every line.
            let _ = writeln!(text, "{:.2},{a:.5},{b:.5}", number as f64 * SPACING_S);
        }
        text
    }
}

/// The nearest angle in rad that a replay may reach.
fn hold_in_range(q: f64) -> f64 {
    let most = f64::from(REFERENCE_MAX_RAD) - MARGIN_RAD;
    q.clamp(-most, most)
}

/// Largest difference of the angles of a joint.
fn distance(a: &[f64; JOINTS], b: &[f64; JOINTS]) -> f64 {
    (a[0] - b[0]).abs().max((a[1] - b[1]).abs())
}

/// Weighted means of samples in order of time, [`SPACING_S`] apart.
fn smooth(samples: &[Sample], width_s: f64) -> Vec<[f64; JOINTS]> {
    let (start_s, end_s) = (samples[0].0, samples[samples.len() - 1].0);
    let count = ((end_s - start_s) / SPACING_S) as usize + 1;
    let mean = |number: usize| {
        let at_s = start_s + number as f64 * SPACING_S;
        let reach_s = WIDTHS * width_s;
        let from = samples.partition_point(|sample| sample.0 < at_s - reach_s);
        let to = samples.partition_point(|sample| sample.0 <= at_s + reach_s);
        let (mut sum, mut weights) = ([0.0; JOINTS], 0.0);
        for (time_s, q) in &samples[from..to] {
            let weight = (-0.5 * ((time_s - at_s) / width_s).powi(2)).exp();
            weights += weight;
            for (sum, q) in sum.iter_mut().zip(q) {
                *sum += weight * q;
            }
        }
        sum.map(|sum| sum / weights)
    };
    (0..count).map(mean).collect()
}

/// Whether speeds and accelerations leave a share of a motion's bounds.
fn is_within_bounds(angle_rad: &[[f64; JOINTS]]) -> bool {
    let step = (SLOPE_S / SPACING_S) as usize;
    let windows = angle_rad.windows(2 * step + 1);
    windows.into_iter().all(|window| {
        (0..JOINTS).all(|joint| {
            let [before, q, after] = [0, step, 2 * step].map(|index| window[index][joint]);
            let speed = (after - before) / (2.0 * SLOPE_S);
            let acceleration = (after - 2.0 * q + before) / (SLOPE_S * SLOPE_S);
            speed.abs() < SHARE * f64::from(MOTION.speed_rad_s)
                && acceleration.abs() < SHARE * f64::from(MOTION.acceleration_rad_s2)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples at 1 kHz of a rest, a sine of this frequency, and a rest, with a count of noise.
    fn led(frequency_hz: f64, rest_s: f64) -> Vec<Sample> {
        let length_s = 2.0 / frequency_hz;
        let count = ((2.0 * rest_s + length_s) * 1e3) as u32;
        let samples = (0..count).map(|number| {
            let at_s = f64::from(number) * 1e-3;
            let phase = ((at_s - rest_s).clamp(0.0, length_s)) * frequency_hz;
            let angle = 0.5 * (1.0 - (std::f64::consts::TAU * phase).cos());
            let noise = f64::from(number.wrapping_mul(2_654_435_761) >> 16) / 65_536.0 - 0.5;
            (at_s, [angle + 0.01 * noise, -0.3])
        });
        samples.collect()
    }

    #[test]
    fn rests_are_cut_off_and_noise_is_smoothed() {
        let taught = TaughtMotion::from_samples(&led(0.5, 3.0)).unwrap();
        assert!(
            (taught.duration_s() - 4.6).abs() < 0.3,
            "{} s",
            taught.duration_s()
        );
        assert!(
            taught.cut_s.iter().all(|s| (2.6..2.95).contains(s)),
            "{:?}",
            taught.cut_s
        );
        assert!(
            !taught.is_clamped && taught.width_s < 0.1,
            "{}",
            taught.width_s
        );
        for (number, [a, _]) in taught.angle_rad.iter().enumerate() {
            let at_s = number as f64 * SPACING_S + taught.cut_s[0] - 3.0;
            let phase = at_s.clamp(0.0, 4.0) * 0.5;
            let angle = 0.5 * (1.0 - (std::f64::consts::TAU * phase).cos());
            assert!((a - angle).abs() < 0.012, "{at_s} s: {a}, {angle}");
        }
        let csv = taught.csv();
        assert_eq!(csv.lines().nth(1), Some("time_s,q1_rad,q2_rad"));
        assert_eq!(csv.lines().count(), taught.angle_rad.len() + 2);
    }

    #[test]
    fn a_hasty_motion_is_smoothed_more() {
        let [slow, hasty] = [0.5, 1.4].map(|hz| TaughtMotion::from_samples(&led(hz, 1.0)).unwrap());
        assert!(
            hasty.width_s > slow.width_s,
            "{} {}",
            hasty.width_s,
            slow.width_s
        );
    }

    #[test]
    fn without_motion_there_is_nothing_to_teach() {
        assert_eq!(TaughtMotion::from_samples(&[]), Err(TeachError::NoFloat));
        let rest: Vec<Sample> = (0..1_000)
            .map(|n| (f64::from(n) * 1e-3, [0.1, 0.2]))
            .collect();
        let error = TaughtMotion::from_samples(&rest).unwrap_err();
        assert!(matches!(error, TeachError::NoMotion { .. }), "{error}");
    }
}
