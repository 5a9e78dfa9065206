//! One joint that floats: its parameters, its memory, and its torque in a tick.

use super::constants::{
    ANGLE_S, BRAKE_NM, BRAKE_NM_S, BRAKE_RAD_S, CATCH_NM_S, CORRECTION_SHARE, END_PER_S, END_RAD,
    FADE_RAD, FIRM_SHARE, FRICTION_RATIO, FRICTION_SHARE, HELD_RATIO, LIGHT_DRY_SHARE, LIGHT_SHARE,
    MOTOR_RATIO, REACH_RAD, REST_RAD_S, REST_S, SCALE_AT_SHARE, SLIDE_RAD_S, SOFTEN_RAD, SPEED_S,
    STRENGTH_S, TRANSFER_PER_S, VISCOUS_MIN_NM_S, VISCOUS_RAD_S, WEIGH_S, WEIGHT_MIN_NM,
};
use crate::real::Real;

/// Parameters of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FloatJoint<T> {
    /// Largest gravity torque in N m.
    weight_nm: T,
    /// Strength of the light friction in N m.
    light_nm: T,
    /// Dry friction that is compensated, in N m, and viscous friction, in N m s/rad.
    dry_nm: T,
    viscous_nm_s: T,
    /// Speed in rad/s beyond which no more viscous friction is compensated.
    viscous_rad_s: T,
}

/// Times and rates for one period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Timing<T> {
    period_s: T,
    /// Share of a tick in the smoothed angle, in the smoothed speed and in the strength.
    angle_share: T,
    speed_share: T,
    strength_share: T,
    rest_ticks: u32,
    weighed_ticks: u32,
}

/// Memory of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct JointState<T> {
    /// Smoothed angle in rad.
    angle_rad: T,
    /// Angle in rad to which the spring of the friction pulls.
    anchor_rad: T,
    /// The angle without reversals of less than twice [`REACH_RAD`]: no noise is motion.
    play_rad: T,
    /// Strength of the friction in N m.
    strength_nm: T,
    /// Scale of the gravity torque beyond the model's, and trim in N m.
    pub(super) scale: T,
    trim_nm: T,
    /// Smoothed speed of that angle in rad/s.
    speed_rad_s: T,
    /// Ticks since that has been slow.
    slow_ticks: u32,
    /// Whether its load has been taken over since it moved, and whether it has ever been.
    pub(super) is_weighed: bool,
    was_weighed: bool,
}

impl<T: Real> Timing<T> {
    /// For this period in s.
    pub(super) fn new(period_s: T) -> Self {
        let ticks = |seconds: f64| -> u32 {
            let ticks = T::lit(seconds) / period_s;
            u32::from(ticks.to_count()).max(1)
        };
        let share = |seconds: f64| period_s / (period_s + T::lit(seconds));
        Self {
            period_s,
            angle_share: share(ANGLE_S),
            speed_share: share(SPEED_S),
            strength_share: share(STRENGTH_S),
            rest_ticks: ticks(REST_S),
            weighed_ticks: ticks(REST_S + WEIGH_S),
        }
    }
}

impl<T: Real> FloatJoint<T> {
    /// With this weight and dry friction in N m, and viscous friction in N m s/rad.
    pub(super) fn new(weight_nm: T, dry_nm: T, viscous_nm_s: T) -> Self {
        let share = T::lit(FRICTION_SHARE);
        let weight_nm = weight_nm.max(T::lit(WEIGHT_MIN_NM));
        let light_nm = (weight_nm * T::lit(LIGHT_SHARE)).max(dry_nm * T::lit(LIGHT_DRY_SHARE));
        // The compensation exceeds the true friction by the light friction there.
        let allowed_nm = light_nm / T::lit(FRICTION_SHARE * MOTOR_RATIO - FRICTION_RATIO);
        let viscous_rad_s = (allowed_nm - dry_nm) / viscous_nm_s.max(T::lit(VISCOUS_MIN_NM_S));
        Self {
            weight_nm,
            light_nm,
            dry_nm: dry_nm * share,
            viscous_nm_s: viscous_nm_s * share,
            viscous_rad_s: viscous_rad_s.clamp(T::zero(), T::lit(VISCOUS_RAD_S)),
        }
    }

    /// Memory of a joint that rests at this angle, held by `beyond_nm` more than gravity.
    pub(super) fn begin(&self, timing: &Timing<T>, angle_rad: T, beyond_nm: T) -> JointState<T> {
        let most_nm = self.correction_max_nm();
        JointState {
            angle_rad,
            anchor_rad: angle_rad,
            play_rad: angle_rad,
            strength_nm: self.firm_nm(),
            scale: T::zero(),
            trim_nm: beyond_nm.clamp(-most_nm, most_nm),
            speed_rad_s: T::zero(),
            slow_ticks: timing.rest_ticks,
            is_weighed: false,
            was_weighed: false,
        }
    }

    fn firm_nm(&self) -> T {
        self.weight_nm * T::lit(FIRM_SHARE)
    }

    fn correction_max_nm(&self) -> T {
        self.weight_nm * T::lit(CORRECTION_SHARE)
    }

