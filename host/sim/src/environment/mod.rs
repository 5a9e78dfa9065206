//! Environments for learned controllers: an arm, the board's code between it and the policy, a
//! task.
//!
//! ```text
//! policy --action--> command --> board --> PWM --> arm      one step of the environment:
//!    ^                                              |       a command, then so many ticks
//!    `--observation, reward-- task <-- estimate <---'
//! ```
//!
//! An action is a command to the board, and acts through its limits and monitors, always. The
//! board is simulated in one of two modes:
//!
//! | mode               | board                          | servos and wire                       |
//! |--------------------|--------------------------------|---------------------------------------|
//! | [`Mode::Exact`]    | whole, behind its link         | byte for byte, see [`cosim`](crate::cosim) |
//! | [`Mode::Fast`]     | [`step`](armbridge_board::tick::step) alone | two constant delays, see [`fast`] |
//!
//! or connected, real or served, see `connected`. An episode begins with the arm at rest at a
//! posture drawn by the task, the board armed and the estimate settled; the first step lets go of
//! it. It ends when the task does, or when the board has switched torque off. Equal seeds and
//! actions give equal episodes of a simulated board, to the bit.
//!
//! | module      | contents                                              |
//! |-------------|-------------------------------------------------------|
//! | [`exact`]   | the board in [`Mode::Exact`]                          |
//! | [`fast`]    | the board in [`Mode::Fast`]                           |
//! | `connected` | a board at a link                                     |
//! | `action`    | actions as commands                                   |
//! | [`task`]    | start, observation, reward and end                    |
//! | [`batch`]   | many environments at once, on all processors          |

mod action;
pub mod batch;
mod connected;
pub mod exact;
pub mod fast;
pub mod task;
#[cfg(test)]
mod tests;

pub use action::ActionKind;
pub use task::Task;

use std::sync::Arc;

use armbridge_board::tick::LoopConfig;
use armbridge_client::refusal_text;
use armbridge_control::arm::State;
use armbridge_link::message::{Fault, Record, Refusal, Settings};
use armbridge_servo::JOINTS;
use rand_distr::{Distribution, StandardUniform};
use rand_pcg::Pcg32;

use crate::link::{BoardClient, ClientError};
use crate::plant::PlantConfig;
use connected::ConnectedBoard;
use exact::{ExactBoard, ExactError};
use fast::FastBoard;

/// Stream of the generator; the encoders' noise, faults, campaigns and drawn arms use 0 to 7.
const STREAM: u64 = 8;

/// Simulation of board, wire and servos.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Byte for byte.
    Exact,
    /// The tick alone, with constant delays.
    Fast,
}

/// A tick as the policy sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation {
    /// Estimated angles in rad.
    pub angle_rad: [f32; JOINTS],
    /// Estimated speeds in rad/s.
    pub speed_rad_s: [f32; JOINTS],
    /// Torque that has been decided, in N m.
    pub torque_nm: [f32; JOINTS],
    /// Its PWM.
    pub pwm: [u16; JOINTS],
    /// Fault that has switched the motors off.
    pub fault: Option<Fault>,
    /// Whether the motors are driven.
    pub is_driven: bool,
}

impl From<&Record> for Observation {
    fn from(record: &Record) -> Self {
        let output = &record.output;
        Self {
            angle_rad: output.angle_rad,
            speed_rad_s: output.speed_rad_s,
            torque_nm: output.torque_nm,
            pwm: output.pwm,
            fault: match record.mode {
                armbridge_link::message::Mode::Fault(fault) => Some(fault),
                _ => None,
            },
            is_driven: record.mode.drive().is_some(),
        }
    }
}

/// Description of an environment.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// Task.
    pub task: Task,
    /// Simulation of the board.
    pub mode: Mode,
    /// Meaning of actions.
    pub action: ActionKind,
    /// Settings of the board.
    pub settings: Settings,
    /// Virtual arms, of which each episode has one, drawn with equal probability.
    pub plants: Vec<PlantConfig>,
    /// Ticks of a step.
    pub ticks_per_step: u32,
    /// Steps after which an episode is truncated.
    pub steps_max: u32,
}

/// Why an environment does not exist, or cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum EnvironmentError {
    /// No virtual arm.
    #[error("an environment needs at least one virtual arm")]
    NoPlant,
    /// A step without ticks, or one after which the board no longer obeys.
    #[error(
        "a step of {ticks} ticks is out of range: expected 1 to {most}, after which the board \
         takes a command as expired"
    )]
    Ticks {
        /// Requested.
        ticks: u32,
        /// Most.
        most: u32,
    },
    /// An action that is not a number.
    #[error("expected finite actions, got {0:?}")]
    Action([f64; JOINTS]),
    /// No episode has begun.
    #[error("call reset before step: no episode is under way")]
    NotReset,
    /// More than one environment on a connected board.
    #[error("a connected board is one environment; many at once are simulated")]
    OneBoard,
    /// The board cannot have these settings.
    #[error("the board refuses these settings: {}", refusal_text::in_words(*.0))]
    Settings(Refusal),
    /// The simulated board does not come up.
    #[error(transparent)]
    Exact(#[from] ExactError),
    /// The connected board refuses, does not answer, or has gone.
    #[error(transparent)]
    Client(#[from] ClientError),
}

/// Result of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transition {
    /// The last tick.
    pub observation: Observation,
    /// Reward.
    pub reward: f64,
    /// The task has ended, or the board has switched torque off.
    pub is_terminated: bool,
    /// The episode has had all of its steps.
    pub is_truncated: bool,
}

#[derive(Debug)]
enum Board {
    Exact(Box<ExactBoard>),
    Fast(Box<FastBoard>),
    Connected(ConnectedBoard),
}

