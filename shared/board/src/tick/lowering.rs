//! Lowering of a joint: its reference, the torque that carries it, and its rest.
//!
//! The reference goes down with gravity at [`LOWER_RAD_S`], from where it was. The motor carries
//! the joint, and never pushes it: where a stop, the table or friction carries it instead, the
//! reference goes on until the torque is zero.

use armbridge_control::check_word::checked;
use armbridge_control::trajectory::Reference;
use armbridge_servo::JOINTS;
use nalgebra::Vector2;

/// Speed in rad/s at which a joint is lowered: the tip of the arm, 0.2 m away, descends by 3 cm in
/// a second.
const LOWER_RAD_S: f32 = 0.16;
/// Time in s in which it gets that speed, and in µs for which it is lowered at most.
const RAMP_S: f32 = 0.2;
const MAX_US: u64 = 30_000_000;
/// Largest torque that carries a joint, as a multiple of its gravity: for arms that are heavier
/// than the model and servos that are weaker, and to brake. A joint without gravity gets none.
const CARRY_SHARE: f32 = 2.0;
/// Torque in N m below which a motor carries nothing.
const CARRIED_NM: f32 = 0.01;
/// Time in µs within which a joint that rests has not moved by more than this, in rad: three
/// encoder counts, and six standard deviations of the encoder's noise. Its estimated speed is no
/// evidence: the model has no table.
const REST_US: u64 = 150_000;
const REST_RAD: f32 = 0.015;
const REST_DEVIATIONS: f32 = 6.0;

/// Joints whose motors only carry, because they are lowered or have been.
pub(super) type Lowered = [bool; JOINTS];

/// Reference of a joint that is lowered.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Lowering {
    /// Angles in rad at its beginning.
    from: Vector2<f32>,
    joint: u8,
    speed_rad_s: f32,
    starts_us: u64,
}

checked!(Lowering {
    from,
    joint,
    speed_rad_s,
    starts_us
});

impl Lowering {
    /// Lowers this joint from these angles in rad, against the torque in N m that its gravity takes.
    pub(super) fn new(from: Vector2<f32>, joint: usize, gravity_nm: f32, starts_us: u64) -> Self {
        Self {
            from,
            joint: joint as u8,
            speed_rad_s: -LOWER_RAD_S * gravity_nm.signum(),
            starts_us,
        }
    }

    /// The joint.
    pub(super) fn joint(&self) -> usize {
        usize::from(self.joint) % JOINTS
    }

    /// The reference at this time.
    pub(super) fn at(&self, at_us: u64) -> Reference<f32> {
        let elapsed_us = at_us.saturating_sub(self.starts_us).min(MAX_US);
        let elapsed_s = elapsed_us as f32 * 1e-6;
        let ramp_s = elapsed_s.min(RAMP_S);
        let way_s = ramp_s * ramp_s / (2.0 * RAMP_S) + (elapsed_s - ramp_s);
        let mut reference = Reference::at_rest(self.from);
        let joint = self.joint();
        reference.q[joint] += self.speed_rad_s * way_s;
        reference.dq[joint] = self.speed_rad_s * (ramp_s / RAMP_S);
        reference
    }

    /// Turns a bit of its start time, for tests.
    pub(super) fn inject_error(&mut self, bit: u32) {
        self.starts_us ^= 1 << bit;
    }
}

/// Beginning of a joint's rest.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Rest {
    since_us: u64,
    angle_rad: f32,
}
impl Rest {
    /// The rest of a joint at this angle and time under this torque, which rested before since
    /// `before`, with this noise of its encoder; `None` under a torque that carries it.
    pub(super) fn next(
        before: Option<Self>,
        torque_nm: f32,
        angle_rad: f32,
        noise_rad2: f32,
        now_us: u64,
    ) -> Option<Self> {
        if torque_nm.abs() >= CARRIED_NM {
            return None;
        }
        let most_rad2 = REST_RAD * REST_RAD + REST_DEVIATIONS * REST_DEVIATIONS * noise_rad2;
        let is_there = |rest: &Self| {
            let moved_rad = angle_rad - rest.angle_rad;
            moved_rad * moved_rad < most_rad2
        };
        Some(before.filter(is_there).unwrap_or(Self {
            since_us: now_us,
            angle_rad,
        }))
    }

    /// Whether it has lasted for long enough.
    pub(super) fn is_long(&self, now_us: u64) -> bool {
        now_us.saturating_sub(self.since_us) >= REST_US
    }
}

/// The part of this torque in N m that carries the lowered joints, whose gravity takes
/// `gravity_nm`: none that would push them down, and [`CARRY_SHARE`] of gravity at most.
pub(super) fn carried(
    lowered: Lowered,
    demand_nm: Vector2<f32>,
    gravity_nm: Vector2<f32>,
) -> Vector2<f32> {
    let torque = |joint: usize| {
        let (demand_nm, most_nm) = (demand_nm[joint], CARRY_SHARE * gravity_nm[joint]);
        if lowered[joint] {
            demand_nm.max(most_nm.min(0.0)).min(most_nm.max(0.0))
        } else {
            demand_nm
        }
    };
    Vector2::new(torque(0), torque(1))
}