    /// The torque in N m at this angle, where gravity takes `gravity_nm` by the model.
    pub(super) fn torque(
        &self,
        timing: &Timing<T>,
        memory: &mut JointState<T>,
        gravity_nm: T,
        angle_rad: T,
    ) -> T {
        memory.angle_rad += (angle_rad - memory.angle_rad) * timing.angle_share;
        let angle_rad = memory.angle_rad;
        let stiffness = self.light_nm / T::lit(REACH_RAD);
        let stretch_nm = stiffness * (memory.anchor_rad - angle_rad);
        let [least_nm, most_nm] = self.strengths(memory);
        let mut load_nm = stretch_nm.clamp(least_nm, most_nm);
        memory.note_motion(timing);
        self.strengthen(timing, memory);
        load_nm -= self.weigh(timing, memory, gravity_nm, load_nm);
        memory.anchor_rad = angle_rad + load_nm / stiffness;
        let correction_nm = gravity_nm * memory.scale + memory.trim_nm;
        let speed_rad_s = memory.speed_rad_s;
        gravity_nm + correction_nm + load_nm + self.friction(speed_rad_s)
            - brake(angle_rad, speed_rad_s)
    }

    /// Least and most load of the friction in N m.
    fn strengths(&self, memory: &JointState<T>) -> [T; 2] {
        let (end, firm_nm) = (T::lit(END_RAD), self.firm_nm().max(memory.strength_nm));
        let strength_nm = |is_beyond: bool| {
            if is_beyond {
                firm_nm
            } else {
                memory.strength_nm
            }
        };
        [
            -strength_nm(memory.angle_rad > end),
            strength_nm(memory.angle_rad < -end),
        ]
    }

    /// Compensation of the model's friction in N m at this speed.
    fn friction(&self, speed_rad_s: T) -> T {
        let one = T::one();
        let sliding = (speed_rad_s / T::lit(SLIDE_RAD_S)).clamp(-one, one);
        let viscous_rad_s = speed_rad_s.clamp(-self.viscous_rad_s, self.viscous_rad_s);
        self.dry_nm * sliding + self.viscous_nm_s * viscous_rad_s
    }

    /// Firm at rest until the load has been taken over, light in motion.
    fn strengthen(&self, timing: &Timing<T>, memory: &mut JointState<T>) {
        let is_resting = memory.is_resting(timing);
        let goal_nm = match (is_resting, memory.is_weighed) {
            (true, true) => self.light_nm * T::lit(HELD_RATIO),
            (false, _) if memory.was_weighed => self.light_nm,
            // An error of its weight sets off a joint that has never been weighed.
            (true, false) | (false, _) => self.firm_nm(),
        };
        let share = if is_resting {
            timing.strength_share
        } else {
            let way_rad = memory.speed_rad_s.abs() * timing.period_s;
            (way_rad / T::lit(SOFTEN_RAD)).min(T::one())
        };
        memory.strength_nm += (goal_nm - memory.strength_nm) * share;
    }

    /// Takes over a part of the friction's load, which it returns, in N m.
    fn weigh(
        &self,
        timing: &Timing<T>,
        memory: &mut JointState<T>,
        gravity_nm: T,
        load_nm: T,
    ) -> T {
        let is_resting = memory.is_resting(timing);
        let is_light = load_nm.abs() < self.light_nm / T::lit(2.0);
        memory.is_weighed |= is_light && memory.slow_ticks >= timing.weighed_ticks;
        memory.was_weighed |= memory.is_weighed;
        let nm_s = if is_resting && !memory.is_weighed {
            load_nm * T::lit(TRANSFER_PER_S)
        } else {
            load_nm / memory.strength_nm * T::lit(CATCH_NM_S)
        };
        let taken_nm = nm_s * timing.period_s;
        let correction_nm = gravity_nm * memory.scale + memory.trim_nm;
        if (correction_nm + taken_nm).abs() > self.correction_max_nm() {
            return T::zero();
        }
        let half_nm = self.weight_nm * T::lit(SCALE_AT_SHARE);
        let gain = if is_resting {
            gravity_nm / (gravity_nm * gravity_nm + half_nm * half_nm)
        } else {
            T::zero()
        };
        memory.scale += gain * taken_nm;
        memory.trim_nm += taken_nm - gravity_nm * gain * taken_nm;
        taken_nm
    }
}

impl<T: Real> JointState<T> {
    fn is_resting(&self, timing: &Timing<T>) -> bool {
        self.slow_ticks >= timing.rest_ticks
    }

    /// Takes the angle of this tick.
    fn note_motion(&mut self, timing: &Timing<T>) {
        let (before_rad, reach) = (self.play_rad, T::lit(REACH_RAD));
        self.play_rad = before_rad.clamp(self.angle_rad - reach, self.angle_rad + reach);
        let way_rad = self.play_rad - before_rad;
        self.speed_rad_s += (way_rad / timing.period_s - self.speed_rad_s) * timing.speed_share;
        self.slow_ticks = if self.speed_rad_s.abs() < T::lit(REST_RAD_S) {
            self.slow_ticks.saturating_add(1)
        } else {
            self.is_weighed = false;
            0
        };
        let drives = self.trim_nm * way_rad > T::zero();
        if drives && !self.is_resting(timing) {
            self.trim_nm -= self.trim_nm * (way_rad.abs() / T::lit(FADE_RAD)).min(T::one());
        }
    }
}

/// Torque in N m that brakes a joint: beyond [`BRAKE_RAD_S`], and on its way to [`END_RAD`].
fn brake<T: Real>(angle_rad: T, speed_rad_s: T) -> T {
    let (fastest, end, near) = (T::lit(BRAKE_RAD_S), T::lit(END_RAD), T::lit(END_PER_S));
    let free = |room_rad: T| (near * room_rad).clamp(T::zero(), fastest);
    let excess = speed_rad_s - speed_rad_s.clamp(-free(end + angle_rad), free(end - angle_rad));
    (excess * T::lit(BRAKE_NM_S)).clamp(-T::lit(BRAKE_NM), T::lit(BRAKE_NM))
}
