//! Measurements: where a joint is held, and which way it was turned.
//!
//! Whether it was still is judged against noise, not by least and most counts, which grow
//! with the number of samples: by the means of both halves and by the scatter. A still joint
//! whose encoder has up to 2 counts rms of white noise is refused less than once in a
//! million measurements; one that creeps by more than 1.25 counts from half to half is. Counts are
//! those of an AX-12A; those of an X servo are 3.3 times as many for the same angles.

use super::Unusable;
use armbridge_control::actuator::Direction;
use armbridge_control::encoder::Encoder;
use armbridge_link::message::Record;
use armbridge_servo::JOINTS;

/// Ticks that a measurement takes: 0.3 s at 1 kHz, longer than a hand trembles.
const TICKS: u32 = 300;
/// Largest difference between the means of both halves, in counts. Noise of 2 counts, and
/// rounding, gives differences of 2 * 2.02 / sqrt(270) = 0.25 counts rms: this is five times
/// that, exceeded once in 2 million measurements.
const DRIFT_MAX: f64 = 1.25;
/// Largest rms deviation from the mean, in counts. That of 270 samples of the same noise
/// exceeds 2.45 once in a million measurements (chi-square with 269 degrees of freedom).
const SCATTER_MAX: f64 = 2.5;
/// Share of the samples that must have come.
const SHARE_MIN: f64 = 0.9;
/// Counts from either end at which a potentiometer is not to be trusted, and an encoder of a turn is
/// about to begin again.
const END: u16 = 10;
/// Counts by which a joint must have been turned: 0.3 rad, by far more than noise and
/// play.
const TURN_MIN: f64 = 60.0;

/// Positions of both joints, in counts.
pub(super) type Pose = [f64; JOINTS];

/// Counts of this encoder for the angle of one count of an AX-12A.
fn scale(encoder: Encoder) -> f64 {
    Encoder::Ax12a.nominal_rad_per_count() / encoder.nominal_rad_per_count()
}

/// Counts that are being taken.
#[derive(Debug)]
pub(super) struct Sampler {
    encoder: Encoder,
    tick: Option<u32>,
    ticks: u32,
    counts: [Vec<u16>; JOINTS],
}

impl Sampler {
    /// No counts of such an encoder yet.
    pub(super) fn new(encoder: Encoder) -> Self {
        Self {
            encoder,
            tick: None,
            ticks: 0,
            counts: [const { Vec::new() }; JOINTS],
        }
    }

    /// Takes a tick, once. True when it is enough.
    pub(super) fn take(&mut self, record: &Record) -> bool {
        if self.tick.replace(record.tick) != Some(record.tick) {
            self.ticks += 1;
            for (counts, sample) in self.counts.iter_mut().zip(record.input.samples) {
                counts.extend(sample.counts());
            }
        }
        self.ticks >= TICKS
    }

    /// Position of `joint`, which is held, and of the other one.
    pub(super) fn pose(&self, joint: usize) -> Result<Pose, Unusable> {
        let number = joint + 1;
        let counts = &self.counts[joint];
        let here = counts.len() as u32;
        if f64::from(here) < SHARE_MIN * f64::from(self.ticks) {
            return Err(Unusable::Missing {
                joint: number,
                missing: self.ticks - here,
                of: self.ticks,
            });
        }
        let least = counts.iter().copied().min().unwrap_or_default();
        let most = counts.iter().copied().max().unwrap_or_default();
        let end = self.encoder.counts_max() - END;
        for count in [least, most] {
            if !(END..=end).contains(&count) {
                return Err(Unusable::AtEnd {
                    joint: number,
                    count,
                    least: END,
                    most: end,
                });
            }
        }
        let scale = scale(self.encoder);
        let (first, second) = counts.split_at(counts.len() / 2);
        let drift = mean(second) - mean(first);
        if drift.abs() > DRIFT_MAX * scale {
            return Err(Unusable::Moved {
                joint: number,
                drift,
                allowed: DRIFT_MAX * scale,
            });
        }
        let scatter = scatter(counts);
        if scatter > SCATTER_MAX * scale {
            return Err(Unusable::Noisy {
                joint: number,
                scatter,
                allowed: SCATTER_MAX * scale,
            });
        }
        Ok([0, 1].map(|joint| mean(&self.counts[joint])))
    }
}

fn mean(counts: &[u16]) -> f64 {
    let sum: f64 = counts.iter().map(|count| f64::from(*count)).sum();
    sum / counts.len().max(1) as f64
}

/// Rms deviation from the mean.
fn scatter(counts: &[u16]) -> f64 {
    let mean = mean(counts);
    let squares = counts
        .iter()
        .map(|count| (f64::from(*count) - mean).powi(2));
    (squares.sum::<f64>() / counts.len().max(1) as f64).sqrt()
}

