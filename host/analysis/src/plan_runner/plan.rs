//! Plan of a run: settings, steps on a timeline, and stop conditions.

use armbridge_client::params;
use armbridge_client::params::ParameterError;
use armbridge_link::message::{Command, Limits, Settings, Setup};
use armbridge_servo::JOINTS;
use armbridge_sim::plant::{Lead, Push};
use toml::Value;

/// Timed commands alone, for trials and tests of an arm whose motors have been checked.
#[derive(Clone, Debug)]
pub struct Script {
    /// Set-up of the board.
    pub setup: Setup,
    /// Limits of the board.
    pub limits: Limits,
    /// Commands with their times in µs since the first, which is at 0.
    pub commands: Vec<(u64, Command)>,
    /// Length of the run in µs since the first command.
    pub duration_us: u64,
}

impl Script {
    /// The default limits, without a check of the motors.
    pub fn limits() -> Limits {
        Limits {
            check_rad_s2: 0,
            ..Limits::default()
        }
    }

    /// Script that holds the arm upright.
    pub fn upright(setup: Setup, duration_us: u64) -> Self {
        Self {
            setup,
            limits: Self::limits(),
            commands: vec![(0, Command::Regulate([0.0; JOINTS]))],
            duration_us,
        }
    }

    /// Script that holds the arm upright, then at two nearby setpoints from 40 % and 70 % of
    /// the run.
    pub fn demo(setup: Setup, duration_us: u64) -> Self {
        let setpoints = [
            (0, [0.0, 0.0]),
            (duration_us * 4 / 10, [0.15, 0.10]),
            (duration_us * 7 / 10, [-0.10, -0.15]),
        ];
        Self {
            setup,
            limits: Self::limits(),
            commands: setpoints
                .map(|(at_us, q)| (at_us, Command::Regulate(q)))
                .into(),
            duration_us,
        }
    }
}

/// Complete plan of a run.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Settings of the board from before it is armed.
    pub begin: InitialSettings,
    /// Steps in order of time.
    pub steps: Vec<Step>,
    /// Pushes on the simulated arm; times count from the first step.
    pub pushes: Vec<Push>,
    /// Hands that lead the simulated arm; times count from the first step.
    pub leads: Vec<Lead>,
    /// Stop conditions.
    pub stop: Stop,
    /// A latched fault is cleared first.
    pub is_clearing: bool,
    /// At the end, stock servos get back their original mode and return delay, and the
    /// transparent port has the bus.
    pub is_releasing: bool,
}

/// Settings of the board in a run.
#[derive(Clone, Debug)]
pub enum InitialSettings {
    /// These settings, which remain after the run.
    Fixed(Box<Settings>),
    /// The board's own settings with a change, restored after the run.
    Changed(Change),
}

/// A timed action.
#[derive(Clone, Debug)]
pub struct Step {
    /// Time in µs since the run began.
    pub at_us: u64,
    /// Action.
    pub action: Action,
}

/// Action of a step.
#[derive(Clone, Debug)]
pub enum Action {
    /// Sends a command.
    Command(Box<Command>),
    /// Arms again.
    Arm,
    /// Changes settings while the arm moves.
    Change(Change),
    /// Sends points ahead of their times.
    Stream(Vec<Point>),
}

/// Points of a stream sent ahead of time, of the eight that the board holds: the
/// reference is interpolated between neighbours, and the link may be delayed.
pub(crate) const STREAM_AHEAD: usize = 5;

/// Point of a streamed reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Time in µs since the step.
    pub after_us: u64,
    /// Angles in rad.
    pub angle_rad: [f32; JOINTS],
    /// Speeds in rad/s; `None` to compute them from the neighbours.
    pub speed_rad_s: Option<[f32; JOINTS]>,
}

/// Stop conditions of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// Duration in µs.
    pub after_us: u64,
    /// Largest estimated angles in rad.
    pub angle_rad: Option<[f32; JOINTS]>,
    /// Largest errors of the estimate in rad, while there is a reference.
    pub error_rad: Option<[f32; JOINTS]>,
    /// Duration of an excessive error that ends the run, in µs.
    pub error_for_us: u64,
}

impl Stop {
    /// Stop after a duration alone.
    pub fn after(after_us: u64) -> Self {
        Self {
            after_us,
            angle_rad: None,
            error_rad: None,
            error_for_us: 0,
        }
    }
}

/// Control settings that a change starts from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Base {
    /// The board's own.
    #[default]
    Board,
    /// The paper's weights and an observer: [`Setup::default`].
    Paper,
    /// Kalman filter, stiffer gains, friction feed-forward: [`Setup::best`].
    Compensated,
}

impl Base {
    /// The one with this name, as a scenario's `control`.
    pub fn from_name(name: &str) -> Option<Self> {
        match name {
            "board" => Some(Self::Board),
            "paper" => Some(Self::Paper),
            "compensated" => Some(Self::Compensated),
            _ => None,
        }
    }
}

/// Change of the board's settings. Arm and calibration remain the board's unless they
/// are changed by name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Change {
    /// Controller, estimator, friction and period.
    pub base: Base,
    /// Parameters by name, see [`params`]: groups that are applied one after the other, so
    /// that a later one may select another kind of controller.
    pub groups: Vec<Vec<(String, Value)>>,
}

impl Change {
    /// Applies the change to settings.
    ///
    /// # Errors
    /// If a parameter does not exist or rejects its value.
    pub fn apply(&self, settings: &Settings) -> Result<Settings, ParameterError> {
        let mut settings = *settings;
        let own = settings.setup;
        let control = match self.base {
            Base::Board => own,
            Base::Paper => Setup::default(),
            Base::Compensated => Setup::best(),
        };
        settings.setup = control.with_arm_of(&own);
        for group in &self.groups {
            let pairs = group.iter().map(|(key, value)| (key.as_str(), value));
            params::apply(&mut settings, pairs)?;
        }
        Ok(settings)
    }
}

impl From<Script> for Plan {
    fn from(script: Script) -> Self {
        let steps = script.commands.into_iter().map(|(at_us, command)| Step {
            at_us,
            action: Action::Command(Box::new(command)),
        });
        let settings = Settings {
            setup: script.setup,
            limits: script.limits,
        };
        Self {
            begin: InitialSettings::Fixed(Box::new(settings)),
            steps: steps.collect(),
            pushes: Vec::new(),
            leads: Vec::new(),
            stop: Stop::after(script.duration_us),
            is_clearing: false,
            is_releasing: false,
        }
    }
}

/// Commands that change a board's settings from `present` to `target`.
pub(super) fn differences(present: &Settings, target: &Settings) -> Vec<Command> {
    let limits: Option<&Limits> = (present.limits != target.limits).then_some(&target.limits);
    let setup: Option<&Setup> = (present.setup != target.setup).then_some(&target.setup);
    limits
        .map(|limits| Command::Limit(*limits))
        .into_iter()
        .chain(setup.map(|setup| Command::Configure(*setup)))
        .collect()
}
