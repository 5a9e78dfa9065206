//! Actions of a policy as commands to the board.

use armbridge_link::message::{Command, Settings};
use armbridge_servo::{JOINTS, Pwm};

/// Meaning of an action. Values beyond its bounds count as the nearest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ActionKind {
    /// Torques in N m.
    Torque,
    /// Setpoints of the board's controller, in rad.
    Setpoint,
    /// PWM counts from off, sent as the torque that they stand for by the board's calibration.
    Pwm,
}

impl ActionKind {
    /// Smallest and largest action of each joint under a board's limits.
    pub fn bounds(self, settings: &Settings) -> [[f64; 2]; JOINTS] {
        let limits = &settings.limits;
        let most = match self {
            Self::Torque => limits.torque_nm.map(f64::from),
            Self::Setpoint => limits.angle_rad.map(f64::from),
            Self::Pwm => [f64::from(limits.pwm_counts); JOINTS],
        };
        most.map(|most| [-most, most])
    }

    /// The command of an action, all of whose values are numbers.
    pub(super) fn command(self, action: [f64; JOINTS], settings: &Settings) -> Command {
        let bounds = self.bounds(settings);
        let action: [f64; JOINTS] =
            core::array::from_fn(|joint| action[joint].clamp(bounds[joint][0], bounds[joint][1]));
        match self {
            Self::Torque => Command::Torque(action.map(|value| value as f32)),
            Self::Setpoint => Command::Regulate(action.map(|value| value as f32)),
            Self::Pwm => Command::Torque(core::array::from_fn(|joint| {
                let pwm = f64::from(Pwm::OFF.counts()) + action[joint].round();
                settings.setup.joints[joint].torque(Pwm::saturating(pwm as u16))
            })),
        }
    }
}
