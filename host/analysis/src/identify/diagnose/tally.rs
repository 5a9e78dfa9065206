//! Ticks counted: how many came, how many say an angle, how many are at a limit.

use armbridge_shared::JOINTS;
use armbridge_shared::link::limits::Limits;
use armbridge_shared::link::message::Record;

use super::super::dataset::Trace;
use super::super::record::END_COUNTS;
use super::Diagnosis;

/// Share of the ticks that may be without an angle. Ones and twos here and there do no
/// harm; a board switches off long before.
const LOST: f64 = 0.1;
/// Share of the ticks in which an encoder may be at an end of its track.
const AT_END: f64 = 0.1;
/// Share of the ticks in which a motor may give all it may.
const AT_LIMIT: f64 = 0.4;
/// Share of a limit that counts as the limit itself: a PWM is rounded.
const NEARLY: f32 = 0.995;
/// Counts from off beyond which no PWM goes.
const FULL_COUNTS: u16 = 1_000;

/// Ticks in which the motors are driven.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Recorded.
    pub ticks: usize,
    /// Not recorded, between two that are.
    pub missed: usize,
    /// Stretches of such.
    pub gaps: usize,
    /// What they say of each joint.
    pub joints: [OfJoint; JOINTS],
}

/// Ticks of a joint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OfJoint {
    /// Without an angle.
    pub silent: usize,
    /// With the encoder at an end of its track.
    pub at_end: usize,
    /// With the motor at its limit.
    pub at_limit: usize,
}

impl Tally {
    /// Of traces alone: what is between them is not known.
    pub fn of_traces(traces: &[Trace]) -> Self {
        let mut tally = Self::default();
        for trace in traces {
            for (pwm, counts) in trace.pwm.iter().zip(&trace.counts) {
                tally.ticks += 1;
                for (joint, of) in tally.joints.iter_mut().enumerate() {
                    of.see(counts[joint]);
                    of.at_limit += usize::from(pwm[joint].abs_diff(1_000) >= FULL_COUNTS);
                }
            }
        }
        tally
    }

    /// Adds a log's.
    pub fn add(&mut self, records: &[Record], limits: &Limits) {
        let mut before: Option<u32> = None;
        for record in records
            .iter()
            .filter(|record| record.mode.drive().is_some())
        {
            // What lies between two stretches of being driven may be anything.
            let between = before.map_or(0, |before| record.tick.wrapping_sub(before) - 1);
            before = Some(record.tick);
            self.gaps += usize::from(between > 0);
            self.missed += between as usize;
            self.ticks += 1;
            for (joint, of) in self.joints.iter_mut().enumerate() {
                of.see(record.samples[joint].counts());
                let pwm = record.pwm_in_force[joint].abs_diff(1_000);
                let torque = record.torque_nm[joint].abs();
                let is_at_limit =
                    pwm >= limits.pwm_counts || torque >= NEARLY * limits.torque_nm[joint];
                of.at_limit += usize::from(is_at_limit);
            }
        }
    }

    /// Whether so many came that it is worth looking at them.
    ///
    /// # Errors
    /// If none did, too few, or too many are at a limit.
    pub(super) fn check(&self) -> Result<(), Diagnosis> {
        if self.ticks == 0 {
            return Err(Diagnosis::Empty);
        }
        let all = self.ticks + self.missed;
        let percent = |count: usize, of: usize| 100.0 * count as f64 / of as f64;
        for (joint, of) in self.joints.iter().enumerate() {
            if (of.silent + self.missed) as f64 > LOST * all as f64 {
                return Err(Diagnosis::LostSamples {
                    joint: joint + 1,
                    percent: percent(of.silent + self.missed, all),
                    ticks: all,
                    silent: of.silent,
                    missed: self.missed,
                    gaps: self.gaps,
                });
            }
        }
        for (joint, of) in self.joints.iter().enumerate() {
            if of.at_end as f64 > AT_END * self.ticks as f64 {
                return Err(Diagnosis::ClippedEncoder {
                    joint: joint + 1,
                    percent: percent(of.at_end, self.ticks),
                });
            }
            if of.at_limit as f64 > AT_LIMIT * self.ticks as f64 {
                return Err(Diagnosis::ClippedMotor {
                    joint: joint + 1,
                    percent: percent(of.at_limit, self.ticks),
                });
            }
        }
        Ok(())
    }
}

impl OfJoint {
    fn see(&mut self, counts: Option<u16>) {
        match counts {
            Some(counts) => {
                let range = END_COUNTS..=1_023 - END_COUNTS;
                self.at_end += usize::from(!range.contains(&counts));
            }
            None => self.silent += 1,
        }
    }
}
