//! Torque within all limits, and how long it had to be put there.
//!
//! Limits are applied in this order: torque, bounds of the soft stop, rate. The
//! rate gives way where it would leave the bounds: a brake does not wait for it.
//! Nothing gives way to the first.

use super::soft_stop::Bounds;
use super::ticks::{InRow, ticks};
use super::{Shaped, Violation};
use crate::JOINTS;
use crate::link::limits::Limits;
use crate::link::mode::{Fault, Guards};
use nalgebra::Vector2;

/// How long torque or PWM may be wanted beyond its limit, or a joint be braked,
/// without a break, in µs: longer than a step from the edge of the arm's range to
/// the other asks for, and no more than a hand needs to be caught.
const BEYOND_US: u32 = 500_000;

/// How long the rate may be limited in every tick, in µs: long enough to turn any
/// torque round at a hundredth of the default rate. A law that goes on wanting
/// more is a rattle.
const RATE_US: u32 = 100_000;

/// Ticks that any of these needs, however slow they are: a step of the setpoint
/// takes one or two.
const TICKS: u32 = 5;

/// The monitor.
#[derive(Clone, Debug)]
pub(super) struct Torque {
    limit_nm: [f32; JOINTS],
    /// Largest change within a tick, in N m.
    step_nm: f32,
    rate_nm_s: f32,
    pwm_counts: u16,
    beyond_ticks: u32,
    rate_ticks: u32,
    joints: [Counters; JOINTS],
    pwm: InRow,
}

#[derive(Clone, Copy, Debug, Default)]
struct Counters {
    limited: InRow,
    braked: InRow,
    rated: InRow,
}

impl Torque {
    pub(super) fn new(limits: &Limits, period_us: u32) -> Self {
        Self {
            limit_nm: limits.torque_nm,
            step_nm: limits.torque_rate_nm_s * (period_us as f32 * 1e-6),
            rate_nm_s: limits.torque_rate_nm_s,
            pwm_counts: limits.pwm_counts,
            beyond_ticks: ticks(BEYOND_US, period_us, TICKS),
            rate_ticks: ticks(RATE_US, period_us, TICKS),
            joints: Default::default(),
            pwm: InRow::default(),
        }
    }

    pub(super) fn restart(&mut self) {
        self.joints = Default::default();
        self.pwm = InRow::default();
    }

    /// For finite torques in N m.
    pub(super) fn shape(
        &mut self,
        wanted_nm: [f32; JOINTS],
        before_nm: [f32; JOINTS],
        bounds: Option<[Bounds; JOINTS]>,
    ) -> Result<Shaped, Violation> {
        if bounds.is_none() && self.is_within(wanted_nm, before_nm) {
            self.joints = Default::default();
            return Ok(Shaped {
                torque_nm: wanted_nm.into(),
                guards: Guards::NONE,
            });
        }
        let mut torque_nm = Vector2::zeros();
        let mut guards = Guards::NONE;
        let (step, beyond_ticks, rate_ticks) = (self.step_nm, self.beyond_ticks, self.rate_ticks);
        let asked = wanted_nm.into_iter().zip(before_nm);
        let limits = self
            .limit_nm
            .into_iter()
            .zip(bounds.unwrap_or([Bounds::FREE; JOINTS]));
        for ((((joint, shaped), counters), (wanted, before)), (limit, bounds)) in (0..)
            .zip(torque_nm.iter_mut())
            .zip(&mut self.joints)
            .zip(asked)
            .zip(limits)
        {
            let limited = within(wanted, -limit, limit);
            let braked = within(
                within(limited, bounds.low_nm, bounds.high_nm),
                -limit,
                limit,
            );
            let rated = within(braked, before - step, before + step);
            let inside = within(rated, bounds.low_nm, bounds.high_nm);
            *shaped = within(inside, -limit, limit);

            let is_limited = wanted.abs() > limit;
            let is_braked = differ(limited, braked) || differ(rated, inside);
            let is_rated = differ(braked, *shaped);
            for (is_so, guard) in [
                (is_limited, Guards::TORQUE),
                (is_braked, Guards::BRAKED),
                (is_rated, Guards::RATE),
            ] {
                if is_so {
                    guards = guards.or(guard);
                }
            }
            let is_long_limited = counters.limited.note(is_limited, beyond_ticks);
            let is_long_braked = counters.braked.note(is_braked, beyond_ticks);
            let is_long_rated = counters.rated.note(is_rated, rate_ticks);
            let (fault, value, limit) = if is_long_braked {
                (Fault::AngleLimit, bounds.angle_rad, bounds.stop_rad)
            } else if is_long_limited {
                (Fault::TorqueLimit, wanted.abs(), limit)
            } else if is_long_rated {
                let rate = (braked - before).abs() * (self.rate_nm_s / step);
                (Fault::TorqueRate, rate, self.rate_nm_s)
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
        Ok(Shaped { torque_nm, guards })
    }

    /// Whether nothing is to be changed, as is so in nearly every tick.
    fn is_within(&self, wanted_nm: [f32; JOINTS], before_nm: [f32; JOINTS]) -> bool {
        let steps = wanted_nm.iter().zip(before_nm);
        steps.zip(self.limit_nm).all(|((wanted, before), limit)| {
            wanted.abs() <= limit && (wanted - before).abs() <= self.step_nm
        })
    }

    /// Whether more PWM than its limit was wanted in this tick.
    pub(super) fn pwm(&mut self, is_limited: bool) -> Result<(), Violation> {
        if self.pwm.note(is_limited, self.beyond_ticks) {
            let counts = self.pwm_counts.into();
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

/// The nearest value that is neither below nor above; a bound that is not a number
/// is none.
fn within(value: f32, low: f32, high: f32) -> f32 {
    value.max(low).min(high)
}

/// Whether one was changed to the other.
#[expect(clippy::float_cmp, reason = "what is not changed is the same")]
fn differ(a: f32, b: f32) -> bool {
    a != b
}
