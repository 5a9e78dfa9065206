//! Where one joint is, and how fast.

use super::Violation;
use super::ticks::{InRow, ticks};
use crate::link::mode::Fault;

/// How long a joint must be too fast, in µs and in ticks: a speed is estimated,
/// and one that is no more than noise is gone with the next samples.
const FAST_US: u32 = 10_000;
const FAST_TICKS: u32 = 2;

/// The monitor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Motion {
    angle_rad: f32,
    speed_rad_s: f32,
    fast_ticks: u32,
    fast: InRow,
}

impl Motion {
    pub(super) fn new(angle_rad: f32, speed_rad_s: f32, period_us: u32) -> Self {
        Self {
            angle_rad,
            speed_rad_s,
            fast_ticks: ticks(FAST_US, period_us, FAST_TICKS),
            fast: InRow::default(),
        }
    }

    /// How many ticks in a row a joint must be too fast.
    pub(super) fn fast_ticks(&self) -> u32 {
        self.fast_ticks
    }

    pub(super) fn restart(&mut self) {
        self.fast = InRow::default();
    }

    /// For an angle and a speed, both finite.
    pub(super) fn judge(&mut self, joint: u8, q: f32, dq: f32) -> Result<(), Violation> {
        let (angle, speed) = (q.abs(), dq.abs());
        let is_long_fast = self.fast.note(speed > self.speed_rad_s, self.fast_ticks);
        let (fault, value, limit) = if angle > self.angle_rad {
            (Fault::AngleLimit, angle, self.angle_rad)
        } else if is_long_fast {
            (Fault::SpeedLimit, speed, self.speed_rad_s)
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

    #[test]
    fn an_angle_beyond_trips_at_once() {
        for q in [1.5001_f32, -1.5001] {
            let mut motion = Motion::new(1.5, 10.0, 1_000);
            assert_eq!(motion.judge(0, q * 0.9999, 0.0), Ok(()));
            let violation = motion.judge(0, q, 0.0).unwrap_err();
            assert_eq!(violation.fault, Fault::AngleLimit);
            assert!(violation.value > violation.limit);
        }
    }

    #[test]
    fn a_speed_beyond_trips_after_10_ms_and_two_ticks() {
        for (period_us, taken) in [(600, 17), (1_000, 10), (45_000, 2), (100_000, 2)] {
            let mut motion = Motion::new(1.5, 10.0, period_us);
            // Never in a row.
            for tick in 0..50 {
                let dq = if tick % taken == 0 { 9.999 } else { -10.001 };
                assert_eq!(motion.judge(0, 0.0, dq), Ok(()), "{period_us} {tick}");
            }
            motion.restart();
            for _ in 1..taken {
                assert_eq!(motion.judge(0, 0.0, -10.001), Ok(()));
            }
            let violation = motion.judge(0, 0.0, 10.001).unwrap_err();
            assert_eq!(violation.fault, Fault::SpeedLimit);
        }
    }
}
