//! Scenarios: hand-written files that describe a run.
//!
//! ```toml
//! title = "There and back"
//! control = "compensated"        # or "paper", or "board": the board's own control
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
//! every_s = 4.0                  # repeated until the end
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
//! [`KEYS`] has every key with its range and meaning: it checks the file and explains it.
//!
//! An experiment is written as the link carries it, see
//! [`Experiment`](armbridge_link::experiment::Experiment):
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
//! Times are in s since the arm was armed. Arm and calibration are the board's
//! own, whatever `control` is; at the end its settings are restored. `[bench]` is
//! for the virtual arm; a real one is neither pushed nor led.
//!
//! Every mistake is reported with file, line and column, as is everything that a board
//! would predictably refuse: motions are planned by the board's planner and gains checked
//! by the board's code.

mod builtin;
mod check;
mod expectation;
mod experiment;
mod file;
mod keys;
mod leads;
mod mistake;
mod motion;
mod narrowing;
mod preview;
mod reference;
mod simulated_board;
mod stay;
mod steps;
#[cfg(test)]
mod tests;

pub use builtin::{BUILTINS, Builtin};
pub use expectation::ExpectationMonitor;
pub use file::{EndName, Expect};
pub use keys::KEYS;
pub use preview::{JointPreview, Preview, ReferencePoint, Stage};

use std::path::{Path, PathBuf};

use armbridge_client::params;
use armbridge_client::toml_file::{self, DocumentError};
use armbridge_link::message::{Fault, Settings};
use armbridge_log::run_info::RunFacts;
use armbridge_servo::{Firmware, JOINTS};
use armbridge_sim::Bench;
use armbridge_sim::plant::{Plant, PlantConfig, PlantFile};
use armbridge_sim::servo_kind::ServoKind;
use toml::Value;

use crate::plan_runner::plan::Base;
use crate::plan_runner::{Ending, Plan};
use mistake::Text;

/// A checked scenario.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// Name of the file without extension.
    pub name: String,
    /// Title.
    pub title: String,
    /// Description; may be empty.
    pub about: String,
    /// Plan of the run.
    pub plan: Plan,
    /// Settings during the run, on a board that begins with the given ones or the defaults.
    pub settings: Settings,
    /// Control of a second run on the same simulated arm, for comparison.
    pub baseline: Option<Base>,
    /// The virtual arm.
    pub bench: BenchSpec,
    /// Ends that count as success.
    pub success: Vec<Success>,
    /// Expectations of the arm.
    pub expect: Expect,
    /// Remarks before the run begins, one line each.
    pub notes: Vec<String>,
}

/// The virtual arm of a scenario.
#[derive(Clone, Debug)]
pub struct BenchSpec {
    /// True arm.
    pub plant: PlantConfig,
    /// Seed of the encoders' noise.
    pub seed: u64,
    /// Servos.
    pub servos: Vec<ServoKind>,
}

impl BenchSpec {
    /// Builds the bench at time 0.
    pub fn build(&self) -> Bench {
        Bench::with_servos(Plant::new(self.plant, self.seed), &self.servos)
    }
}

/// Overrides from the command line.
#[derive(Clone, Debug, Default)]
pub struct Overrides {
    /// Control settings that the board's settings start from.
    pub control: Option<Base>,
    /// Parameters by name, applied after those of the scenario.
    pub set: Vec<(String, Value)>,
    /// Parameters of the configuration file, applied before those of the scenario if the
    /// control is the board's own.
    pub configured: Vec<(String, Value)>,
    /// Duration of the run.
    pub duration_s: Option<f64>,
    /// Seed of the bench.
    pub seed: Option<u64>,
    /// Initial angles of the bench's arm.
    pub initial_rad: Option<[f64; JOINTS]>,
    /// The bench's arm instead of the scenario's.
    pub plant: Option<PlantFile>,
    /// Whether the bench's arm has dry friction.
    pub friction: Option<bool>,
    /// Firmware of the bench's servos instead of the scenario's, or of those whose encoders the arm
    /// has.
    pub firmware: Option<[Firmware; JOINTS]>,
    /// Baud rate stored in them.
    pub servo_baud: Option<u32>,
    /// Settings of the board; `None` for the defaults.
    pub board: Option<Settings>,
    /// Speed of a motion, relative to that of its file.
    pub speed: Option<f64>,
    /// Number of times that a motion is performed.
    pub repeats: Option<u32>,
}

/// An end of a run that counts as success.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Success {
    /// The duration elapses.
    Time,
    /// A joint exceeds the stop angle.
    Angle,
    /// A joint is too far from its reference.
    Error,
    /// Any fault.
    Fault,
    /// The fault with this name.
    Named(&'static str),
}

impl Success {
    fn from_name(name: &str) -> Option<Self> {
        match name {
            "time" => Some(Self::Time),
            "angle" => Some(Self::Angle),
            "error" => Some(Self::Error),
            "fault" => Some(Self::Fault),
            _ => {
                let mut faults = Fault::ALL.into_iter().map(Fault::name);
                faults.find(|fault| *fault == name).map(Self::Named)
            }
        }
    }

