//! Trials: runs of the board's code on any virtual arm, evaluated with the true motion of
//! the arm.
//!
//! A [`Trial`] contains everything but the seed. Its [`run`](Trial::run) simulates the whole
//! bench byte by byte, and samples the true arm at every tick; an
//! [`Outcome`] has the performance figures. Equal trials with equal seeds are
//! equal to the bit, so two results differ only because their trials do.

pub(crate) mod batch;
mod maneuver;
mod outcome;
mod table;

pub use batch::{Batch, for_each, for_seeds};
pub use maneuver::{Maneuver, ManeuverError};
pub use outcome::{Joints, Outcome, REST_S};
pub use table::table;

use armbridge_board::bridge::Channels;
use armbridge_client::tap::Tapped;
use armbridge_client::{Host, Tap};
use armbridge_link::message::{Command, Record};
use armbridge_servo::JOINTS;
use armbridge_sim::Bench;
use armbridge_sim::board::VirtualBoard;
use armbridge_sim::cosim::{Cosim, CosimError};
use armbridge_sim::half_duplex_bus::Disturbance;
use armbridge_sim::plant::{Plant, PlantConfig, Push};

use crate::plan_runner::{PlanError, PlanRunner, Script};

/// A trial, without its seed.
#[derive(Clone, Debug)]
pub struct Trial {
    /// True arm.
    pub plant: PlantConfig,
    /// Set-up, commands and duration.
    pub script: Script,
    /// Pushes on the arm; times count from the first command.
    pub pushes: Vec<Push>,
    /// Fraction of the servos' replies that the master cannot read, 0 to 1.
    pub loss: f64,
}

/// Data of a run.
#[derive(Clone, Debug)]
pub struct Run {
    /// The board's records from the first command on.
    pub records: Vec<Record>,
    /// The true arm at the tick after each record, to which the record's
    /// reference belongs; missing for the last records.
    pub truth: Vec<Truth>,
    /// Commands and their times in µs.
    pub commands: Vec<(u64, Command)>,
    /// Time of the first command in µs.
    pub begun_us: u64,
}

/// True state of the arm at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// Angles in rad.
    pub angle_rad: [f64; JOINTS],
    /// Speeds in rad/s.
    pub speed_rad_s: [f64; JOINTS],
    /// Torques of the motors in N m.
    pub torque_nm: [f64; JOINTS],
}

/// Failure of a trial.
#[derive(Debug, thiserror::Error)]
pub enum TrialError {
    /// The plan runner failed.
    #[error(transparent)]
    PlanRunner(#[from] PlanError),
    /// The loss is not a fraction.
    #[error("the fraction of lost replies must be from 0 to 1, not {0}")]
    Loss(f64),
}

impl Trial {
    /// Trial without disturbances.
    pub fn new(plant: PlantConfig, script: Script) -> Self {
        Self {
            plant,
            script,
            pushes: Vec::new(),
            loss: 0.0,
        }
    }

    /// Simulates the trial.
    ///
    /// # Errors
    ///
    /// If the board refuses a command of the script, or `loss` is not from 0 to 1.
    pub fn run(&self, seed: u64) -> Result<Run, TrialError> {
        self.run_with_tap(seed, None)
    }

    /// Simulates the trial with a tap on the link.
    ///
    /// # Errors
    ///
    /// If the board refuses a command of the script, or `loss` is not from 0 to 1.
    pub fn run_with_tap(&self, seed: u64, tap: Option<Box<dyn Tap>>) -> Result<Run, TrialError> {
        let mut disturbance = match self.loss {
            0.0 => None,
            loss => Some(Disturbance::new(loss, seed).ok_or(TrialError::Loss(loss))?),
        };
        let mut channels = Channels::new();
        let board = VirtualBoard::new(channels.split()).map_err(|refusal| {
            let command = "the default set-up";
            PlanError::Refused { command, refusal }
        })?;
        let bench = Bench::new(Plant::new(self.plant, seed));
        let host = Tapped::new(
            PlanRunner::new(self.script.clone()),
            tap.into_iter().collect(),
        );
        let mut cosim = Cosim::new(board, bench, host);
        let mut begun_us = None;
        let mut truth = Vec::new();
        while !cosim.host.is_done() {
            cosim.step().map_err(|error| match error {
                CosimError::Host(error) => error,
                CosimError::Board(never) => match never {},
            })?;
            if begun_us.is_none()
                && let Some(since_us) = cosim.host.host.running_since_us()
            {
                begun_us = Some(since_us);
                self.push(&mut cosim.bench, since_us);
                if let Some(disturbance) = disturbance.take() {
                    cosim.bench.disturb(disturbance);
                }
            }
            let (records, now_us) = (cosim.host.host.records(), cosim.now_us());
            if let Some(last) = records.last()
                && records.len() > truth.len()
                && now_us >= self.next_start_us(last)
            {
                // One for each record, if the board returns several at once.
                let count = records.len();
                truth.resize(count, true_state(&mut cosim.bench, now_us));
            }
        }
        let (records, commands, _) = cosim.host.host.into_parts();
        Ok(Run {
            records,
            truth,
            commands,
            begun_us: begun_us.unwrap_or(0),
        })
    }

    fn push(&self, bench: &mut Bench, since_us: u64) {
        for push in &self.pushes {
            bench.push(Push {
                start_ns: push.start_ns + since_us * 1_000,
                ..*push
            });
        }
    }

    /// Planned start of the next tick in µs.
    fn next_start_us(&self, record: &Record) -> u64 {
        let period_us = self.script.setup.period_us;
        // A late start shortens the wait by less than a period.
        let late_us = record.timing.start_error_us % period_us.max(1);
        record.input.start_us + u64::from(period_us - late_us)
    }
}

fn true_state(bench: &mut Bench, at_us: u64) -> Truth {
    let state = bench.state_at(at_us);
    Truth {
        angle_rad: state.q.into(),
        speed_rad_s: state.dq.into(),
        torque_nm: bench.plant().torque().into(),
    }
}
