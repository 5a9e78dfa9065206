//! Scenarios: what an arm is to do, as a file that a person writes.
//!
//! ```toml
//! title = "There and back"
//! control = "compensated"        # or "paper", or "board": whatever the board has
//!
//! [set]                          # parameters by name, as `armbridge params` lists them
//! limits.speed_rad_s = [6.0, 6.0]
//!
//! [[step]]
//! at_s = 0.0
//! regulate_rad = [0.0, 0.0]
//!
//! [[step]]
//! at_s = 2.0
//! every_s = 4.0                  # again and again until the end
//! minimum_jerk = { to_rad = [0.3, 0.2], duration_s = 1.0 }
//!
//! [stop]
//! after_s = 10.0
//! angle_beyond_rad = [1.0, 1.0]
//!
//! [expect]
//! tracks_within_rad = 0.01
//! ```
//!
//! | table       | keys                                                           |
//! |-------------|----------------------------------------------------------------|
//! | top         | `title`, `about`, `control`                                    |
//! | `[set]`     | any of the board's parameters, see [`params`]   |
//! | `[[step]]`  | `at_s`, `every_s`, and one of `regulate_rad`, `torque_nm`, `minimum_jerk`, `waypoints`, `sinusoid`, `chirp`, `stream`, `experiment`, `set`, `idle`, `arm` |
//! | `[bench]`   | `seed`, `initial_rad`, `friction`, `plant_file` or `[bench.plant]`, `servos`, `baud`, `[[bench.push]]` |
//! | `[stop]`    | `after_s`, `angle_beyond_rad`, `error_beyond_rad`, `error_for_s`, `success` |
//! | `[expect]`  | see [`Expect`]                                                 |
//!
//! An experiment is written as the link carries it, see
//! [`Experiment`](armbridge_shared::link::experiment::Experiment):
//!
//! ```toml
//! [[step]]
//! at_s = 2.0
//! [step.experiment]
//! roles = ["hold", { pwm = { staircase = { from = -60, to = 90, steps = 30, dwell_s = 0.03 } } }]
//! duration_s = 5.4
//! angle_rad = [[-0.3, 0.3], [-0.8, 0.8]]    # the envelope: outside it, the experiment ends
//! speed_rad_s = [1.0, 2.0]
//! ```
//!
//! Times count in s from when the arm is armed. Arm and calibration are the board's
//! own, whatever `control` is; in the end its settings are as they were. `[bench]` is
//! for the virtual arm; a real one is not pushed.
//!
//! Every mistake is reported with file, line and column, and so is everything that a board
//! would refuse and can be known before: motions are planned by the board's planner,
//! gains judged by the board's code.

mod builtin;
mod check;
mod expect;
mod experiment;
mod file;
mod location;
mod outlook;
mod reference;
mod steps;
#[cfg(test)]
mod tests;

pub use builtin::{SHIPPED, Shipped};
pub use expect::Judge;
pub use file::{EndName, Expect};
pub use outlook::{Asked, Outlook, Stage, Swept};

use std::path::Path;

use armbridge_client::enum_names;
use armbridge_client::params;
use armbridge_client::toml_file::DocumentError;
use armbridge_shared::JOINTS;
use armbridge_shared::link::message::Settings;
use armbridge_sim::Bench;
use armbridge_sim::plant::{Plant, PlantConfig, PlantFile};
use armbridge_sim::servo_kind::ServoKind;
use toml::Value;

use crate::plan_runner::plan::Base;
use crate::plan_runner::{Ending, Plan};
use location::Text;

/// A scenario, worked out.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// Of the file, without its ending.
    pub name: String,
    /// In a few words.
    pub title: String,
    /// In some more; may be empty.
    pub about: String,
    /// What is done.
    pub plan: Plan,
    /// Settings in force meanwhile, on a board that begins with the given ones or the defaults.
    pub settings: Settings,
    /// The virtual arm.
    pub bench: BenchSpec,
    /// Ends that are as they should be.
    pub success: Vec<Success>,
    /// What the arm should do.
    pub expect: Expect,
}

/// The virtual arm of a scenario.
#[derive(Clone, Debug)]
pub struct BenchSpec {
    /// As it truly is.
    pub plant: PlantConfig,
    /// Of its encoders' noise.
    pub seed: u64,
    /// What moves it.
    pub servos: Vec<ServoKind>,
}

