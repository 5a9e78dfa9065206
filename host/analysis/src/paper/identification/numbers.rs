//! The numbers of joint 1 while joint 2 is straight, and which of them are sought.
//!
//! ```text
//! J ddq = torque + a sin q - b1 dq - c sign(dq)
//! ```
//!
//! This is the first row of equation (1) at q2 = dq2 = 0, with `J` = M(1,1) and `a` the
//! stiffness of gravity about upright; the last term is dry friction, which the paper
//! leaves out.

use armbridge_shared::arm::Parameters;
use nalgebra::Vector2;
use serde::Serialize;

/// The numbers that all experiments on an arm have in common.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Numbers<D = f64> {
    /// Viscous friction in N m s/rad.
    pub b1: D,
    /// The constant input in N m, of experiments that have one.
    pub torque_nm: D,
    /// M(1,1) in kg m².
    pub inertia_kg_m2: D,
    /// Gravity torque of the level arm in N m; negative of an arm that hangs.
    pub gravity_nm: D,
    /// Dry friction of the sliding joint in N m.
    pub coulomb_nm: D,
}

/// A number that may be sought.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Unknown {
    /// [`Numbers::b1`].
    Viscous,
    /// [`Numbers::torque_nm`].
    Torque,
    /// [`Numbers::inertia_kg_m2`].
    Inertia,
    /// [`Numbers::gravity_nm`].
    Gravity,
    /// [`Numbers::coulomb_nm`].
    Coulomb,
}

/// The paper's free fall: viscous friction is all there is.
pub const VISCOUS: &[Unknown] = &[Unknown::Viscous];
/// The paper's constant input: "both the input torque and the friction coefficients".
pub const VISCOUS_TORQUE: &[Unknown] = &[Unknown::Viscous, Unknown::Torque];
/// The same with the inertia.
pub const VISCOUS_TORQUE_INERTIA: &[Unknown] =
    &[Unknown::Viscous, Unknown::Torque, Unknown::Inertia];
/// A free fall with dry friction.
pub const VISCOUS_COULOMB: &[Unknown] = &[Unknown::Viscous, Unknown::Coulomb];
/// A constant input with dry friction: of use together with a free fall only.
pub const VISCOUS_TORQUE_COULOMB: &[Unknown] =
    &[Unknown::Viscous, Unknown::Torque, Unknown::Coulomb];

/// How many there are.
pub(super) const COUNT: usize = 5;

impl Unknown {
    /// All of them, as they lie in `to_array`.
    pub const ALL: [Self; COUNT] = [
        Self::Viscous,
        Self::Torque,
        Self::Inertia,
        Self::Gravity,
        Self::Coulomb,
    ];

    /// In words.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Viscous => "viscous friction",
            Self::Torque => "torque",
            Self::Inertia => "inertia",
            Self::Gravity => "weight",
            Self::Coulomb => "dry friction",
        }
    }

    /// What is much of it, in its unit: shares of a number near nothing say nothing.
    pub(super) const fn much(self) -> f64 {
        match self {
            Self::Viscous => 0.01,
            Self::Torque | Self::Gravity => 0.05,
            Self::Inertia => 0.001,
            Self::Coulomb => 0.005,
        }
    }
}

impl Numbers {
    /// Of an arm without dry friction and without input.
    pub fn of(arm: &Parameters<f64>) -> Self {
        let straight = Vector2::zeros();
        Self {
            b1: arm.b1,
            torque_nm: 0.0,
            inertia_kg_m2: arm.mass(straight).m11,
            gravity_nm: -arm.gravity_slope(straight).m11,
            coulomb_nm: 0.0,
        }
    }

    /// The one of them.
    pub fn get(&self, unknown: Unknown) -> f64 {
        self.to_array()[unknown as usize]
    }

    /// The same but for one.
    #[must_use]
    pub fn with(&self, unknown: Unknown, value: f64) -> Self {
        let mut numbers = self.to_array();
        numbers[unknown as usize] = value;
        Self::from_array(numbers)
    }

    /// In the order of [`Unknown::ALL`].
    pub(super) fn to_array(self) -> [f64; COUNT] {
        [
            self.b1,
            self.torque_nm,
            self.inertia_kg_m2,
            self.gravity_nm,
            self.coulomb_nm,
        ]
    }
}

impl<D> Numbers<D> {
    /// In the order of [`Unknown::ALL`].
    pub(super) fn from_array(
        [b1, torque_nm, inertia_kg_m2, gravity_nm, coulomb_nm]: [D; COUNT],
    ) -> Self {
        Self {
            b1,
            torque_nm,
            inertia_kg_m2,
            gravity_nm,
            coulomb_nm,
        }
    }
}
