//! Torque limiter: torque within all limits, and the duration of limiting.
//!
//! Limits are applied in this order: torque, bounds of the soft stop, rate. The
//! bounds take precedence over the rate, so that braking is not delayed, and the torque
//! limit over both.

use super::debounce::{Debounce, ticks};
use super::soft_stop::Bounds;
use armbridge_control::check_word::checked;
use armbridge_link::fault::Fault;
use armbridge_link::limits::Limits;
use armbridge_link::mode::Guards;
use armbridge_link::record::Violation;
use armbridge_servo::JOINTS;
use nalgebra::Vector2;

/// Longest time in µs for which the demand may exceed the torque or PWM limit, or a joint
/// be braked, without a break. A motion needs full torque for less:
/// at 20 rad/s^2 an AX-12A is at its top speed after 310 ms.
const BEYOND_US: u32 = 500_000;

/// Longest time in µs for which the rate may be limited in every tick: at a fortieth of the
/// default rate still enough to reverse any torque. A controller that demands more for
/// longer oscillates.
const RATE_US: u32 = 100_000;

/// Least number of ticks for each of these, at any period: a step of the setpoint
/// takes one or two.
const TICKS: u32 = 5;

/// A torque within all limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::tick) struct LimitedTorque {
    /// Torque in N m.
    pub(in crate::tick) torque_nm: Vector2<f32>,
    /// Limits that changed the demand.
    pub(in crate::tick) guards: Guards,
}

/// Parameters of the torque limiter, for one set of limits and one period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TorqueConfig {
    /// Largest change within a tick, in N m.
    step_nm: f32,
    beyond_ticks: u32,
    rate_ticks: u32,
}

checked!(TorqueConfig {
    step_nm,
    beyond_ticks,
    rate_ticks,
});

/// Counters of consecutive limited ticks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct TorqueLimiter {
    joints: [Counters; JOINTS],
    pwm: Debounce,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
struct Counters {
    limited: Debounce,
    braked: Debounce,
    rate_limited: Debounce,
}

impl TorqueConfig {
    pub(super) fn new(limits: &Limits, period_us: u32) -> Self {
        Self {
            step_nm: limits.torque_rate_nm_s * (period_us as f32 * 1e-6),
            beyond_ticks: ticks(BEYOND_US, period_us, TICKS),
            rate_ticks: ticks(RATE_US, period_us, TICKS),
        }
    }

    /// Whether no limit is exceeded, as in nearly every tick.
    fn is_within(
        &self,
        limits: &Limits,
        wanted_nm: [f32; JOINTS],
        before_nm: [f32; JOINTS],
    ) -> bool {
        let steps = wanted_nm.iter().zip(before_nm);
        steps
            .zip(limits.torque_nm)
            .all(|((wanted, before), limit)| {
                wanted.abs() <= limit && (wanted - before).abs() <= self.step_nm
            })
    }
}

impl TorqueLimiter {
    /// Limits finite torques in N m.
    pub(super) fn limit(
        &mut self,
        config: &TorqueConfig,
        limits: &Limits,
        wanted_nm: [f32; JOINTS],
        before_nm: [f32; JOINTS],
        bounds: Option<[Bounds; JOINTS]>,
    ) -> Result<LimitedTorque, Violation> {
        if bounds.is_none() && config.is_within(limits, wanted_nm, before_nm) {
            self.joints = Default::default();
            return Ok(LimitedTorque {
                torque_nm: wanted_nm.into(),
                guards: Guards::NONE,
            });
        }
        let mut torque_nm = Vector2::zeros();
        let mut guards = Guards::NONE;
        let joints = self.joints.iter_mut().zip(torque_nm.iter_mut());
        let demands = wanted_nm.into_iter().zip(before_nm);
        let bounds = bounds.unwrap_or([Bounds::FREE; JOINTS]);
        let allowed = limits.torque_nm.into_iter().zip(bounds);
        for (((joint, (counters, torque)), (wanted, before)), (limit, bounds)) in
            (0..).zip(joints).zip(demands).zip(allowed)
        {
            let limited = LimitedJointTorque::new(wanted, before, config.step_nm, limit, bounds);
            *torque = limited.torque_nm;
            guards = guards.or(limited.guards());
            let is_long_braked = counters
                .braked
                .count(limited.is_braked, config.beyond_ticks);
            let is_long_limited = counters
                .limited
                .count(limited.is_limited, config.beyond_ticks);
            let is_long_rate_limited = counters
                .rate_limited
                .count(limited.is_rate_limited, config.rate_ticks);
            let (fault, value, limit) = if is_long_braked {
                (Fault::AngleLimit, bounds.angle_rad, bounds.stop_rad)
            } else if is_long_limited {
                (Fault::TorqueLimit, wanted.abs(), limit)
            } else if is_long_rate_limited {
                let rate_nm_s =
                    (wanted - before).abs() * (limits.torque_rate_nm_s / config.step_nm);
                (Fault::TorqueRate, rate_nm_s, limits.torque_rate_nm_s)
            } else {
                continue;
            };
            return Err(Violation {
                fault,
                joint: Some(joint),
                value,
                limit,
            });
        }
        Ok(LimitedTorque { torque_nm, guards })
    }

    /// Counts a tick in which the demand exceeded the PWM limit.
    pub(super) fn pwm(
        &mut self,
        config: &TorqueConfig,
        limits: &Limits,
        is_limited: bool,
    ) -> Result<(), Violation> {
        if self.pwm.count(is_limited, config.beyond_ticks) {
            let counts = limits.pwm_counts.into();
            return Err(Violation {
                fault: Fault::PwmLimit,
                joint: None,
                value: counts,
                limit: counts,
            });
        }
        Ok(())
    }
}

/// A joint's torque within its limits, and which of them changed it.
struct LimitedJointTorque {
    torque_nm: f32,
    is_limited: bool,
    is_braked: bool,
    is_rate_limited: bool,
}

impl LimitedJointTorque {
    fn new(wanted: f32, before: f32, step: f32, limit: f32, bounds: Bounds) -> Self {
        let in_limit = |torque| within(torque, -limit, limit);
        let in_bounds = |torque| within(torque, bounds.low_nm, bounds.high_nm);
        let limited = in_limit(wanted);
        let braked = in_limit(in_bounds(limited));
        let rated = within(braked, before - step, before + step);
        let inside = in_bounds(rated);
        let torque_nm = in_limit(inside);
        Self {
            torque_nm,
            is_limited: differ(wanted, limited),
            is_braked: differ(limited, braked) || differ(rated, inside),
            is_rate_limited: differ(braked, torque_nm),
        }
    }

    fn guards(&self) -> Guards {
        [
            (self.is_limited, Guards::TORQUE),
            (self.is_braked, Guards::BRAKED),
            (self.is_rate_limited, Guards::RATE),
        ]
        .into_iter()
        .filter(|(is_so, _)| *is_so)
        .fold(Guards::NONE, |all, (_, guard)| all.or(guard))
    }
}

/// Clamps a value; a bound that is NaN is ignored.
fn within(value: f32, low: f32, high: f32) -> f32 {
    value.max(low).min(high)
}

/// Whether two values differ.
#[expect(clippy::float_cmp, reason = "an unchanged value is equal")]
fn differ(a: f32, b: f32) -> bool {
    a != b
}