/// An environment.
#[derive(Debug)]
pub struct Environment {
    description: Description,
    config: LoopConfig,
    random: Pcg32,
    target_rad: [f64; JOINTS],
    board: Option<Board>,
    observation: Option<Observation>,
    steps: u32,
}

impl Environment {
    /// An environment before its first episode.
    ///
    /// # Errors
    /// If the description contradicts itself, or no board can have its settings.
    pub fn new(description: Description) -> Result<Self, EnvironmentError> {
        let config =
            LoopConfig::build(&description.settings).map_err(EnvironmentError::Settings)?;
        if description.plants.is_empty() {
            return Err(EnvironmentError::NoPlant);
        }
        let limits = &description.settings.limits;
        let age_us = 1_000 * u32::from(limits.torque_age_ms.min(limits.hold_ms));
        // The last tick of a step still obeys its command.
        let most = (age_us / config.period_us()).saturating_sub(1);
        let ticks = description.ticks_per_step;
        if !(1..=most).contains(&ticks) {
            return Err(EnvironmentError::Ticks { ticks, most });
        }
        Ok(Self::before_first_episode(description, &config))
    }

    fn before_first_episode(description: Description, config: &LoopConfig) -> Self {
        Self {
            description,
            config: *config,
            random: Pcg32::new(0, STREAM),
            target_rad: [0.0; JOINTS],
            board: None,
            observation: None,
            steps: 0,
        }
    }

    /// Another environment of this description, before its first episode.
    ///
    /// # Errors
    /// If this one is on a connected board.
    pub fn another(&self) -> Result<Self, EnvironmentError> {
        match self.board {
            Some(Board::Connected(_)) => Err(EnvironmentError::OneBoard),
            _ => Ok(Self::before_first_episode(
                self.description.clone(),
                &self.config,
            )),
        }
    }

    /// An environment on a connected board with its own settings; mode and arms of the description
    /// are without effect.
    ///
    /// # Errors
    /// If the description contradicts the settings of the board.
    pub fn on_board(
        client: Arc<BoardClient>,
        description: &Description,
    ) -> Result<Self, EnvironmentError> {
        let environment = Self::new(Description {
            settings: client.status().settings.unwrap_or_default(),
            plants: vec![PlantConfig::default()],
            ..*description
        })?;
        Ok(Self {
            board: Some(Board::Connected(ConnectedBoard::new(client))),
            ..environment
        })
    }

    /// Its description.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// Target of the present episode, in rad.
    pub fn target_rad(&self) -> [f64; JOINTS] {
        self.target_rad
    }

    /// The last tick of the present episode.
    pub fn observation(&self) -> Option<&Observation> {
        self.observation.as_ref()
    }

    /// True state of a simulated arm in the present episode.
    pub fn true_state(&self) -> Option<State<f64>> {
        match self.board.as_ref()? {
            Board::Exact(board) => Some(board.true_state()),
            Board::Fast(board) => Some(board.true_state()),
            Board::Connected(_) => None,
        }
    }

    /// Seeds the generator of the next episodes.
    pub fn seed(&mut self, seed: u64) {
        self.random = Pcg32::new(seed, STREAM);
    }

    /// Begins an episode.
    ///
    /// # Errors
    /// If the board cannot be armed.
    pub fn reset(&mut self) -> Result<Observation, EnvironmentError> {
        let Self {
            description,
            random,
            ..
        } = self;
        let draw: u32 = StandardUniform.sample(random);
        let plant = description.plants[draw as usize % description.plants.len()];
        let episode = description.task.draw(random);
        let noise: u64 = StandardUniform.sample(random);
        let plant = PlantConfig {
            initial: State::at_rest(episode.start_rad.into()),
            held: true,
            ..plant
        };
        let settings = &description.settings;
        self.observation = None;
        let (board, observation) = match (self.board.take(), description.mode) {
            (Some(Board::Connected(mut board)), _) => {
                let observation = board.reset(episode.start_rad);
                (Board::Connected(board), observation)
            }
            (_, Mode::Fast) => {
                let (board, observation) = FastBoard::new(&self.config, plant, noise);
                (Board::Fast(Box::new(board)), Ok(observation))
            }
            (_, Mode::Exact) => {
                let (board, observation) = ExactBoard::new(settings, plant, noise)?;
                (Board::Exact(Box::new(board)), Ok(observation))
            }
        };
        self.board = Some(board);
        let observation = observation?;
        self.target_rad = episode.target_rad;
        self.observation = Some(observation);
        self.steps = 0;
        Ok(observation)
    }

    /// Runs a step with this action, see [`ActionKind`].
    ///
    /// # Errors
    /// If the action is not a number, or no episode is under way.
    pub fn step(&mut self, action: [f64; JOINTS]) -> Result<Transition, EnvironmentError> {
        let Description {
            task,
            action: kind,
            ref settings,
            ticks_per_step,
            steps_max,
            ..
        } = self.description;
        if !action.iter().all(|value| value.is_finite()) {
            return Err(EnvironmentError::Action(action));
        }
        let (Some(board), Some(_)) = (&mut self.board, self.observation) else {
            return Err(EnvironmentError::NotReset);
        };
        let command = kind.command(action, settings);
        let observation = match board {
            Board::Connected(board) => board.advance(command, ticks_per_step)?,
            Board::Fast(board) => board.advance(&command, ticks_per_step),
            Board::Exact(board) => board.advance(command, ticks_per_step)?,
        };
        self.observation = Some(observation);
        self.steps += 1;
        let (reward, has_ended) = task.evaluate(&observation, self.target_rad, &settings.limits);
        Ok(Transition {
            observation,
            reward,
            is_terminated: has_ended || !observation.is_driven,
            is_truncated: self.steps >= steps_max,
        })
    }
}
