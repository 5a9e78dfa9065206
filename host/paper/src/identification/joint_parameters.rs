//! Parameters of joint 1 while joint 2 is straight, and the unknowns among them.
//!
//! ```text
//! J ddq = torque + a sin q - b1 dq - c sign(dq)
//! ```
//!
//! This is the first row of equation (1) at q2 = dq2 = 0, with `J` = M(1,1) and `a` the
//! stiffness of gravity about upright; the last term is dry friction, which the paper
//! leaves out.

use armbridge_control::arm::Parameters;
use nalgebra::Vector2;
use serde::Serialize;

/// Parameters of joint 1, common to all experiments on an arm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct JointParameters<D = f64> {
    /// Viscous friction in N m s/rad.
    pub b1: D,
    /// Torque of the constant input in N m.
    pub torque_nm: D,
    /// M(1,1) in kg m².
    pub inertia_kg_m2: D,
    /// Gravity torque of the level arm in N m; negative for a hanging arm.
    pub gravity_nm: D,
    /// Dry friction of the sliding joint in N m.
    pub coulomb_nm: D,
}

/// A parameter that can be fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Unknown {
    /// [`JointParameters::b1`].
    Viscous,
    /// [`JointParameters::torque_nm`].
    Torque,
    /// [`JointParameters::inertia_kg_m2`].
    Inertia,
    /// [`JointParameters::gravity_nm`].
    Gravity,
    /// [`JointParameters::coulomb_nm`].
    Coulomb,
}

/// Unknown of the paper's free fall: viscous friction alone.
pub const VISCOUS: &[Unknown] = &[Unknown::Viscous];
/// Unknowns of the paper's constant input: "both the input torque and the friction
/// coefficients".
pub const VISCOUS_TORQUE: &[Unknown] = &[Unknown::Viscous, Unknown::Torque];
/// Unknowns of the constant input with the inertia.
pub const VISCOUS_TORQUE_INERTIA: &[Unknown] =
    &[Unknown::Viscous, Unknown::Torque, Unknown::Inertia];
/// Unknowns of a free fall with dry friction.
pub const VISCOUS_COULOMB: &[Unknown] = &[Unknown::Viscous, Unknown::Coulomb];
/// Unknowns of a constant input with dry friction, identifiable only together with a free
/// fall.
pub const VISCOUS_TORQUE_COULOMB: &[Unknown] =
    &[Unknown::Viscous, Unknown::Torque, Unknown::Coulomb];

/// Number of parameters.
pub(super) const COUNT: usize = 5;

impl Unknown {
    /// All parameters in the order of `to_array`.
    pub const ALL: [Self; COUNT] = [
        Self::Viscous,
        Self::Torque,
        Self::Inertia,
        Self::Gravity,
        Self::Coulomb,
    ];

    /// Name for messages.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Viscous => "viscous friction",
            Self::Torque => "torque",
            Self::Inertia => "inertia",
            Self::Gravity => "weight",
            Self::Coulomb => "dry friction",
        }
    }

    /// Smallest scale for relative changes, in the parameter's unit: a parameter near zero
    /// is no scale.
    pub(super) const fn scale_floor(self) -> f64 {
        match self {
            Self::Viscous => 0.01,
            Self::Torque | Self::Gravity => 0.05,
            Self::Inertia => 0.001,
            Self::Coulomb => 0.005,
        }
    }
}

impl JointParameters {
    /// Parameters of an arm without dry friction and without input.
    pub fn from_arm(arm: &Parameters<f64>) -> Self {
        let straight = Vector2::zeros();
        Self {
            b1: arm.b1,
            torque_nm: 0.0,
            inertia_kg_m2: arm.mass(straight).m11,
            gravity_nm: -arm.gravity_slope(straight).m11,
            coulomb_nm: 0.0,
        }
    }

    /// Value of a parameter.
    pub fn get(&self, unknown: Unknown) -> f64 {
        self.to_array()[unknown as usize]
    }

    /// Copy with one parameter replaced.
    #[must_use]
    pub fn with(&self, unknown: Unknown, value: f64) -> Self {
        let mut values = self.to_array();
        values[unknown as usize] = value;
        Self::from_array(values)
    }

    /// Converts with the order of [`Unknown::ALL`].
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

impl<D> JointParameters<D> {
    /// Converts with the order of [`Unknown::ALL`].
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
