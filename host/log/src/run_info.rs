//! Facts of a run that are needed to interpret its records.
//!
//! Those that settings change are derived from the settings in force when the motors were
//! first driven: in a log from its `parameters`, see [`metadata`](crate::metadata).

use armbridge_control::actuator::{Direction, Joint};
use armbridge_control::controller::{Lqr, Weights};
use armbridge_link::message::{Controller, Gains, Settings, Setup};
use armbridge_servo::{JOINTS, Pwm};
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

/// PWM value at which a servo is off; the register ranges from 0 to [`PWM_MAX`], and
/// smaller values drive in the opposite direction.
pub const PWM_OFF: u16 = 1000;

/// Largest PWM value.
pub const PWM_MAX: u16 = 2000;

/// Facts of one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunFacts {
    /// Scenario or command that made the run.
    pub name: String,
    /// Where control code and arm run: `simulated: bench`.
    pub world: String,
    /// Version of this program.
    pub version: String,
    /// Seed of all random numbers; none where a run does not repeat.
    pub seed: Option<u64>,
    /// Tick period in µs.
    pub period_us: u32,
    /// Set-up of the bridge.
    pub setup: Setup,
    /// Joint angle per encoder count in rad, negative where a servo is
    /// mounted the other way round.
    pub rad_per_count: [f64; JOINTS],
    /// Encoder count at joint angle zero.
    pub zero_count: [f64; JOINTS],
    /// Lowest and highest torque in N m that can be commanded to each servo.
    pub torque_limits_nm: [[f64; 2]; JOINTS],
    /// Static friction of each joint in N m where it is simulated.
    pub static_friction_nm: Option<[f64; JOINTS]>,
    /// Largest angle in mrad by which that friction can hold each joint away
    /// from its setpoint: friction divided by the net stiffness of the loop.
    pub stiction_offset_mrad: Option<[f64; JOINTS]>,
}

impl RunFacts {
    /// Facts of a run on a board whose settings are known.
    pub fn from_settings(name: &str, world: &str, settings: &Settings) -> Self {
        let joints = settings.setup.joints;
        Self {
            name: name.into(),
            world: world.into(),
            version: env!("CARGO_PKG_VERSION").into(),
            seed: None,
            period_us: settings.setup.period_us,
            setup: settings.setup,
            rad_per_count: joints.map(|joint| signed_rad_per_count(&joint)),
            zero_count: joints.map(|joint| joint.zero_count.into()),
            torque_limits_nm: joints.map(|joint| {
                let ends = [joint.torque(Pwm::MIN), joint.torque(Pwm::MAX)];
                let [a, b] = ends.map(f64::from);
                [a.min(b), a.max(b)]
            }),
            static_friction_nm: None,
            stiction_offset_mrad: None,
        }
    }

    /// The same for a simulated run with this seed, on an arm with this static
    /// friction in N m, if it has any.
    #[must_use]
    pub fn simulated(self, seed: u64, friction_nm: Option<[f64; JOINTS]>) -> Self {
        Self {
            seed: Some(seed),
            static_friction_nm: friction_nm,
            stiction_offset_mrad: stiction_offset_mrad(&self.setup, friction_nm),
            ..self
        }
    }

    /// The same run with other settings.
    #[must_use]
    pub fn with_settings(&self, settings: &Settings) -> Self {
        Self {
            version: self.version.clone(),
            seed: self.seed,
            static_friction_nm: self.static_friction_nm,
            stiction_offset_mrad: stiction_offset_mrad(&settings.setup, self.static_friction_nm),
            ..Self::from_settings(&self.name, &self.world, settings)
        }
    }

    /// Number of joints.
    pub fn joints(&self) -> usize {
        self.setup.arm.joints()
    }

    /// Joint angle in rad of an encoder count.
    pub fn angle_rad(&self, joint: usize, count: u16) -> f64 {
        (f64::from(count) - self.zero_count[joint]) * self.rad_per_count[joint]
    }

    /// Largest torque in N m, by magnitude, that can be commanded in the direction of `sign`;
    /// without one, in either.
    pub fn torque_limit_nm(&self, joint: usize, sign: f64) -> f64 {
        let [low_nm, high_nm] = self.torque_limits_nm[joint].map(f64::abs);
        if sign < 0.0 {
            low_nm
        } else if sign > 0.0 {
            high_nm
        } else {
            low_nm.min(high_nm)
        }
    }

    /// World, seed and period, for titles.
    pub fn describe(&self) -> String {
        let seed = self
            .seed
            .map_or_else(String::new, |seed| format!(" · seed {seed}"));
        format!("{}{seed} · period {} µs", self.world, self.period_us)
    }

    /// Size of one encoder count of a joint in mrad.
    pub(crate) fn count_mrad(&self, joint: usize) -> f64 {
        self.rad_per_count[joint].abs() * 1e3
    }
}

fn signed_rad_per_count(joint: &Joint<f32>) -> f64 {
    let rad_per_count = f64::from(joint.rad_per_count);
    match joint.direction {
        Direction::Forward => rad_per_count,
        Direction::Reverse => -rad_per_count,
    }
}

/// Largest angle in mrad by which static friction can hold each joint off its setpoint.
fn stiction_offset_mrad(
    setup: &Setup,
    friction_nm: Option<[f64; JOINTS]>,
) -> Option<[f64; JOINTS]> {
    let (friction_nm, stiffness) = (friction_nm?, net_stiffness(setup)?);
    Some([0, 1].map(|j| 1e3 * friction_nm[j] / stiffness[j]))
}

/// Stiffness in N m/rad with which state feedback holds the arm upright: the gain
/// on the angle, minus that of gravity.
fn net_stiffness(setup: &Setup) -> Option<[f64; JOINTS]> {
    let arm = setup.arm.map(f64::from);
    let upright = Vector2::zeros();
    let gain = match setup.controller {
        Controller::StateFeedback(Gains::Design { q, r }) => {
            let model = arm
                .linearise(upright)
                .zero_order_hold(f64::from(setup.period_us) * 1e-6);
            let weights = Weights {
                q: q.map(f64::from),
                r: r.map(f64::from),
            };
            Lqr::design(&model, &weights).ok()?.gain
        }
        Controller::StateFeedback(Gains::Paper) => Lqr::paper().gain,
        Controller::StateFeedback(Gains::Given([first, second])) => {
            Lqr::of_rows(first.map(f64::from), second.map(f64::from)).gain
        }
        Controller::ComputedTorque { .. } => return None,
    };
    let gravity = arm.gravity_slope(upright);
    Some([0, 1].map(|j| gain[(j, j)] + gravity[(j, j)]))
}
