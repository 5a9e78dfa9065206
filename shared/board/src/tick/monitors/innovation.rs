//! Innovation monitor: range of one joint's raw samples, on the potentiometer's track and
//! about its middle, and their distance from the estimator's prediction.

use super::debounce::Debounce;
use armbridge_control::encoder::Encoder;
use armbridge_link::fault::Fault;
use armbridge_link::limits::{Limits, hard};
use armbridge_link::record::Violation;

/// Consecutive samples in the gap. One may be damage that its checksum did not detect:
/// one in 256 is not detected.
const GAP_SAMPLES: u32 = 2;

/// Consecutive samples far from the prediction: one or two may be such
/// damage or a knock against the arm.
const FAR_SAMPLES: u32 = 3;

/// Counters of the innovation monitor. Ticks without a sample are skipped, and reset none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Innovation {
    in_gap: Debounce,
    off_middle: Debounce,
    far: Debounce,
}

impl Innovation {
    /// Checks that the encoder is on its track, and not beyond the hard bound of a joint angle
    /// whatever the calibration.
    pub(super) fn check_range(
        &mut self,
        encoder: Encoder,
        limits: &Limits,
        joint: u8,
        counts: u16,
    ) -> Result<(), Violation> {
        let low = u16::from(limits.dead_zone_counts);
        let high = encoder.counts_max().saturating_sub(low);
        let is_in_gap = !(low..=high).contains(&counts);
        if self.in_gap.count(is_in_gap, GAP_SAMPLES) {
            return Err(Violation {
                fault: Fault::DeadZone,
                joint: Some(joint),
                value: counts.into(),
                limit: if counts < low { low } else { high }.into(),
            });
        }
        let off_middle = counts.abs_diff(encoder.middle_count());
        let is_off_middle = off_middle > encoder.counts_from_middle();
        if self.off_middle.count(is_off_middle, GAP_SAMPLES) {
            return Err(Violation {
                fault: Fault::AngleLimit,
                joint: Some(joint),
                value: f32::from(off_middle) * encoder.nominal_rad_per_count() as f32,
                limit: hard::ANGLE_RAD,
            });
        }
        Ok(())
    }

    /// Checks the innovation: the distance of a sample from its prediction.
    pub(super) fn check_innovation(
        &mut self,
        limits: &Limits,
        joint: u8,
        innovation_rad: f32,
    ) -> Result<(), Violation> {
        let innovation_rad = innovation_rad.abs();
        // NaN counts as far.
        let is_near = innovation_rad <= limits.innovation_rad;
        if self.far.count(!is_near, FAR_SAMPLES) {
            return Err(Violation {
                fault: Fault::Diverged,
                joint: Some(joint),
                value: innovation_rad,
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
        for at_end in [7, 1_016, 1_023] {
            let (limits, mut samples) = (Limits::default(), Innovation::default());
            for counts in [at_end, 512, at_end, 512, 512, at_end] {
                assert_eq!(
                    samples.check_range(Encoder::Ax12a, &limits, 0, counts),
                    Ok(())
                );
            }
            let violation = samples
                .check_range(Encoder::Ax12a, &limits, 0, at_end)
                .unwrap_err();
            assert_eq!(violation.fault, Fault::DeadZone);
            assert!((violation.value - f32::from(at_end)).abs() < 0.5);
        }
    }

    #[test]
    fn two_samples_beyond_the_middle_are_beyond_the_angle_limit() {
        for (beyond, inside) in [(217, 218), (807, 806)] {
            let (limits, mut samples) = (Limits::default(), Innovation::default());
            for counts in [beyond, inside, inside, beyond, inside, beyond] {
                assert_eq!(
                    samples.check_range(Encoder::Ax12a, &limits, 0, counts),
                    Ok(())
                );
            }
            let violation = samples
                .check_range(Encoder::Ax12a, &limits, 0, beyond)
                .unwrap_err();
            assert_eq!(violation.fault, Fault::AngleLimit);
            assert!((1.505..1.51).contains(&violation.value), "{violation:?}");
        }
    }

    #[test]
    fn three_samples_in_a_row_beside_the_estimate_are_no_accident() {
        for off in [0.1001, -0.1001, f32::NAN] {
            let (limits, mut samples) = (Limits::default(), Innovation::default());
            for off in [off, off, 0.0999, off, off] {
                assert_eq!(samples.check_innovation(&limits, 1, off), Ok(()));
            }
            let violation = samples.check_innovation(&limits, 1, off).unwrap_err();
            assert_eq!(violation.fault, Fault::Diverged);
            assert_eq!(violation.joint, Some(1));
        }
    }
}
