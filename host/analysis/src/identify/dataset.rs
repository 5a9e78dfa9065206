//! Data of a fit: PWM sent to the servos, encoder counts, and windows in which a joint
//! slides.

use armbridge_servo::{JOINTS, Pwm};

use super::arm::KnownParameters;

/// Consecutive ticks without a gap.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    /// Index of the log.
    pub log: usize,
    /// Time of the first tick in s, from the first record of the log.
    pub start_s: f64,
    /// PWM in force in each tick.
    pub pwm: Vec<[u16; JOINTS]>,
    /// Encoder counts in each tick; `None` if missing or at an end of the track.
    pub counts: Vec<[Option<u16>; JOINTS]>,
    /// Smoothed angle in rad and speed in rad/s of each joint: a line fitted to its encoder's
    /// counts about each tick.
    pub states: Vec<[[f64; 2]; JOINTS]>,
}

/// Ticks in which a joint slides, and reverses without resting.
#[derive(Clone, Debug)]
pub struct Window {
    /// Index of the trace.
    pub trace: usize,
    /// Joint, from 0.
    pub joint: usize,
    /// First tick.
    pub first: usize,
    /// Length in ticks.
    pub len: usize,
}

/// Ticks on either side of one in the line fit of its speed.
const HALF_WIDTH: usize = 25;
/// Speed in rad/s above which a joint counts as sliding: 5 standard deviations with noise
/// of a count.
const SLIDES_RAD_S: f64 = 0.17;
/// Neutral PWM.
pub(super) const NEUTRAL: u16 = Pwm::OFF.counts();
/// Counts from neutral up to which torque is proportional to PWM; above, the gears or the
/// supply of a strong motor may limit it.
pub(super) const LINEAR_PWM_COUNTS: u16 = 700;
/// Most ticks that a joint which reverses without resting is slower than
/// [`SLIDES_RAD_S`].
const REVERSAL_TICKS: usize = 30;
/// Shortest window in ticks.
const WINDOW_MIN: usize = 120;

impl Trace {
    /// Computes [`states`](Self::states) with these encoder zeros.
    #[must_use]
    pub fn smoothed(&self, known: &KnownParameters, zero: [f64; JOINTS]) -> Self {
        let mut before = [[0.0; 2]; JOINTS];
        let states = (0..self.counts.len())
            .map(|tick| {
                before = core::array::from_fn(|joint| {
                    self.fit_line(joint, tick, HALF_WIDTH).map_or(
                        before[joint],
                        |[position, rate]| {
                            let scale = known.rad_per_count[joint];
                            [
                                (position - zero[joint]) * scale,
                                rate * scale / known.period_s,
                            ]
                        },
                    )
                });
                before
            })
            .collect();
        Self {
            states,
            ..self.clone()
        }
    }

    /// PWM in force in a tick; that of the first or last tick beyond them.
    pub(super) fn pwm_at(&self, tick: i64, joint: usize) -> u16 {
        let last = self.pwm.len().saturating_sub(1);
        let tick = usize::try_from(tick).unwrap_or(0).min(last);
        self.pwm.get(tick).map_or(NEUTRAL, |pwm| pwm[joint])
    }

    /// Position at a tick and its rate per tick, by a line through `half_width` ticks on
    /// either side.
    pub(super) fn fit_line(
        &self,
        joint: usize,
        tick: usize,
        half_width: usize,
    ) -> Option<[f64; 2]> {
        let first = tick.saturating_sub(half_width);
        let last = (tick + half_width).min(self.counts.len() - 1);
        let (mut n, mut sum_x, mut sum_y, mut sum_xy, mut sum_xx) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (index, counts) in self.counts[first..=last].iter().enumerate() {
            let Some(count) = counts[joint] else { continue };
            let x = (first + index) as f64 - tick as f64;
            let y = f64::from(count);
            n += 1.0;
            sum_x += x;
            sum_y += y;
            sum_xy += x * y;
            sum_xx += x * x;
        }
        let determinant = n * sum_xx - sum_x * sum_x;
        (n > half_width as f64 * 0.8 && determinant > 0.0).then(|| {
            let rate = (n * sum_xy - sum_x * sum_y) / determinant;
            [(sum_y - rate * sum_x) / n, rate]
        })
    }

    /// All windows of a joint, of at most `max_len` ticks and the duration of a reversal.
    pub(super) fn windows(&self, trace: usize, joint: usize, max_len: usize) -> Vec<Window> {
        let mut windows = Vec::new();
        let mut from = 0;
        while let Some(first) = (from..self.states.len()).find(|tick| self.slides(*tick, joint)) {
            let end = self.sliding_end(first, joint);
            from = end;
            // Near the threshold speed the joint may have been at rest a moment before.
            let end = end.saturating_sub(HALF_WIDTH);
            let Some(mut first) = (first + HALF_WIDTH..end).find(|tick| self.slides(*tick, joint))
            else {
                continue;
            };
            while end >= first + WINDOW_MIN {
                // Parts of about the same length, each from a tick in which the joint slides.
                let parts = (end - first).div_ceil(max_len);
                let part = first + (end - first) / parts;
                let begins = (part..end).find(|tick| parts > 1 && self.slides(*tick, joint));
                let len = begins.unwrap_or(end) - first;
                windows.push(Window {
                    trace,
                    joint,
                    first,
                    len,
                });
                first += len;
            }
        }
        windows
    }

    /// Whether a joint slides in a tick, and its torque is proportional to PWM.
    fn slides(&self, tick: usize, joint: usize) -> bool {
        self.states[tick][joint][1].abs() > SLIDES_RAD_S && self.is_pwm_linear(tick, joint)
    }

    fn is_pwm_linear(&self, tick: usize, joint: usize) -> bool {
        self.pwm[tick][joint].abs_diff(NEUTRAL) <= LINEAR_PWM_COUNTS
    }

    /// End of sliding, from a tick in which a joint slides; reversals without rest do not end
    /// it.
    fn sliding_end(&self, first: usize, joint: usize) -> usize {
        let mut end = first;
        let linear = (first..self.states.len()).take_while(|tick| self.is_pwm_linear(*tick, joint));
        for tick in linear {
            if self.slides(tick, joint) {
                end = tick + 1;
            } else if tick - end >= REVERSAL_TICKS {
                break;
            }
        }
        end
    }
}

/// Standard deviation of the noise of this number of encoders in counts, from second differences of the
/// positions: the arm's accelerations are negligible there.
pub(super) fn encoder_noise_counts(traces: &[Trace], joints: usize) -> f64 {
    let (mut squares, mut count) = (0.0, 0.0);
    for three in traces.iter().flat_map(|trace| trace.counts.windows(3)) {
        let [before, here, after] = [0, 1, 2].map(|tick| three[tick].map(|c| c.map(f64::from)));
        for ((a, b), c) in before.into_iter().zip(here).zip(after).take(joints) {
            if let (Some(a), Some(b), Some(c)) = (a, b, c) {
                // Noise enters with weights 1, -2 and 1.
                squares += (a - 2.0 * b + c).powi(2) / 6.0;
                count += 1.0;
            }
        }
    }
    // Rounding alone is a third of a count.
    f64::sqrt(squares / f64::max(count, 1.0)).max(0.5)
}
