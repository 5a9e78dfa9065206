//! Memory of a joint that floats, and its changes: slip, strength and weighing.

use super::Float;
use super::constants::{
    CATCH_NM_S, CORRECTION_SHARE, FADE_RAD, FIRM_SHARE, HELD_RATIO, REST_RAD_S, SCALE_AT_SHARE,
    SOFTEN_RAD, TRANSFER_PER_S,
};
use crate::real::Real;

#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct JointState<T> {
    /// Smoothed angle in rad.
    pub(super) angle_rad: T,
    /// Angle in rad to which the spring of the friction pulls.
    pub(super) anchor_rad: T,
    /// Strength of the friction in N m.
    pub(super) strength_nm: T,
    /// Scale of the gravity torque beyond the model's, and trim in N m.
    pub(super) scale: T,
    pub(super) trim_nm: T,
    /// Smoothed speed of the anchor's slip in rad/s.
    pub(super) speed_rad_s: T,
    /// Ticks since that has been slow.
    pub(super) slow_ticks: u32,
    /// Whether its load has been taken over since it moved.
    pub(super) is_weighed: bool,
}

impl<T: Real> JointState<T> {
    pub(super) fn is_resting(&self, float: &Float<T>) -> bool {
        self.slow_ticks >= float.rest_ticks
    }

    /// Takes the slip of this tick, in rad.
    pub(super) fn note_slip(&mut self, float: &Float<T>, slip_rad: T) {
        self.speed_rad_s += (slip_rad / float.period_s - self.speed_rad_s) * float.speed_share;
        self.slow_ticks = if self.speed_rad_s.abs() < T::lit(REST_RAD_S) {
            self.slow_ticks.saturating_add(1)
        } else {
            self.is_weighed = false;
            0
        };
        let drives = self.trim_nm * slip_rad > T::zero();
        if drives && !self.is_resting(float) {
            self.trim_nm -= self.trim_nm * (slip_rad.abs() / T::lit(FADE_RAD)).min(T::one());
        }
    }

    /// Firm at rest until the load has been taken over, light otherwise.
    pub(super) fn strengthen(&mut self, float: &Float<T>, weight_nm: T, light_nm: T) {
        let is_resting = self.is_resting(float);
        let goal_nm = match (is_resting, self.is_weighed) {
            (true, false) => weight_nm * T::lit(FIRM_SHARE),
            (true, true) => light_nm * T::lit(HELD_RATIO),
            (false, _) => light_nm,
        };
        let speed = if is_resting {
            float.strengthening
        } else {
            let way_rad = self.speed_rad_s.abs() * float.period_s;
            (way_rad / T::lit(SOFTEN_RAD)).min(T::one())
        };
        self.strength_nm += (goal_nm - self.strength_nm) * speed;
    }

    /// Takes over a part of the friction's load, which it returns, in N m.
    pub(super) fn weigh(&mut self, float: &Float<T>, joint: usize, gravity_nm: T, load_nm: T) -> T {
        let weight_nm = float.weight_nm[joint];
        let is_resting = self.is_resting(float);
        let is_light = load_nm.abs() < float.light_nm[joint] / T::lit(2.0);
        self.is_weighed |= is_light && self.slow_ticks >= float.weighed_ticks;
        let nm_s = if is_resting && !self.is_weighed {
            load_nm * T::lit(TRANSFER_PER_S)
        } else {
            load_nm / self.strength_nm * T::lit(CATCH_NM_S)
        };
        let taken_nm = nm_s * float.period_s;
        let most_nm = weight_nm * T::lit(CORRECTION_SHARE);
        let correction_nm = gravity_nm * self.scale + self.trim_nm;
        if (correction_nm + taken_nm).abs() > most_nm {
            return T::zero();
        }
        let half_nm = weight_nm * T::lit(SCALE_AT_SHARE);
        let gain = if is_resting {
            gravity_nm / (gravity_nm * gravity_nm + half_nm * half_nm)
        } else {
            T::zero()
        };
        self.scale += gain * taken_nm;
        self.trim_nm += taken_nm - gravity_nm * gain * taken_nm;
        taken_nm
    }
}
