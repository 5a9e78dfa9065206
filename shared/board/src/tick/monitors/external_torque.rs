//! External torque: what acts on a joint beside motor, gravity and viscous friction.
//!
//! While a controller holds the arm, an encoder that drifts moves the arm, and the
//! samples alone do not show it: the controller keeps them at the reference. But the motor
//! then carries another weight than the posture that the samples show. The same torque
//! shows an encoder with an offset, a motor of another strength than calibrated, another
//! load, and a hand that pushes.
//!
//! The torque is found by a momentum observer, one filter a joint (De Luca's residual; the
//! mass matrix is diagonal, and Coriolis torque is left out):
//!
//! ```text
//! r' = (M ddq + F dq + G(q) - torque - r) / T
//! ```
//!
//! A limit exceeded without a break for [`LASTS_US`] is a fault. Dry friction is in `r`, so a
//! limit is well above it, and below the weight that is to be told: on the paper's arm an error
//! of 0.4 rad of joint 1 makes 0.22 N m, and one of 1 rad of joint 2 makes 0.15. While the arm sinks
//! under a drift, friction takes 0.06 N m of that.

use super::debounce::{Debounce, ticks};
use armbridge_control::check_word::checked;
use armbridge_link::fault::Fault;
use armbridge_link::record::Violation;

/// Time constant T of the observer in µs: ten times as slow as the loop.
const FILTER_US: f32 = 500_000.0;

/// Time in µs, and ticks, for which the limit must be exceeded: longer than a push.
const LASTS_US: u32 = 1_000_000;
const LASTS_TICKS: u32 = 5;

/// Parameters of the observer for one period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ExternalTorqueConfig {
    /// Share of a tick in the residual.
    share: f32,
    per_period_s: f32,
    exceeded_ticks: u32,
}

checked!(ExternalTorqueConfig {
    share,
    per_period_s,
    exceeded_ticks,
});

/// Balance of one joint at its samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::tick) struct JointBalance {
    /// Inertia in kg m^2.
    pub(in crate::tick) inertia: f32,
    /// Torque in N m that the motion at this speed and the posture take: viscous friction and
    /// gravity, less that of the motor.
    pub(in crate::tick) unmet_nm: f32,
}

/// The observer of one joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct ExternalTorque {
    speed_rad_s: Option<f32>,
    residual_nm: f32,
    exceeded: Debounce,
}

impl ExternalTorqueConfig {
    pub(super) fn new(period_us: u32) -> Self {
        let period = period_us as f32;
        Self {
            share: period / (period + FILTER_US),
            per_period_s: 1e6 / period,
            exceeded_ticks: ticks(LASTS_US, period_us, LASTS_TICKS),
        }
    }
}

impl ExternalTorque {
    /// Checks a tick in which a controller holds the joint.
    pub(super) fn check(
        &mut self,
        config: &ExternalTorqueConfig,
        limit_nm: f32,
        joint: u8,
        balance: JointBalance,
        speed_rad_s: f32,
    ) -> Result<(), Violation> {
        let before_rad_s = self.speed_rad_s.replace(speed_rad_s).unwrap_or(speed_rad_s);
        let acceleration = (speed_rad_s - before_rad_s) * config.per_period_s;
        let external_nm = balance.inertia * acceleration + balance.unmet_nm;
        self.residual_nm += config.share * (external_nm - self.residual_nm);
        let is_above = self.residual_nm.abs() > limit_nm;
        if self.exceeded.count(is_above, config.exceeded_ticks) {
            return Err(Violation {
                fault: Fault::ExternalTorque,
                joint: Some(joint),
                value: self.residual_nm.abs(),
                limit: limit_nm,
            });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tick of the violation, of up to 10 s, of a joint of 0.03 kg m^2 at this speed, with this
    /// torque unmet, in N m.
    fn until(period_us: u32, at: impl Fn(f32) -> (f32, f32)) -> Option<f32> {
        let config = ExternalTorqueConfig::new(period_us);
        let mut observer = ExternalTorque::default();
        let ticks = 1..10_000_000 / period_us;
        ticks
            .map(|tick| tick as f32 * period_us as f32 * 1e-6)
            .find(|t| {
                let (speed, unmet_nm) = at(*t);
                let balance = JointBalance {
                    inertia: 0.03,
                    unmet_nm,
                };
                observer.check(&config, 0.3, 0, balance, speed).is_err()
            })
    }

    #[test]
    fn a_weight_that_is_not_in_the_model_is_told() {
        for period_us in [600, 1_000, 45_000] {
            // 1 s after 63 % of 0.475 N m is 0.3.
            let told_s = until(period_us, |_| (0.0, -0.475)).unwrap();
            assert!((1.4..1.65).contains(&told_s), "{told_s}");
        }
        // A drift of 20 counts a second, held by the motor.
        let drift = |t: f32| (0.0, -0.57 * (0.102 * t).sin());
        let told_s = until(1_000, drift).unwrap();
        assert!((6.5..7.5).contains(&told_s), "{told_s}");
    }

    #[test]
    fn friction_pushes_and_motion_are_not() {
        assert_eq!(until(1_000, |_| (0.0, 0.29)), None);
        // A push of 1 N m for 0.3 s, against which the controller holds.
        let push = |t: f32| (0.0, if (2.0..2.3).contains(&t) { 1.0 } else { 0.06 });
        assert_eq!(until(1_000, push), None);
        // Accelerated by the torque: 0.03 kg m^2 at 1 rad/s and 1 Hz, balanced.
        let (w, inertia) = (core::f32::consts::TAU, 0.03);
        let wave = |t: f32| ((w * t).sin(), -inertia * w * (w * t).cos());
        assert_eq!(until(1_000, wave), None);
    }
}
