//! Innovation monitor: whether one joint's samples are on the track of the
//! potentiometer, and where the estimator expects them.

use super::debounce::Debounce;
use super::violation::Violation;
use crate::link::limits::{Limits, hard};
use crate::link::mode::Fault;

/// Samples in a row in the gap. One may be damage that its checksum did not detect:
/// one in 256 does not.
const GAP_SAMPLES: u32 = 2;

/// Samples in a row far from where they were expected: one or two may be such
/// damage or a knock against the arm.
const OFF_SAMPLES: u32 = 3;

/// What it has counted. Ticks without a sample do not come here, and break no row.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Innovation {
    in_gap: Debounce,
    off: Debounce,
}

impl Innovation {
    /// Whether the encoder is on its track.
    pub(super) fn place(
        &mut self,
        limits: &Limits,
        joint: u8,
        counts: u16,
    ) -> Result<(), Violation> {
        let low = limits.dead_zone_counts;
        let high = hard::COUNTS.saturating_sub(limits.dead_zone_counts);
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

    /// How far a sample is from where it was expected.
    pub(super) fn judge(
        &mut self,
        limits: &Limits,
        joint: u8,
        off_rad: f32,
    ) -> Result<(), Violation> {
        let off_rad = off_rad.abs();
        // So that what is not a number is off too.
        let is_near = off_rad <= limits.innovation_rad;
        if self.off.note(!is_near, OFF_SAMPLES) {
            return Err(Violation {
                fault: Fault::Diverged,
                joint: Some(joint),
                value: off_rad,
                limit: limits.innovation_rad,
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
            let (limits, mut samples) = (Limits::default(), Innovation::default());
            for counts in [at_end, inside, at_end, inside, inside, at_end] {
                assert_eq!(samples.place(&limits, 0, counts), Ok(()));
            }
            let violation = samples.place(&limits, 0, at_end).unwrap_err();
            assert_eq!(violation.fault, Fault::DeadZone);
            assert!((violation.value - f32::from(at_end)).abs() < 0.5);
        }
    }

    #[test]
    fn three_samples_in_a_row_beside_the_estimate_are_no_accident() {
        for off in [0.1001, -0.1001, f32::NAN] {
            let (limits, mut samples) = (Limits::default(), Innovation::default());
            for off in [off, off, 0.0999, off, off] {
                assert_eq!(samples.judge(&limits, 1, off), Ok(()));
            }
            let violation = samples.judge(&limits, 1, off).unwrap_err();
            assert_eq!(violation.fault, Fault::Diverged);
            assert_eq!(violation.joint, Some(1));
        }
    }
}
