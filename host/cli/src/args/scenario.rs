//! Overrides of a scenario, for one run of it or many.

use armbridge::config::Config;
use armbridge_analysis::plan_runner::plan::Base;
use armbridge_analysis::scenario::Overrides;
use armbridge_servo::JOINTS;
use armbridge_sim::plant::{PlantError, PlantFile};
use clap::{Args, ValueEnum};
use toml::Value;

use super::suggestions::{parameters, plants};
use super::values::{angles, duration};

/// Control, parameters and length of a run.
#[derive(Args, Clone, Debug)]
pub(crate) struct ScenarioArgs {
    /// Controller and estimator, instead of the scenario's own.
    #[arg(long, value_enum)]
    control: Option<ControlName>,
    /// Change a parameter of the board for the run; may be repeated.
    #[arg(long, value_name = "KEY=VALUE", value_parser = parameters(), hide_possible_values = true)]
    set: Vec<(String, Value)>,
    /// Length of the run in s, instead of the scenario's own; repeated motions go on
    /// until then.
    #[arg(long, value_name = "S", value_parser = duration)]
    duration: Option<f64>,
}

/// The virtual arm, where it is not the scenario's own.
#[derive(Args, Clone, Debug)]
pub(crate) struct ScenarioArmArgs {
    /// Joint angles in rad at which the arm is held until torque comes on, instead of the
    /// scenario's own.
    #[arg(long, value_name = "RAD,RAD", value_parser = angles, allow_hyphen_values = true)]
    pub(crate) initial: Option<[f64; JOINTS]>,
    /// Virtual arm instead of the scenario's own: the name of one that ships (`armbridge
    /// plants`), or a file.
    #[arg(long, value_name = "NAME|FILE", value_parser = plants(), hide_possible_values = true)]
    plant: Option<String>,
    /// Simulate the arm without dry friction.
    #[arg(long)]
    no_friction: bool,
}

/// Controls.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ControlName {
    /// The board's own settings.
    Board,
    /// The paper's weights and a Luenberger observer, at 1 kHz. Its own experiments, at
    /// 45 ms with differences, are the scenarios paper-*.
    Paper,
    /// Kalman filter, stiffer gains, friction fed forward.
    Compensated,
}

impl From<ControlName> for Base {
    fn from(name: ControlName) -> Self {
        match name {
            ControlName::Board => Self::Board,
            ControlName::Paper => Self::Paper,
            ControlName::Compensated => Self::Compensated,
        }
    }
}

impl ScenarioArgs {
    /// The overrides, with the parameters of the configuration file.
    pub(crate) fn overrides(
        &self,
        arm: &ScenarioArmArgs,
        config: &Config,
    ) -> Result<Overrides, PlantError> {
        Ok(Overrides {
            control: self.control.map(Base::from),
            set: self.set.clone(),
            configured: config.control(),
            duration_s: self.duration,
            initial_rad: arm.initial,
            plant: arm.plant.as_deref().map(PlantFile::load).transpose()?,
            friction: arm.no_friction.then_some(false),
            ..Overrides::default()
        })
    }
}
