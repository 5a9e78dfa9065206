//! Dry friction of a joint, and its state.
//!
//! Part of it grows with the torque that the gears transmit ([`Friction::load`]). Motor and load
//! press upon the same teeth, one from either end: a motor that holds a weight has the gears
//! transmit both, so that their magnitudes add up.
//!
//! ```text
//! gears = |motor - F dq + G(q) - external|
//! ```
//!
//! `motor` is the torque of the motor at rest, `F dq` what it loses with speed (nearly all of the
//! viscous friction of such a motor is its back-EMF), `G(q)` the torque that holds the arm, and
//! `external` that of pushes and hands. No acceleration is in it, and no friction: friction
//! follows from the state and the torques, without an equation to solve.

use armbridge_control::arm::State;
use armbridge_servo::JOINTS;
use nalgebra::ComplexField;

/// Dry friction of one joint, in N m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Friction {
    /// Torque against the motion of a sliding joint.
    pub coulomb_nm: f64,
    /// Torque that a joint at rest withstands.
    pub static_nm: f64,
    /// vs in rad/s of a sliding joint's `coulomb_nm + (static_nm - coulomb_nm)
    /// exp(-(v/vs)^2)`. 0 for `coulomb_nm` alone, at any speed.
    pub stribeck_rad_s: f64,
    /// Dry friction in N m per N m that the gears transmit, added to that of a sliding joint and to
    /// that of one at rest; below 1, or no motor could turn its gears.
    pub load: f64,
}

impl Friction {
    /// No dry friction; the viscous one is part of the arm's parameters.
    pub const NONE: Self = Self {
        coulomb_nm: 0.0,
        static_nm: 0.0,
        stribeck_rad_s: 0.0,
        load: 0.0,
    };

    /// Largest part of the transmitted torque.
    pub const LOAD_MAX: f64 = 0.9;

    /// Torque in N m against a sliding joint of this speed, with gears that transmit nothing.
    pub(super) fn sliding_nm(&self, speed_rad_s: f64) -> f64 {
        if self.stribeck_rad_s > 0.0 {
            // nalgebra's own, not the platform's: the same bits everywhere.
            let share = speed_rad_s / self.stribeck_rad_s;
            self.coulomb_nm + (self.static_nm - self.coulomb_nm) * ComplexField::exp(-share * share)
        } else {
            self.coulomb_nm
        }
    }
}

/// State of dry friction of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Contact {
    /// It has no dry friction.
    Free,
    /// It is at rest.
    Stuck,
    /// It slides, towards larger (1) or smaller (-1) angles.
    Sliding(f64),
}

/// Contact of joints with these speeds.
pub(super) fn contact_of(friction: &[Friction; JOINTS], state: &State<f64>) -> [Contact; JOINTS] {
    core::array::from_fn(|joint| {
        if friction[joint] == Friction::NONE {
            Contact::Free
        } else if state.dq[joint] == 0.0 {
            Contact::Stuck
        } else {
            Contact::Sliding(state.dq[joint].signum())
        }
    })
}