impl BenchSpec {
    /// At time 0.
    pub fn build(&self) -> Bench {
        Bench::with_servos(Plant::new(self.plant, self.seed), &self.servos)
    }
}

/// What the command line overrides.
#[derive(Clone, Debug, Default)]
pub struct Overrides {
    /// Control that the board's settings start from.
    pub control: Option<Base>,
    /// Parameters by name, after those of the scenario.
    pub set: Vec<(String, Value)>,
    /// Length of the run.
    pub duration_s: Option<f64>,
    /// Seed of the bench.
    pub seed: Option<u64>,
    /// Where the bench's arm is at first.
    pub initial_rad: Option<[f64; JOINTS]>,
    /// The bench's arm, in place of the scenario's.
    pub plant: Option<PlantFile>,
    /// Whether the bench's arm has dry friction.
    pub friction: Option<bool>,
    /// The bench's servos.
    pub servos: Option<Vec<ServoKind>>,
    /// Settings of the board that is to do it; without any it has the defaults.
    pub board: Option<Settings>,
}

/// An end that a scenario is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Success {
    /// Its time is over.
    Time,
    /// A joint is beyond the angle at which to stop.
    Angle,
    /// A joint is too far from its reference.
    Error,
    /// Any fault.
    Fault,
    /// The fault of this name.
    Named(&'static str),
}

impl Success {
    fn of(name: &str) -> Option<Self> {
        match name {
            "time" => Some(Self::Time),
            "angle" => Some(Self::Angle),
            "error" => Some(Self::Error),
            "fault" => Some(Self::Fault),
            _ => {
                let mut faults = enum_names::FAULTS.into_iter().map(enum_names::fault);
                faults.find(|fault| *fault == name).map(Self::Named)
            }
        }
    }

    /// Whether a run that ended so is one.
    pub fn is(self, ending: Ending) -> bool {
        match ending {
            Ending::Time => self == Self::Time,
            Ending::Angle { .. } => self == Self::Angle,
            Ending::Error { .. } => self == Self::Error,
            Ending::Fault(fault) => {
                self == Self::Fault || self == Self::Named(enum_names::fault(fault))
            }
            Ending::Interrupted => false,
        }
    }
}

/// Why there is no scenario.
#[derive(Debug, thiserror::Error)]
pub enum ScenarioError {
    /// There is neither a file of this name nor one that ships.
    #[error(
        "there is no scenario `{name}`{}: `armbridge run --list` shows those that ship, and a \
         file of your own is named by its path",
        nearest.map_or_else(String::new, |name| format!("; is it `{name}`?"))
    )]
    Unknown {
        /// As asked for.
        name: String,
        /// The one whose name is nearest.
        nearest: Option<&'static str>,
    },
    /// It cannot be read, or something in it is wrong.
    #[error(transparent)]
    File(#[from] DocumentError),
}

impl Scenario {
    /// The scenario of this path, or the one that ships under this name.
    ///
    /// # Errors
    /// See [`ScenarioError`].
    pub fn load(name: &str, overrides: &Overrides) -> Result<Self, ScenarioError> {
        let path = Path::new(name);
        let is_path = path
            .extension()
            .is_some_and(|extension| extension == "toml")
            || path.components().count() > 1;
        if let (false, Some(shipped)) = (is_path, Shipped::find(name)) {
            return Ok(Self::parse(&shipped.file(), shipped.text, overrides)?);
        }
        if !is_path && !path.exists() {
            let names = SHIPPED.iter().map(|shipped| shipped.name);
            return Err(ScenarioError::Unknown {
                name: name.into(),
                nearest: params::nearest(name, names),
            });
        }
        let text = std::fs::read_to_string(path).map_err(|source| DocumentError::Read {
            path: path.into(),
            source,
        })?;
        Ok(Self::parse(path, &text, overrides)?)
    }

    /// The scenario of this text in this file; others that it names are beside it.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn parse(file: &Path, text: &str, overrides: &Overrides) -> Result<Self, DocumentError> {
        let text = Text { file, text };
        let keys = text.parse()?;
        let name = file.file_stem().unwrap_or_default();
        check::scenario(&keys, &name.to_string_lossy(), file.parent(), overrides)
            .map_err(|wrong| text.wrong(wrong))
    }
}
