//! Parameters of a servo on a pendulum, and the coordinates in which they are searched.
//!
//! A coordinate is the logarithm of a parameter that is above zero, relative to its initial
//! value; that of the zero, which has either sign, is in units of [`ZERO_UNIT_RAD`]. All
//! coordinates begin at 0 and change by about 1.

use nalgebra::DVector;
use serde::Serialize;

/// Unit of the zero's coordinate in rad.
const ZERO_UNIT_RAD: f64 = 0.01;
/// Largest magnitude of a coordinate that becomes a parameter: numbers stay finite.
const COORDINATE_MAX: f64 = 20.0;

/// Number of parameters of all forms.
pub(super) const COUNT: usize = Quantity::ALL.len();

/// A parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Torque constant over winding resistance, kt / R: stall torque per volt.
    StallTorque,
    /// Damping by back-EMF while the motor is driven, kt² / R.
    BackEmf,
    /// Inertia of rotor and gears at the output shaft.
    RotorInertia,
    /// Coulomb friction.
    Coulomb,
    /// Viscous friction of the gears, driven or not.
    Viscous,
    /// Angle at which the pendulum hangs.
    Zero,
    /// Time from a goal's time stamp to its effect on the motor.
    Delay,
    /// Dry friction per torque on the gears, at speed.
    Load,
    /// The same at rest, beyond that at speed.
    LoadStatic,
    /// Speed at which friction beyond that at speed has fallen to 1/e.
    StribeckSpeed,
}

impl Quantity {
    /// All, in the order of their places.
    pub const ALL: [Self; 10] = [
        Self::StallTorque,
        Self::BackEmf,
        Self::RotorInertia,
        Self::Coulomb,
        Self::Viscous,
        Self::Zero,
        Self::Delay,
        Self::Load,
        Self::LoadStatic,
        Self::StribeckSpeed,
    ];

    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::StallTorque => "torque constant / resistance",
            Self::BackEmf => "back-EMF damping, driven",
            Self::RotorInertia => "rotor and gear inertia",
            Self::Coulomb => "Coulomb friction",
            Self::Viscous => "viscous friction",
            Self::Zero => "zero",
            Self::Delay => "delay of goals",
            Self::Load => "load friction",
            Self::LoadStatic => "load friction at rest, more",
            Self::StribeckSpeed => "Stribeck speed",
        }
    }

    /// Unit.
    pub fn unit(self) -> &'static str {
        match self {
            Self::StallTorque => "N m/V",
            Self::BackEmf | Self::Viscous => "N m s/rad",
            Self::RotorInertia => "kg m²",
            Self::Coulomb => "N m",
            Self::Zero => "rad",
            Self::Delay => "s",
            Self::Load | Self::LoadStatic => "N m/N m",
            Self::StribeckSpeed => "rad/s",
        }
    }

    /// Value at which a search begins: that of small servos in the order of magnitude.
    fn initial(self) -> f64 {
        match self {
            Self::StallTorque => 0.09,
            Self::BackEmf => 0.03,
            Self::RotorInertia => 0.0016,
            Self::Coulomb => 0.01,
            Self::Viscous => 0.005,
            Self::Zero => 0.0,
            Self::Delay => 0.004,
            Self::Load | Self::LoadStatic => 0.15,
            Self::StribeckSpeed => 0.3,
        }
    }

    fn at(self, coordinate: f64) -> f64 {
        let coordinate = coordinate.clamp(-COORDINATE_MAX, COORDINATE_MAX);
        match self {
            Self::Zero => coordinate * ZERO_UNIT_RAD,
            _ => self.initial() * coordinate.exp(),
        }
    }

    fn coordinate(self, value: f64) -> f64 {
        match self {
            Self::Zero => value / ZERO_UNIT_RAD,
            _ => (value.max(f64::MIN_POSITIVE) / self.initial()).ln(),
        }
    }
}

/// Form of dry friction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FrictionForm {
    /// Of one size at any speed and load.
    Coulomb,
    /// Grows with the torque on the gears.
    Load,
    /// Grows with the torque on the gears, more so at rest.
    LoadStribeck,
}

impl FrictionForm {
    /// All, from simple to elaborate.
    pub const ALL: [Self; 3] = [Self::Coulomb, Self::Load, Self::LoadStribeck];

    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Coulomb => "Coulomb",
            Self::Load => "load",
            Self::LoadStribeck => "load, Stribeck",
        }
    }

    /// Its parameters, with those that all forms have.
    pub fn quantities(self) -> Vec<Quantity> {
        let own: &[Quantity] = match self {
            Self::Coulomb => &[],
            Self::Load => &[Quantity::Load],
            Self::LoadStribeck => &[
                Quantity::Load,
                Quantity::LoadStatic,
                Quantity::StribeckSpeed,
            ],
        };
        let common = Quantity::ALL[..=Quantity::Delay as usize].iter();
        common.chain(own).copied().collect()
    }
}

/// Values of all parameters; those that a form lacks are 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Parameters([f64; COUNT]);

impl Parameters {
    /// The value of a parameter.
    pub fn get(&self, quantity: Quantity) -> f64 {
        self.0[quantity as usize]
    }

    /// The same with another value of a parameter.
    #[must_use]
    pub fn with(mut self, quantity: Quantity, value: f64) -> Self {
        self.0[quantity as usize] = value;
        self
    }

    /// Torque constant in N m/A: back-EMF damping over stall torque per volt.
    pub fn torque_constant_nm_a(&self) -> f64 {
        self.get(Quantity::BackEmf) / self.get(Quantity::StallTorque)
    }

    /// Resistance of the winding in ohm.
    pub fn resistance_ohm(&self) -> f64 {
        self.torque_constant_nm_a() / self.get(Quantity::StallTorque)
    }

    /// Those at these coordinates, in the order of the quantities.
    pub(super) fn at(quantities: &[Quantity], coordinates: &DVector<f64>) -> Self {
        let pairs = quantities.iter().zip(coordinates.iter());
        pairs.fold(Self::default(), |parameters, (&quantity, &coordinate)| {
            parameters.with(quantity, quantity.at(coordinate))
        })
    }

    /// Their coordinates.
    pub(super) fn coordinates(&self, quantities: &[Quantity]) -> DVector<f64> {
        let coordinates = quantities.iter().map(|&it| it.coordinate(self.get(it)));
        DVector::from_iterator(quantities.len(), coordinates)
    }
}
