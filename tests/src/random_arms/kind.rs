//! Kinds of drawn arms: the arm and the servos that a board knows nominally.

use armbridge_control::actuator::Joint;
use armbridge_link::message::Setup;
use armbridge_servo::{Firmware, JOINTS};
use armbridge_sim::environment::fast::Delays;
use armbridge_sim::plant::{PlantConfig, PlantFile};

use super::plan;

/// Relative spread of the drawn parameters.
const SPREAD: f64 = 0.4;

/// A kind of arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The paper's arm, two AX-12A with Morpheus: all numbers are drawn.
    Ax12a,
    /// Two XL430 in PWM control mode: masses, inertias, friction, and the motors' gain are drawn.
    /// They have no dead zone, and friction that grows with the load.
    Xl430,
}

impl Kind {
    /// The arm that a board believes in.
    fn nominal(self) -> PlantConfig {
        match self {
            Self::Ax12a => PlantConfig::default(),
            Self::Xl430 => PlantFile::load("xl430").unwrap().config([0.0; JOINTS]),
        }
    }

    /// A drawn arm.
    pub fn drawn(self, seed: u64) -> PlantConfig {
        let initial = PlantConfig::default().initial;
        let drawn = match self {
            Self::Ax12a => PlantConfig::drawn(seed, SPREAD),
            Self::Xl430 => self.nominal().varied(seed, SPREAD),
        };
        // Of the motors, whose gain is one parameter of a fit.
        let joints = drawn.joints.map(|joint| Joint {
            gain_counts_per_nm: joint.gain_counts_per_nm / drawn.torque_gain,
            ..joint
        });
        PlantConfig {
            initial,
            joints,
            torque_gain: 1.0,
            ..drawn
        }
    }

    /// Set-up of a board before identification, as the plan has it.
    pub fn setup(self) -> Setup {
        plan::shipped(Setup {
            friction_nm: [0.0; JOINTS],
            friction_load_percent: [0; JOINTS],
            ..self.nominal().board_setup(Setup::default())
        })
    }

    /// From the sample behind a tick's angle to the moment at which a servo applies the PWM of
    /// that tick, in s, on average.
    pub fn bus_s(self) -> [f64; JOINTS] {
        match self {
            // Over the 158 000 ticks of the default plan on the bench whose PWM is another than
            // before: from the servo's conversion to the step of its control that puts the PWM on
            // the motor. It does either once in 0.89 ms, so that a tick's time may be off by half
            // of that.
            Self::Ax12a => [0.756e-3, 0.679e-3],
            Self::Xl430 => [Delays::of(Firmware::XSeries).total_us() as f64 * 1e-6; JOINTS],
        }
    }
}