/// Sign of `joint`: whether its counts rise towards positive angles.
pub(super) fn direction(
    joint: usize,
    zero: &Pose,
    turned: &Pose,
    encoder: Encoder,
) -> Result<Direction, Unusable> {
    let least = TURN_MIN * scale(encoder);
    let other = 1 - joint;
    let moved = turned[joint] - zero[joint];
    let other_moved = turned[other] - zero[other];
    if other_moved.abs() >= least && other_moved.abs() > moved.abs() {
        return Err(Unusable::OtherJoint {
            joint: joint + 1,
            moved,
            other: other + 1,
            other_moved,
        });
    }
    if moved.abs() >= least && other_moved.abs() >= least {
        return Err(Unusable::Both {
            joint: joint + 1,
            moved,
            other: other + 1,
            other_moved,
        });
    }
    if moved.abs() < least {
        return Err(Unusable::TooLittle {
            joint: joint + 1,
            moved,
            least,
        });
    }
    Ok(if moved > 0.0 {
        Direction::Forward
    } else {
        Direction::Reverse
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use armbridge_link::message::{Missing, Mode, Sample, TickInput};
    use rand_distr::{Distribution, StandardNormal};
    use rand_pcg::Pcg32;

    const AX: Encoder = Encoder::Ax12a;

    fn record(tick: u32, samples: [Sample; JOINTS]) -> Record {
        Record {
            tick,
            mode: Mode::Idle,
            input: TickInput {
                samples,
                ..TickInput::AT_REST
            },
            ..Record::NONE
        }
    }

    /// Of counts of joint 1 that depend on the tick, each tick seen twice.
    fn pose(count: impl Fn(u32) -> Option<u16>) -> Result<Pose, Unusable> {
        let mut sampler = Sampler::new(AX);
        for tick in 1.. {
            let sample = count(tick).map_or(Sample::Missing(Missing::Silence), Sample::Counts);
            let record = record(tick, [sample, Sample::Counts(700)]);
            let is_enough = sampler.take(&record);
            assert_eq!(sampler.take(&record), is_enough, "a tick counts once");
            if is_enough {
                break;
            }
        }
        sampler.pose(0)
    }

    #[test]
    fn a_joint_that_is_held_has_a_mean() {
        let held = pose(|tick| Some(510 + (tick % 4) as u16)).unwrap();
        assert!(
            (held[0] - 511.5).abs() < 1e-9 && (held[1] - 700.0).abs() < 1e-9,
            "{held:?}"
        );
    }

    /// A joint at `at(tick)` counts, with noise of this many counts rms.
    fn noisy(seed: u64, noise: f64, at: impl Fn(f64) -> f64) -> Result<Pose, Unusable> {
        let mut random = Pcg32::new(seed, 0);
        let counts: Vec<u16> = (0..=TICKS)
            .map(|tick| {
                let z: f64 = StandardNormal.sample(&mut random);
                (at(f64::from(tick)) + noise * z).round() as u16
            })
            .collect();
        pose(|tick| Some(counts[tick as usize]))
    }

    #[test]
    fn noise_is_no_motion_and_slow_motion_is_no_noise() {
        for noise in [0.0, 0.3, 1.0, 2.0] {
            for seed in 0..500 {
                let held = noisy(seed, noise, |_| 511.6);
                let held = held.unwrap_or_else(|why| panic!("{noise} counts, {seed}: {why}"));
                assert!((held[0] - 511.6).abs() < 0.7, "{noise} counts: {held:?}");
                // 5 counts in the 0.3 s, 0.09 rad/s: half of it from half to half.
                let creeps = noisy(seed, noise, |tick| 511.6 + tick / 60.0);
                assert!(
                    matches!(creeps, Err(Unusable::Moved { joint: 1, .. })),
                    "{noise} counts, {seed}: {creeps:?}"
                );
            }
        }
    }

    #[test]
    fn what_is_no_use_is_refused() {
        let swings = pose(|tick| Some(500 + (tick % 20) as u16)).unwrap_err();
        assert!(
            matches!(swings, Unusable::Noisy { joint: 1, .. }),
            "{swings}"
        );
        assert!(
            swings.to_string().contains("scatter by 5.8 rms"),
            "{swings}"
        );
        assert_eq!(
            pose(|tick| (tick % 5 > 0).then_some(500)),
            Err(Unusable::Missing {
                joint: 1,
                missing: 60,
                of: 300
            })
        );
        assert_eq!(
            pose(|_| Some(1_020)),
            Err(Unusable::AtEnd {
                joint: 1,
                count: 1_020,
                least: 10,
                most: 1_013
            })
        );
    }

    #[test]
    fn the_sign_is_that_of_the_turn() {
        let zero = [512.0, 500.0];
        assert_eq!(
            direction(0, &zero, &[600.0, 500.0], AX),
            Ok(Direction::Forward)
        );
        assert_eq!(
            direction(1, &zero, &[512.0, 380.0], AX),
            Ok(Direction::Reverse)
        );
        // The other one hangs from this one and may follow it.
        assert_eq!(
            direction(0, &zero, &[600.0, 520.0], AX),
            Ok(Direction::Forward)
        );
        for (turned, words) in [
            ([530.0, 500.0], "by 18 counts only"),
            ([512.0, 380.0], "joint 2 by -120: turn one joint alone"),
            (
                [600.0, 580.0],
                "by 88 counts and joint 2 by 80: turn one joint alone",
            ),
        ] {
            let error = direction(0, &zero, &turned, AX).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
    }
}
