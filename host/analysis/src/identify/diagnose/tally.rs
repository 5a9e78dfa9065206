//! Tally of ticks: recorded, with an angle, at a limit.

use armbridge_link::message::{Record, Settings};
use armbridge_servo::JOINTS;

use super::super::dataset::Trace;
use super::super::record::is_at_end;
use super::Diagnosis;

/// Largest tolerated fraction of ticks without an angle. Isolated ones do no harm; a board
/// switches off long before.
const LOST_FRACTION: f64 = 0.1;
/// Largest tolerated fraction of ticks with an encoder at an end of its track.
const AT_END_FRACTION: f64 = 0.1;
/// Largest tolerated fraction of ticks with a motor at its limit.
const AT_LIMIT_FRACTION: f64 = 0.4;
/// Fraction of a limit that counts as the limit itself: PWM is rounded.
const LIMIT_FRACTION: f32 = 0.995;
/// Full PWM in counts from neutral.
const FULL_COUNTS: u16 = 1_000;

/// Ticks in which the motors are driven.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Recorded ticks.
    pub ticks: usize,
    /// Unrecorded ticks between recorded ones.
    pub unrecorded: usize,
    /// Gaps of unrecorded ticks.
    pub gaps: usize,
    /// Tally of each joint.
    pub joints: [JointTally; JOINTS],
}

/// Tally of a joint's ticks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct JointTally {
    /// Ticks without an angle.
    pub without_angle: usize,
    /// Ticks with the encoder at an end of its track.
    pub at_end: usize,
    /// Ticks with the motor at its limit.
    pub at_limit: usize,
}

impl Tally {
    /// Tally of traces alone, without the ticks between them.
    pub fn from_traces(traces: &[Trace]) -> Self {
        let mut tally = Self::default();
        for trace in traces {
            for (pwm, counts) in trace.pwm.iter().zip(&trace.counts) {
                tally.ticks += 1;
                for (joint, joint_tally) in tally.joints.iter_mut().enumerate() {
                    joint_tally.count_sample(counts[joint]);
                    joint_tally.at_limit += usize::from(pwm[joint].abs_diff(1_000) >= FULL_COUNTS);
                }
            }
        }
        tally
    }

    /// Adds the ticks of a log.
    pub fn add(&mut self, records: &[Record], settings: &Settings) {
        let Settings { setup, limits } = settings;
        let joints = setup.arm.joints();
        let mut before: Option<u32> = None;
        for record in records
            .iter()
            .filter(|record| record.mode.drive().is_some())
        {
            // Between two driven periods, ticks may be undriven or unrecorded.
            let between = before.map_or(0, |before| record.tick.wrapping_sub(before) - 1);
            before = Some(record.tick);
            self.gaps += usize::from(between > 0);
            self.unrecorded += between as usize;
            self.ticks += 1;
            for (joint, joint_tally) in self.joints.iter_mut().enumerate().take(joints) {
                joint_tally.count_sample(record.input.samples[joint].counts());
                let pwm = record.input.pwm_in_force[joint].abs_diff(1_000);
                let torque = record.output.torque_nm[joint].abs();
                let is_at_limit =
                    pwm >= limits.pwm_counts || torque >= LIMIT_FRACTION * limits.torque_nm[joint];
                joint_tally.at_limit += usize::from(is_at_limit);
            }
        }
    }

    /// Checks that enough ticks are recorded, and few of them at a limit.
    ///
    /// # Errors
    /// If no ticks are, too few, or too many at a limit.
    pub(super) fn check(&self) -> Result<(), Diagnosis> {
        if self.ticks == 0 {
            return Err(Diagnosis::Empty);
        }
        let all = self.ticks + self.unrecorded;
        let percent = |count: usize, ticks: usize| 100.0 * count as f64 / ticks as f64;
        for (joint, joint_tally) in self.joints.iter().enumerate() {
            if (joint_tally.without_angle + self.unrecorded) as f64 > LOST_FRACTION * all as f64 {
                return Err(Diagnosis::LostSamples {
                    joint: joint + 1,
                    percent: percent(joint_tally.without_angle + self.unrecorded, all),
                    ticks: all,
                    without_angle: joint_tally.without_angle,
                    unrecorded: self.unrecorded,
                    gaps: self.gaps,
                });
            }
        }
        for (joint, joint_tally) in self.joints.iter().enumerate() {
            if joint_tally.at_end as f64 > AT_END_FRACTION * self.ticks as f64 {
                return Err(Diagnosis::ClippedEncoder {
                    joint: joint + 1,
                    percent: percent(joint_tally.at_end, self.ticks),
                });
            }
            if joint_tally.at_limit as f64 > AT_LIMIT_FRACTION * self.ticks as f64 {
                return Err(Diagnosis::ClippedMotor {
                    joint: joint + 1,
                    percent: percent(joint_tally.at_limit, self.ticks),
                });
            }
        }
        Ok(())
    }
}

impl JointTally {
    fn count_sample(&mut self, counts: Option<u16>) {
        match counts {
            Some(counts) => self.at_end += usize::from(is_at_end(counts)),
            None => self.without_angle += 1,
        }
    }
}
