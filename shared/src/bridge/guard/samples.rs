//! One joint's samples: on the track of the potentiometer, and where the
//! estimator expects them.

use super::Violation;
use super::ticks::InRow;
use crate::link::limits::{Limits, hard};
use crate::link::mode::Fault;

/// Samples in a row in the gap. One may be damage that its checksum did not tell:
/// one in 256 does not.
const GAP_SAMPLES: u32 = 2;

/// Samples in a row far from where they were expected: one or two may be such
/// damage or a knock against the arm.
const OFF_SAMPLES: u32 = 3;

/// The monitor. Ticks without a sample do not come here, and break no row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Samples {
    /// First and last count on the track.
    track: [u16; 2],
    innovation_rad: f32,
    in_gap: InRow,
    off: InRow,
}

impl Samples {
    pub(super) fn new(limits: &Limits) -> Self {
        Self {
            track: [
                limits.dead_zone_counts,
                hard::COUNTS.saturating_sub(limits.dead_zone_counts),
            ],
            innovation_rad: limits.innovation_rad,
            in_gap: InRow::default(),
            off: InRow::default(),
        }
    }

    pub(super) fn restart(&mut self) {
        self.in_gap = InRow::default();
        self.off = InRow::default();
    }

    /// Where the encoder is.
    pub(super) fn place(&mut self, joint: u8, counts: u16) -> Result<(), Violation> {
        let [low, high] = self.track;
        let is_in_gap = !(low..=high).contains(&counts);
        if self.in_gap.note(is_in_gap, GAP_SAMPLES) {
            return Err(Violation {
                fault: Fault::DeadZone,
                joint: Some(joint),
                value: counts.into(),
                limit: if counts < low { low } else { high }.into(),
            });
        }
        Ok(())
    }

    /// How far that is from where it was expected.
    pub(super) fn innovation(&mut self, joint: u8, off_rad: f32) -> Result<(), Violation> {
        let off_rad = off_rad.abs();
        // So that what is not a number is off too.
        let is_near = off_rad <= self.innovation_rad;
        if self.off.note(!is_near, OFF_SAMPLES) {
            return Err(Violation {
                fault: Fault::Diverged,
                joint: Some(joint),
                value: off_rad,
                limit: self.innovation_rad,
            });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_samples_in_a_row_in_the_gap_are_no_accident() {
        for (at_end, inside) in [(7, 8), (1_016, 1_015), (1_023, 512)] {
            let mut samples = Samples::new(&Limits::default());
            for counts in [at_end, inside, at_end, inside, inside, at_end] {
                assert_eq!(samples.place(0, counts), Ok(()));
            }
            let violation = samples.place(0, at_end).unwrap_err();
            assert_eq!(violation.fault, Fault::DeadZone);
            assert!((violation.value - f32::from(at_end)).abs() < 0.5);
        }
    }

    #[test]
    fn three_samples_in_a_row_beside_the_estimate_are_no_accident() {
        for off in [0.1001, -0.1001, f32::NAN] {
            let mut samples = Samples::new(&Limits::default());
            for off in [off, off, 0.0999, off, off] {
                assert_eq!(samples.innovation(1, off), Ok(()));
            }
            let violation = samples.innovation(1, off).unwrap_err();
            assert_eq!(violation.fault, Fault::Diverged);
            assert_eq!(violation.joint, Some(1));
        }
    }
}
