//! Parameters of control and estimation, in the format of the link.

use super::limits::Limits;
use armbridge_control::actuator::Joint;
use armbridge_control::arm::Parameters;
use armbridge_control::controller::friction;
use armbridge_control::encoder::Encoder;
use armbridge_control::estimate::Config;
use armbridge_servo::{ControlMode, JOINTS};
use postcard::experimental::max_size::MaxSize;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Largest friction of loaded gears, in percent of the torque that they transmit.
pub const FRICTION_LOAD_PERCENT_MAX: u8 = (friction::LOAD_MAX * 100.0) as u8;

/// Parameters of control and estimation, replaced as one atomic group.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema, MaxSize)]
pub struct Setup {
    /// Tick period in µs.
    pub period_us: u32,
    /// Controller, from state to torque.
    pub controller: Controller,
    /// Estimator, from samples to state.
    pub estimator: Config<f32>,
    /// Integral action of the controller: torque in N m per rad s of angle error, joint by
    /// joint; 0 for none. Refused unless the loop with it is stable upright.
    pub integral: [f32; JOINTS],
    /// Torque in N m added against dry friction, joint by joint; 0 for none.
    pub friction_nm: [f32; JOINTS],
    /// Dry friction in percent of the torque that the gears transmit, joint by joint, beside
    /// `friction_nm`; at most [`FRICTION_LOAD_PERCENT_MAX`], 0 for none. A filter with dry friction
    /// in its model has this one, too.
    pub friction_load_percent: [u8; JOINTS],
    /// Model of the arm for controller and estimator.
    pub arm: Parameters<f32>,
    /// Models of its servos.
    pub joints: [Joint<f32>; JOINTS],
    /// What the servos' commands are, and so the counts of their models. Current is of X servos.
    pub control_mode: ControlMode,
}

/// Settings that a board stores across power-off.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, Schema, MaxSize)]
pub struct Settings {
    /// Parameters of control and estimation.
    pub setup: Setup,
    /// Limits of the monitors.
    pub limits: Limits,
}

impl Default for Setup {
    /// 1 kHz, the paper's arm and weights (8), and an observer with time
    /// constants of 15 and 16 ms: little noise in the torque, little damping
    /// lost. Nothing is done about friction.
    fn default() -> Self {
        Self {
            period_us: 1_000,
            controller: Controller::StateFeedback(Gains::Design {
                q: [15.0, 15.0, 1.0, 1.0],
                r: [10.0, 10.0],
            }),
            estimator: Config::standing(),
            integral: [0.0; JOINTS],
            friction_nm: [0.0; JOINTS],
            friction_load_percent: [0; JOINTS],
            arm: Parameters::paper(),
            joints: [Joint::paper(); JOINTS],
            control_mode: ControlMode::Pwm,
        }
    }
}

impl Setup {
    /// Whether servos of these models can have the control mode. A board does not ask: of an AX-12A the
    /// mode has no meaning, and it refuses to arm with the calibration of other servos.
    pub fn mode_is_possible(&self) -> bool {
        let is_x = |joint: &Joint<f32>| joint.encoder() == Some(Encoder::XSeries);
        self.control_mode == ControlMode::Pwm
            || self.joints.iter().take(self.arm.joints()).all(is_x)
    }

    /// This control of `own`'s arm and servos.
    #[must_use]
    pub fn with_arm_of(self, own: &Self) -> Self {
        Self {
            arm: own.arm,
            joints: own.joints,
            control_mode: own.control_mode,
            ..self
        }
    }

    /// Dry friction in N m per N m that the gears transmit, joint by joint.
    pub fn friction_load(&self) -> [f32; JOINTS] {
        self.friction_load_percent
            .map(|percent| f32::from(percent) * 0.01)
    }

    /// The set-up that stands best on an arm with dry friction: a Kalman filter that finds
    /// disturbance torques, Coulomb friction fed forward, and an LQR
    /// stiffer than the paper's.
    pub fn best() -> Self {
        Self {
            controller: Controller::StateFeedback(Gains::Design {
                q: [30.0, 30.0, 0.3, 0.3],
                r: [10.0, 10.0],
            }),
            estimator: Config::kalman(),
            // What the filter is tuned for.
            friction_nm: [0.04; JOINTS],
            ..Self::default()
        }
    }
}

/// Controller, from state to torque.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema, MaxSize)]
pub enum Controller {
    /// State feedback (9), with the torque that the reference itself takes.
    StateFeedback(Gains),
    /// Feedback linearisation: errors die away as second-order systems do.
    ComputedTorque {
        /// Natural frequency of each joint in rad/s.
        natural_rad_s: [f32; JOINTS],
        /// Damping ratio of each joint; 1 is critical.
        damping: [f32; JOINTS],
    },
}

/// Source of the state-feedback gain.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema, MaxSize)]
pub enum Gains {
    /// The printed gain, equation (10), meant for 45 ms.
    Paper,
    /// Designed on the board for the running period from diagonal weights.
    Design {
        /// Diagonal of Q: both angles, both speeds (equation (8)).
        q: [f32; 2 * JOINTS],
        /// Diagonal of R: both torques (equation (8)).
        r: [f32; JOINTS],
    },
    /// A gain K set by the user, refused unless it stabilises the arm about upright at
    /// the running period. Rows: torques; columns: both angles, both speeds.
    Given([[f32; 2 * JOINTS]; JOINTS]),
}
