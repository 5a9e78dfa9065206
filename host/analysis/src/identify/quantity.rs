//! What is looked for: ten numbers of each joint.
//!
//! Searched are not the numbers themselves but coordinates in which they are free to go
//! anywhere: the logarithm of what is positive, a multiple of a step of the order of
//! what matters of what is not. A step of the search is so a relative one, whatever the
//! unit.

use armbridge_shared::JOINTS;
use num_dual::DualNum;

/// A number of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Quantity {
    /// What of the mass matrix's diagonal does not depend on the angles, in kg m².
    Inertia,
    /// Gravity torque of the joint with its arm level, in N m; that of joint 1 without
    /// the share of link 2 beyond joint 2, which is joint 2's own.
    Gravity,
    /// Viscous friction in N m s/rad.
    Viscous,
    /// Coulomb friction in N m.
    Coulomb,
    /// PWM counts per N m.
    Gain,
    /// PWM counts above off at which there is no torque.
    Offset,
    /// PWM counts below off up to which there is no torque.
    DeadBelow,
    /// PWM counts above off up to which there is no torque.
    DeadAbove,
    /// Encoder count at angle 0.
    Zero,
    /// From a PWM's arrival in the servo to its torque, in s, see [`Known`](super::Known).
    Delay,
}

/// Numbers of a joint.
pub const PER_JOINT: usize = 10;
/// Numbers of an arm.
pub const COUNT: usize = PER_JOINT * JOINTS;

impl Quantity {
    /// All, in order.
    pub const ALL: [Self; PER_JOINT] = [
        Self::Inertia,
        Self::Gravity,
        Self::Viscous,
        Self::Coulomb,
        Self::Gain,
        Self::Offset,
        Self::DeadBelow,
        Self::DeadAbove,
        Self::Zero,
        Self::Delay,
    ];

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Inertia => "inertia",
            Self::Gravity => "gravity",
            Self::Viscous => "viscous friction",
            Self::Coulomb => "Coulomb friction",
            Self::Gain => "motor gain",
            Self::Offset => "motor offset",
            Self::DeadBelow => "dead zone below",
            Self::DeadAbove => "dead zone above",
            Self::Zero => "encoder zero",
            Self::Delay => "delay",
        }
    }

    /// Its unit.
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Inertia => "kg m²",
            Self::Gravity | Self::Coulomb => "N m",
            Self::Viscous => "N m s/rad",
            Self::Gain => "counts/N m",
            Self::Offset | Self::DeadBelow | Self::DeadAbove | Self::Zero => "counts",
            Self::Delay => "s",
        }
    }

    /// Its place among the numbers of an arm.
    pub const fn at(self, joint: usize) -> usize {
        joint * PER_JOINT + self as usize
    }

    /// Places of the dead zones' edges.
    pub fn edges() -> impl Iterator<Item = usize> {
        (0..JOINTS).flat_map(|joint| [Self::DeadBelow.at(joint), Self::DeadAbove.at(joint)])
    }

    /// What a coordinate of 1 is; `None` for one that is a logarithm.
    const fn step(self) -> Option<f64> {
        match self {
            Self::Inertia | Self::Gravity | Self::Viscous | Self::Coulomb | Self::Gain => None,
            // Counts of PWM, of which 50 are the paper's dead zone.
            Self::Offset | Self::DeadBelow | Self::DeadAbove => Some(10.0),
            Self::Zero => Some(1.0),
            Self::Delay => Some(1e-3),
        }
    }

    /// The number of a coordinate.
    pub fn value<D: DualNum<Primitive = f64> + Copy>(self, coordinate: D) -> D {
        match self.step() {
            Some(step) => coordinate * step,
            None => coordinate.exp(),
        }
    }

    /// Whether its coordinate is a logarithm.
    pub const fn is_relative(self) -> bool {
        self.step().is_none()
    }

    /// How fast the number grows with its coordinate.
    pub fn slope(self, coordinate: f64) -> f64 {
        self.step().unwrap_or_else(|| coordinate.exp())
    }

    /// The coordinate of a number.
    pub fn coordinate(self, value: f64) -> f64 {
        match self.step() {
            Some(step) => value / step,
            None => value.ln(),
        }
    }
}
