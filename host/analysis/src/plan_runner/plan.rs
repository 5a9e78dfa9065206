//! What is to be done, in every detail: settings, steps on a timeline, when to stop.

use armbridge_client::params;
use armbridge_client::params::ParameterError;
use armbridge_shared::JOINTS;
use armbridge_shared::link::message::{Command, Limits, Settings, Setup};
use armbridge_sim::plant::Push;
use toml::Value;

/// Commands at times, and nothing else: what trials and tests want done.
#[derive(Clone, Debug)]
pub struct Script {
    /// How the board shall work.
    pub setup: Setup,
    /// What to command when, in µs since the first, which is at 0.
    pub commands: Vec<(u64, Command)>,
    /// Length of the run in µs since the first command.
    pub duration_us: u64,
}

impl Script {
    /// To stand upright.
    pub fn upright(setup: Setup, duration_us: u64) -> Self {
        Self {
            setup,
            commands: vec![(0, Command::Regulate([0.0; JOINTS]))],
            duration_us,
        }
    }

    /// Upright, then two setpoints nearby: at 40 % and at 70 % of the run.
    pub fn demo(setup: Setup, duration_us: u64) -> Self {
        let setpoints = [
            (0, [0.0, 0.0]),
            (duration_us * 4 / 10, [0.15, 0.10]),
            (duration_us * 7 / 10, [-0.10, -0.15]),
        ];
        Self {
            setup,
            commands: setpoints
                .map(|(at_us, q)| (at_us, Command::Regulate(q)))
                .into(),
            duration_us,
        }
    }
}

/// A run, in every detail.
#[derive(Clone, Debug)]
pub struct Plan {
    /// How the board is to work, from before it is armed.
    pub begin: Begin,
    /// In order of time.
    pub steps: Vec<Step>,
    /// Pushes on the bench's arm; times count from the first step.
    pub pushes: Vec<Push>,
    /// When the run is over.
    pub stop: Stop,
    /// A fault that is latched before is cleared.
    pub is_clearing: bool,
    /// In the end, stock servos get back the mode and return delay they were found
    /// with, and the transparent port has the bus.
    pub is_releasing: bool,
}

/// How the board is to work.
#[derive(Clone, Debug)]
pub enum Begin {
    /// Like this. It is left so.
    With(Box<Setup>),
    /// As it does, but for this. In the end it is as it was.
    Changed(Change),
}

/// Something at a time.
#[derive(Clone, Debug)]
pub struct Step {
    /// In µs since the run began.
    pub at_us: u64,
    /// What.
    pub act: Act,
}

/// What can be done in a step.
#[derive(Clone, Debug)]
pub enum Act {
    /// A command that depends on nothing.
    Tell(Box<Command>),
    /// Arm again.
    Arm,
    /// Settings are changed while the arm moves.
    Change(Change),
    /// Points are sent ahead of their times.
    Stream(Vec<Point>),
}

/// Where the arm shall be at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// In µs since the step.
    pub after_us: u64,
    /// In rad.
    pub angle_rad: [f32; JOINTS],
    /// In rad/s; `None` to have it made of the neighbours.
    pub speed_rad_s: Option<[f32; JOINTS]>,
}

/// When a run is over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// In µs since the run began.
    pub after_us: u64,
    /// As soon as an estimated angle is beyond this, in rad.
    pub angle_rad: Option<[f32; JOINTS]>,
    /// As soon as the estimate is so far from the reference, in rad, while there is
    /// one.
    pub error_rad: Option<[f32; JOINTS]>,
    /// For so long, in µs.
    pub error_for_us: u64,
}

impl Stop {
    /// After so long.
    pub fn after(after_us: u64) -> Self {
        Self {
            after_us,
            angle_rad: None,
            error_rad: None,
            error_for_us: 0,
        }
    }
}

/// Which control a change starts from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Base {
    /// The board's own.
    #[default]
    Board,
    /// The paper's weights and an observer: [`Setup::default`].
    Paper,
    /// Kalman filter, stiffer gains, friction fed forward: [`Setup::best`].
    Compensated,
}

/// A change of the board's settings. Arm and calibration stay the board's unless they
/// are changed by name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Change {
    /// Controller, estimator, friction and period.
    pub base: Base,
    /// Parameters by name, see [`params`], in order.
    pub set: Vec<(String, Value)>,
}

impl Change {
    /// The settings, changed.
    ///
    /// # Errors
    /// If there is no such parameter, or it does not take the value.
    pub fn apply(&self, settings: &Settings) -> Result<Settings, ParameterError> {
        let mut settings = *settings;
        let own = settings.setup;
        let control = match self.base {
            Base::Board => own,
            Base::Paper => Setup::default(),
            Base::Compensated => Setup::best(),
        };
        settings.setup = Setup {
            arm: own.arm,
            joints: own.joints,
            ..control
        };
        let set = self.set.iter().map(|(key, value)| (key.as_str(), value));
        params::apply(&mut settings, set)?;
        Ok(settings)
    }
}

impl From<Script> for Plan {
    fn from(script: Script) -> Self {
        let steps = script.commands.into_iter().map(|(at_us, command)| Step {
            at_us,
            act: Act::Tell(Box::new(command)),
        });
        Self {
            begin: Begin::With(Box::new(script.setup)),
            steps: steps.collect(),
            pushes: Vec::new(),
            stop: Stop::after(script.duration_us),
            is_clearing: false,
            is_releasing: false,
        }
    }
}

/// The commands that make a board work with `wanted`, one that works with `present`.
pub(super) fn differences(present: &Settings, wanted: &Settings) -> Vec<Command> {
    let limits: Option<&Limits> = (present.limits != wanted.limits).then_some(&wanted.limits);
    let setup: Option<&Setup> = (present.setup != wanted.setup).then_some(&wanted.setup);
    limits
        .map(|limits| Command::Limit(*limits))
        .into_iter()
        .chain(setup.map(|setup| Command::Configure(*setup)))
        .collect()
}
