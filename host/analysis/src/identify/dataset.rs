//! What is fitted: PWM sent to the servos, and counts of their encoders.

use armbridge_shared::JOINTS;
use armbridge_shared::actuator::Pwm;

use super::arm::Known;

/// Ticks without a gap.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    /// Index of the log it is of.
    pub log: usize,
    /// When it begins, in s after the first record of that log.
    pub since_s: f64,
    /// PWM in force in each tick.
    pub pwm: Vec<[u16; JOINTS]>,
    /// Encoder counts in each tick, where they came and are on the track.
    pub counts: Vec<[Option<u16>; JOINTS]>,
    /// Angle in rad and speed in rad/s of each joint, by a line through its encoder's
    /// counts around each tick.
    pub smooth: Vec<[[f64; 2]; JOINTS]>,
}

/// A stretch in which a joint slides, and turns round at once where it does.
#[derive(Clone, Debug)]
pub struct Window {
    /// Index of the trace.
    pub trace: usize,
    /// From 0.
    pub joint: usize,
    /// First tick.
    pub first: usize,
    /// Ticks.
    pub len: usize,
}

/// Ticks to either side of one over which a speed is taken.
const AROUND: usize = 25;
/// Speed in rad/s above which a joint surely slides: 5 standard deviations with noise of
/// a count.
const SLIDES_RAD_S: f64 = 0.17;
/// PWM at which a motor is off.
pub(super) const OFF: u16 = Pwm::OFF.counts();
/// Counts from off up to which torque grows with PWM; with more, a strong motor comes to
/// what its gears or its supply let it make.
pub(super) const FAIR_COUNTS: u16 = 700;
/// Ticks in which a joint that turns round without resting is slower than
/// [`SLIDES_RAD_S`].
const TURN: usize = 30;
/// Shortest window in ticks that is of use.
const SHORTEST: usize = 120;

impl Trace {
    /// Works out [`smooth`](Self::smooth), with zeros as they are believed.
    #[must_use]
    pub fn smoothed(&self, known: &Known, zero: [f64; JOINTS]) -> Self {
        let mut before = [[0.0; 2]; JOINTS];
        let smooth = (0..self.counts.len())
            .map(|tick| {
                before = core::array::from_fn(|joint| {
                    self.line(joint, tick, AROUND)
                        .map_or(before[joint], |[position, rate]| {
                            let scale = known.rad_per_count[joint];
                            [
                                (position - zero[joint]) * scale,
                                rate * scale / known.period_s,
                            ]
                        })
                });
                before
            })
            .collect();
        Self {
            smooth,
            ..self.clone()
        }
    }

    /// PWM in force in a tick; before the first and after the last, as there.
    pub(super) fn pwm_at(&self, tick: i64, joint: usize) -> u16 {
        let last = self.pwm.len().saturating_sub(1);
        let tick = usize::try_from(tick).unwrap_or(0).min(last);
        self.pwm.get(tick).map_or(OFF, |pwm| pwm[joint])
    }

    /// Position at a tick and its rate per tick, by a line through so many to either side.
    pub(super) fn line(&self, joint: usize, tick: usize, around: usize) -> Option<[f64; 2]> {
        let first = tick.saturating_sub(around);
        let last = (tick + around).min(self.counts.len() - 1);
        let (mut n, mut at, mut sum, mut slope, mut square) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (index, counts) in self.counts[first..=last].iter().enumerate() {
            let Some(count) = counts[joint] else { continue };
            let x = (first + index) as f64 - tick as f64;
            let y = f64::from(count);
            n += 1.0;
            at += x;
            sum += y;
            slope += x * y;
            square += x * x;
        }
        let spread = n * square - at * at;
        (n > around as f64 * 0.8 && spread > 0.0).then(|| {
            let rate = (n * slope - at * sum) / spread;
            [(sum - rate * at) / n, rate]
        })
    }

    /// All windows of a joint, none longer than `most` ticks by more than a turn takes.
    pub(super) fn windows(&self, trace: usize, joint: usize, most: usize) -> Vec<Window> {
        let mut windows = Vec::new();
        let mut from = 0;
        while let Some(first) = (from..self.smooth.len()).find(|tick| self.slides(*tick, joint)) {
            let end = self.slides_until(first, joint);
            from = end;
            // Where its speed is just enough the joint may have stood a moment before.
            let end = end.saturating_sub(AROUND);
            let Some(mut first) = (first + AROUND..end).find(|tick| self.slides(*tick, joint))
            else {
                continue;
            };
            while end >= first + SHORTEST {
                // Parts of about the same length, each from where it surely slides.
                let parts = (end - first).div_ceil(most);
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

    /// Whether a joint surely slides in a tick, and its motor makes the torque of its PWM.
    fn slides(&self, tick: usize, joint: usize) -> bool {
        self.smooth[tick][joint][1].abs() > SLIDES_RAD_S && self.is_fair(tick, joint)
    }

    fn is_fair(&self, tick: usize, joint: usize) -> bool {
        self.pwm[tick][joint].abs_diff(OFF) <= FAIR_COUNTS
    }

    /// From a tick in which a joint slides, the end of the stretch in which it does, and
    /// turns round at once where it does.
    fn slides_until(&self, first: usize, joint: usize) -> usize {
        let mut end = first;
        let fair = (first..self.smooth.len()).take_while(|tick| self.is_fair(*tick, joint));
        for tick in fair {
            if self.slides(tick, joint) {
                end = tick + 1;
            } else if tick - end >= TURN {
                break;
            }
        }
        end
    }
}