    /// Name in scenario files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Angle => "angle",
            Self::Error => "error",
            Self::Fault => "fault",
            Self::Named(name) => name,
        }
    }

    /// Whether an end of a run counts as this success.
    pub fn matches(self, ending: Ending) -> bool {
        match ending {
            Ending::Time => self == Self::Time,
            Ending::Angle { .. } => self == Self::Angle,
            Ending::Error { .. } => self == Self::Error,
            Ending::Fault(fault) => self == Self::Fault || self == Self::Named(fault.name()),
            Ending::Interrupted => false,
        }
    }
}

/// Failure to load a scenario.
#[derive(Debug, thiserror::Error)]
pub enum ScenarioError {
    /// There is neither a file nor a built-in scenario with this name.
    #[error(
        "there is no scenario `{name}`{}: `armbridge run --list` shows the built-in ones; name a \
         file of your own by its path",
        nearest.map_or_else(String::new, |name| format!("; is it `{name}`?"))
    )]
    Unknown {
        /// Requested name.
        name: String,
        /// The nearest built-in name.
        nearest: Option<&'static str>,
    },
    /// The file cannot be read or contains a mistake.
    #[error(transparent)]
    File(#[from] DocumentError),
    /// An option of the command line has a value that is not permitted.
    #[error("{option}: {message}")]
    Option {
        /// The option.
        option: &'static str,
        /// Why it is not.
        message: String,
    },
}

/// Text of a scenario: read once, and parsed with any overrides.
#[derive(Clone, Debug)]
pub struct ScenarioText {
    file: PathBuf,
    text: String,
}

impl ScenarioText {
    /// Reads the file with this path, the built-in scenario with this name, or standard
    /// input for `-`.
    ///
    /// # Errors
    /// If there is no such scenario, or it cannot be read.
    pub fn read(name: &str) -> Result<Self, ScenarioError> {
        let path = Path::new(name);
        if name == "-" {
            let file = Path::new("stdin");
            return Ok(Self {
                file: file.into(),
                text: toml_file::read_text(file, Ok(std::io::stdin()), toml_file::TEXT_MAX)?,
            });
        }
        let is_motion = path
            .extension()
            .is_some_and(|extension| extension == motion::EXTENSION);
        let is_path = is_motion
            || path
                .extension()
                .is_some_and(|extension| extension == "toml")
            || path.components().count() > 1;
        if let (false, Some(builtin)) = (is_path, Builtin::find(name)) {
            return Ok(Self {
                file: builtin.file(),
                text: builtin.text.into(),
            });
        }
        if !is_path && !path.exists() {
            let names = BUILTINS.iter().map(|builtin| builtin.name);
            return Err(ScenarioError::Unknown {
                name: name.into(),
                nearest: params::nearest(name, names),
            });
        }
        let bytes_max = if is_motion {
            motion::TEXT_MAX
        } else {
            toml_file::TEXT_MAX
        };
        Ok(Self {
            file: path.into(),
            text: toml_file::read_file(path, bytes_max)?,
        })
    }

    /// The scenario with these overrides.
    ///
    /// # Errors
    /// The first mistake.
    pub fn scenario(&self, overrides: &Overrides) -> Result<Scenario, ScenarioError> {
        Scenario::parse(&self.file, &self.text, overrides)
    }
}

impl Scenario {
    /// Loads the scenario with this name, see [`ScenarioText::read`].
    ///
    /// # Errors
    /// See [`ScenarioError`].
    pub fn load(name: &str, overrides: &Overrides) -> Result<Self, ScenarioError> {
        ScenarioText::read(name)?.scenario(overrides)
    }

    /// Facts of a run of this scenario on its virtual arm.
    pub fn simulated_facts(&self, world: &str) -> RunFacts {
        RunFacts::from_settings(&self.name, world, &self.settings)
            .simulated(self.bench.seed, self.bench.plant.static_friction_nm())
    }

    /// Parses the text of a file; other files that it names are in the same folder. A file
    /// that ends in `.csv` is a [`motion`].
    ///
    /// # Errors
    /// The first mistake.
    pub fn parse(file: &Path, text: &str, overrides: &Overrides) -> Result<Self, ScenarioError> {
        let name = file.file_stem().unwrap_or_default().to_string_lossy();
        let text = Text { file, text };
        if file
            .extension()
            .is_some_and(|extension| extension == motion::EXTENSION)
        {
            return motion::scenario(text, &name, overrides);
        }
        for (option, is_given) in [
            ("--speed", overrides.speed.is_some()),
            ("--repeat", overrides.repeats.is_some()),
        ] {
            if is_given {
                let message = format!("{option} is for motions, files that end in .csv");
                return Err(text.error(0, message).into());
            }
        }
        let keys = text.parse()?;
        check::scenario(&keys, &name, file.parent(), overrides)
            .map_err(|wrong| wrong.located(|mistake| text.locate(mistake)))
    }
}
