//! Motion monitor: angle and speed of one joint.

use super::debounce::{Debounce, ticks};
use armbridge_link::fault::Fault;
use armbridge_link::record::Violation;

/// Time in µs, and ticks, for which a joint must be too fast: the speed is an estimate,
/// and noise disappears with the next samples.
const FAST_US: u32 = 10_000;
const FAST_TICKS: u32 = 2;

/// Number of consecutive ticks in which a joint must be too fast.
pub(super) fn fast_ticks(period_us: u32) -> u32 {
    ticks(FAST_US, period_us, FAST_TICKS)
}

/// Counters of the motion monitor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Motion {
    fast: Debounce,
}

/// Limits of one joint.
#[derive(Clone, Copy, Debug)]
pub(super) struct MotionLimits {
    pub(super) angle_rad: f32,
    pub(super) speed_rad_s: f32,
    pub(super) fast_ticks: u32,
}

impl Motion {
    /// Checks an angle and a speed, both finite.
    pub(super) fn check(
        &mut self,
        limits: &MotionLimits,
        joint: u8,
        q: f32,
        dq: f32,
    ) -> Result<(), Violation> {
        let (angle, speed) = (q.abs(), dq.abs());
        let is_long_fast = self
            .fast
            .count(speed > limits.speed_rad_s, limits.fast_ticks);
        let (fault, value, limit) = if angle > limits.angle_rad {
            (Fault::AngleLimit, angle, limits.angle_rad)
        } else if is_long_fast {
            (Fault::SpeedLimit, speed, limits.speed_rad_s)
        } else {
            return Ok(());
        };
        Err(Violation {
            fault,
            joint: Some(joint),
            value,
            limit,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limits(period_us: u32) -> MotionLimits {
        MotionLimits {
            angle_rad: 1.5,
            speed_rad_s: 10.0,
            fast_ticks: fast_ticks(period_us),
        }
    }

    #[test]
    fn an_angle_beyond_trips_at_once() {
        for q in [1.5001_f32, -1.5001] {
            let (limits, mut motion) = (limits(1_000), Motion::default());
            assert_eq!(motion.check(&limits, 0, q * 0.9999, 0.0), Ok(()));
            let violation = motion.check(&limits, 0, q, 0.0).unwrap_err();
            assert_eq!(violation.fault, Fault::AngleLimit);
            assert!(violation.value > violation.limit);
        }
    }

    #[test]
    fn a_speed_beyond_trips_after_10_ms_and_two_ticks() {
        for (period_us, taken) in [(600, 17), (1_000, 10), (45_000, 2), (100_000, 2)] {
            let (limits, mut motion) = (limits(period_us), Motion::default());
            // Never in a row.
            for tick in 0..50 {
                let dq = if tick % taken == 0 { 9.999 } else { -10.001 };
                assert_eq!(
                    motion.check(&limits, 0, 0.0, dq),
                    Ok(()),
                    "{period_us} {tick}"
                );
            }
            motion = Motion::default();
            for _ in 1..taken {
                assert_eq!(motion.check(&limits, 0, 0.0, -10.001), Ok(()));
            }
            let violation = motion.check(&limits, 0, 0.0, 10.001).unwrap_err();
            assert_eq!(violation.fault, Fault::SpeedLimit);
        }
    }
}
