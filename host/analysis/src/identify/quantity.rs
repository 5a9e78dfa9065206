//! Parameters of the model: ten of each joint, and the coordinates of the search.
//!
//! The search runs in unconstrained coordinates: the logarithm of a positive parameter, or
//! the value over a relevant step. So a step of the search is a relative one, whatever the
//! unit.

use armbridge_servo::JOINTS;
use num_dual::DualNum;

/// A parameter of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Quantity {
    /// Part of the mass matrix's diagonal that does not depend on the angles, in kg m².
    Inertia,
    /// Gravity torque of the joint with its arm level, in N m; for joint 1 without the part
    /// of link 2 beyond joint 2, which is joint 2's own.
    Gravity,
    /// Viscous friction in N m s/rad.
    Viscous,
    /// Coulomb friction in N m.
    Coulomb,
    /// PWM counts per N m.
    Gain,
    /// PWM counts from neutral to zero torque.
    Offset,
    /// PWM counts below neutral up to which there is no torque.
    DeadBelow,
    /// PWM counts above neutral up to which there is no torque.
    DeadAbove,
    /// Encoder count at angle 0.
    Zero,
    /// Delay from a PWM's arrival in the servo to its torque, in s, see
    /// [`KnownParameters`](super::KnownParameters).
    Delay,
}

/// Number of parameters of a joint.
pub const PER_JOINT: usize = 10;
/// Number of parameters of an arm.
pub const COUNT: usize = PER_JOINT * JOINTS;

impl Quantity {
    /// All parameters, in the order of their index.
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

    /// Name.
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

    /// Unit.
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

    /// Index among the parameters of an arm.
    pub const fn index(self, joint: usize) -> usize {
        joint * PER_JOINT + self as usize
    }

    /// Indices of the dead zones' edges.
    pub fn dead_zone_edges() -> impl Iterator<Item = usize> {
        (0..JOINTS).flat_map(|joint| [Self::DeadBelow.index(joint), Self::DeadAbove.index(joint)])
    }

    /// Value of a coordinate of 1; `None` for a logarithm.
    const fn step(self) -> Option<f64> {
        match self {
            Self::Inertia | Self::Gravity | Self::Viscous | Self::Coulomb | Self::Gain => None,
            // Counts of PWM, of which 50 are the paper's dead zone.
            Self::Offset | Self::DeadBelow | Self::DeadAbove => Some(10.0),
            Self::Zero => Some(1.0),
            Self::Delay => Some(1e-3),
        }
    }

    /// Value of a coordinate.
    pub fn value<D: DualNum<Primitive = f64> + Copy>(self, coordinate: D) -> D {
        match self.step() {
            Some(step) => coordinate * step,
            None => coordinate.exp(),
        }
    }

    /// Whether the coordinate is a logarithm.
    pub const fn is_relative(self) -> bool {
        self.step().is_none()
    }

    /// Derivative of the value by the coordinate.
    pub fn derivative(self, coordinate: f64) -> f64 {
        self.step().unwrap_or_else(|| coordinate.exp())
    }

    /// Coordinate of a value.
    pub fn coordinate(self, value: f64) -> f64 {
        match self.step() {
            Some(step) => value / step,
            None => value.ln(),
        }
    }
}
