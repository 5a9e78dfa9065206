//! Prior of the parameters, before any log.
//!
//! Motion determines the torques of an arm only up to a common factor: an arm of twice the
//! inertia, friction and weight whose motors are twice as strong moves alike. The weight
//! fixes this factor, as in the paper: masses and lengths, measured by scale and ruler, give
//! the gravity torques.

use armbridge_link::message::Setup;
use armbridge_servo::JOINTS;

use super::quantity::{COUNT, Quantity};

/// Coulomb friction in N m of an AX-12A before any measurement, see
/// [`PlantConfig`](armbridge_sim::plant::PlantConfig).
const COULOMB_NM: f64 = 0.04;
/// Dead zone before any measurement, in counts: half of the paper's.
const DEAD_COUNTS: f64 = 25.0;
/// Least gravity torque in N m: the logarithm of none is not a number.
const GRAVITY_MIN_NM: f64 = 1e-9;
/// Delay before any measurement, in s.
const DELAY_S: f64 = 2e-3;

/// Prior of each coordinate: a normal distribution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prior {
    /// Means.
    pub mean: [f64; COUNT],
    /// Standard deviations.
    pub deviation: [f64; COUNT],
}

impl Prior {
    /// Prior of a set-up. The relative standard deviation of its gravity torques, from masses
    /// and lengths, is `weighed`; the other relative parameters are known to a factor of
    /// three.
    pub fn from_setup(setup: &Setup, weighed: f64) -> Self {
        let mut mean = [0.0; COUNT];
        let mut deviation = [0.0; COUNT];
        for joint in 0..JOINTS {
            for quantity in Quantity::ALL {
                let i = quantity.index(joint);
                mean[i] = quantity.coordinate(quantity.nominal(setup, joint));
                deviation[i] = match quantity {
                    Quantity::Gravity => weighed,
                    Quantity::Inertia | Quantity::Viscous | Quantity::Coulomb | Quantity::Gain => {
                        3.0_f64.ln()
                    }
                    Quantity::Offset => Quantity::Offset.coordinate(50.0),
                    Quantity::DeadBelow | Quantity::DeadAbove => {
                        Quantity::DeadAbove.coordinate(40.0)
                    }
                    Quantity::Zero => Quantity::Zero.coordinate(30.0),
                    Quantity::Delay => Quantity::Delay.coordinate(5e-3),
                };
            }
        }
        Self { mean, deviation }
    }
}

impl Quantity {
    /// Nominal value: that of the set-up, or a usual one if the set-up has none.
    pub fn nominal(self, setup: &Setup, joint: usize) -> f64 {
        let arm = setup.arm.map(f64::from);
        let servo = &setup.joints[joint];
        match (self, joint) {
            (Self::Inertia, 0) => {
                arm.i1x + arm.m1 * arm.l1 * arm.l1 / 4.0 + arm.i2z + arm.m2 * arm.l1 * arm.l1
            }
            (Self::Inertia, _) => arm.i2y + arm.m2 * arm.l2 * arm.l2 / 4.0,
            (Self::Gravity, 0) => arm.g * arm.l1 * (arm.m1 / 2.0 + arm.m2),
            (Self::Gravity, _) => (arm.g * arm.l2 * arm.m2 / 2.0).max(GRAVITY_MIN_NM),
            (Self::Viscous, 0) => arm.b1,
            (Self::Viscous, _) => arm.b2,
            (Self::Coulomb, _) => match f64::from(setup.friction_nm[joint]) {
                known if known > 0.0 => known,
                _ => COULOMB_NM,
            },
            (Self::Gain, _) => servo.gain_counts_per_nm.into(),
            (Self::Offset, _) => servo.offset_counts.into(),
            (Self::DeadBelow | Self::DeadAbove, _) => DEAD_COUNTS,
            (Self::Zero, _) => servo.zero_count.into(),
            (Self::Delay, _) => DELAY_S,
        }
    }
}
