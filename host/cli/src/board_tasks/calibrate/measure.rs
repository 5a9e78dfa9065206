//! Measurements: where a joint is held, and which way it was turned.

use armbridge_shared::JOINTS;
use armbridge_shared::actuator::Direction;
use armbridge_shared::link::message::Record;

/// Ticks that a measurement takes: 0.3 s at 1 kHz, longer than a hand trembles.
const TICKS: u32 = 300;
/// Counts between least and most while the arm is held still. Its encoder's noise is
/// one or two; 6 are 31 mrad, and no zero.
const SPREAD_MAX: u16 = 6;
/// Share of the samples that must have come.
const SHARE_MIN: f64 = 0.9;
/// Counts from either end of the track at which a potentiometer is not to be trusted.
const END: u16 = 10;
/// Largest count.
const LAST: u16 = 1_023;
/// Counts by which a joint must have been turned: 0.3 rad, by far more than noise and
/// play.
const TURN_MIN: f64 = 60.0;

/// Why a measurement is unusable, and a remedy.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Unusable {
    /// It moved, or its encoder is noisy.
    #[error(
        "joint {joint} was not still: counts from {least} to {most}; hold it, and look at its \
         encoder if it was held"
    )]
    Noisy {
        /// From 1.
        joint: usize,
        /// Smallest count.
        least: u16,
        /// Largest count.
        most: u16,
    },
    /// Its servo did not answer often enough.
    #[error("{missing} of {of} samples of joint {joint} are missing; check its bus wiring")]
    Missing {
        /// From 1.
        joint: usize,
        /// Missing samples.
        missing: u32,
        /// Ticks.
        of: u32,
    },
    /// It is at an end of the potentiometer.
    #[error(
        "joint {joint} is at count {count}, where the encoder's track ends; mount its horn so that \
         it stays within {END} and {}", LAST - END
    )]
    AtEnd {
        /// From 1.
        joint: usize,
        /// Its count.
        count: u16,
    },
    /// It was not turned, or hardly.
    #[error(
        "joint {joint} was turned by {} counts only; turn it by 0.3 rad (60 counts) or more",
        moved.round() as i64
    )]
    TooLittle {
        /// From 1.
        joint: usize,
        /// In counts.
        moved: f64,
    },
    /// Another joint was.
    #[error(
        "joint {joint} was turned by {moved:.0} counts, but joint {other} by {other_moved:.0}: \
         turn one joint alone; if you did, the servos' ids are swapped"
    )]
    OtherJoint {
        /// From 1.
        joint: usize,
        /// In counts.
        moved: f64,
        /// From 1.
        other: usize,
        /// In counts.
        other_moved: f64,
    },
}

/// Positions of both joints, in counts.
pub(super) type Pose = [f64; JOINTS];

/// Counts that are being taken.
#[derive(Debug, Default)]
pub(super) struct Sampler {
    tick: Option<u32>,
    ticks: u32,
    counts: [Vec<u16>; JOINTS],
}

impl Sampler {
    /// Takes a tick, once. True when it is enough.
    pub(super) fn take(&mut self, record: &Record) -> bool {
        if self.tick.replace(record.tick) != Some(record.tick) {
            self.ticks += 1;
            for (counts, sample) in self.counts.iter_mut().zip(record.samples) {
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
        for count in [least, most] {
            if !(END..=LAST - END).contains(&count) {
                return Err(Unusable::AtEnd {
                    joint: number,
                    count,
                });
            }
        }
        if most - least > SPREAD_MAX {
            return Err(Unusable::Noisy {
                joint: number,
                least,
                most,
            });
        }
        Ok([0, 1].map(|joint| mean(&self.counts[joint])))
    }
}

fn mean(counts: &[u16]) -> f64 {
    let sum: f64 = counts.iter().map(|count| f64::from(*count)).sum();
    sum / counts.len().max(1) as f64
}

/// Sign of `joint`: whether its counts rise towards positive angles.
pub(super) fn direction(joint: usize, zero: &Pose, turned: &Pose) -> Result<Direction, Unusable> {
    let other = 1 - joint;
    let moved = turned[joint] - zero[joint];
    let other_moved = turned[other] - zero[other];
    if other_moved.abs() >= TURN_MIN && other_moved.abs() > moved.abs() {
        return Err(Unusable::OtherJoint {
            joint: joint + 1,
            moved,
            other: other + 1,
            other_moved,
        });
    }
    if moved.abs() < TURN_MIN {
        return Err(Unusable::TooLittle {
            joint: joint + 1,
            moved,
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
    use armbridge_shared::link::message::{Missing, Mode, Sample};

    fn record(tick: u32, samples: [Sample; JOINTS]) -> Record {
        Record {
            tick,
            mode: Mode::Idle,
            samples,
            ..Record::NONE
        }
    }

    /// Of counts of joint 1 that depend on the tick, each tick seen twice.
    fn pose(count: impl Fn(u32) -> Option<u16>) -> Result<Pose, Unusable> {
        let mut sampler = Sampler::default();
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

    #[test]
    fn what_is_no_use_is_refused() {
        assert_eq!(
            pose(|tick| Some(500 + (tick / 30) as u16)),
            Err(Unusable::Noisy {
                joint: 1,
                least: 500,
                most: 510
            })
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
                count: 1_020
            })
        );
    }

    #[test]
    fn the_sign_is_that_of_the_turn() {
        let zero = [512.0, 500.0];
        assert_eq!(direction(0, &zero, &[600.0, 500.0]), Ok(Direction::Forward));
        assert_eq!(direction(1, &zero, &[512.0, 380.0]), Ok(Direction::Reverse));
        // The other one hangs from this one and may follow it.
        assert_eq!(direction(0, &zero, &[600.0, 520.0]), Ok(Direction::Forward));
        for (turned, words) in [
            ([530.0, 500.0], "by 18 counts only"),
            ([512.0, 380.0], "joint 2 by -120: turn one joint alone"),
        ] {
            let error = direction(0, &zero, &turned).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
    }
}
