//! The control loop: what a tick decides, as a value in and a value out.
//!
//! ```text
//!             samples, permission, time                     command, estimate,
//!             TickInput                                     reference, fault
//!                |                                          TickOutput
//!                v                                             ^
//!   estimator -> monitors -> prediction -> reference -> controller -> limits -> PWM
//!                   |           to the      source, or                  |
//!                   |         next tick     experiment                  |
//!                   +------------- Violation: command OFF --------------+
//! ```
//!
//! [`ControlLoop::step`] owns estimate, monitors, reference source and experiment, and
//! nothing else: no bus, no queue, no record, no clock. Board, bench, emulator and
//! replay call it; equal inputs give equal outputs, to the bit.
//!
//! # Contract
//!
//! * Call [`step`](ControlLoop::step) once a tick, when the samples are in. What it
//!   returns is sent at the beginning of the next tick, so a torque acts one period
//!   after the samples that it was decided from, always; the prediction accounts for it.
//! * The motors are driven only under [`Permission::Drive`]. Any fault, and any other
//!   permission, make the command [`ActuatorCommand::OFF`].
//! * The configuration is immutable between ticks and replaced as a whole
//!   ([`install`](ControlLoop::install)); the loop keeps none of its numbers.
//! * Angles in rad, speeds in rad/s, torques in N m, times in µs of a clock that never
//!   goes back.
//!
//! What follows from a fault, who may drive and when motors are seen to be off is not
//! decided here: that is for the [`supervisor`](crate::supervisor) and the bus.
//!
//! # Example
//!
//! The loop closed around an arm, and nothing else:
//!
//! ```
//! use armbridge_shared::actuator::Joint;
//! use armbridge_shared::arm::{Parameters, State};
//! use armbridge_shared::control_loop::{ControlLoop, Instant, LoopConfig, Permission, TickInput};
//! use armbridge_shared::link::message::{Sample, Settings};
//! use nalgebra::Vector2;
//!
//! let config = LoopConfig::build(&Settings::default()).unwrap();
//! let (arm, servo) = (Parameters::<f32>::paper(), Joint::<f32>::paper());
//! let mut plant = State::at_rest(Vector2::new(0.2, -0.1));
//! let (mut control, mut input) = (ControlLoop::new(&config), TickInput::AT_REST);
//! control.regulate(&config, [0.0, 0.0], Instant::default());
//! for tick in 1..=2_000 {
//!     input.samples = [plant.q.x, plant.q.y].map(|q| Sample::Counts(servo.position(q) as u16));
//!     (input.acts_us, input.permission) = (tick * 1_000, Permission::Drive);
//!     let torque = input.in_force.total_nm();
//!     input.in_force = control.step(&config, &input).command;
//!     plant.dq += arm.acceleration(&plant, torque) * 1e-3;
//!     plant.q += plant.dq * 1e-3;
//! }
//! assert!(plant.q.amax() < 0.02, "it stands at {}", plant.q);
//! ```
//!
//! | module         | what                                                     |
//! |----------------|----------------------------------------------------------|
//! | [`LoopConfig`] | what a tick computes with, under check words             |
//! | `commands`     | what drives the motors is replaced, without a jump       |
//! | `drive_command` | what drives the motors, and since when                  |
//! | `tick`         | inputs and outputs                                       |
//! | `time_out`     | a silent host, and commands that are too old             |
//! | `pipeline`     | from state and reference to PWM                          |
//! | `monitors`     | what is detected, what is limited                        |
//! | [`mod@reference`] | where the reference comes from                        |
//! | `experiment`   | experiments, from admission to the end                   |
//! | [`limits`]     | numbers that no host can set                             |

mod commands;
mod config;
mod drive_command;
mod experiment;
pub mod limits;
mod monitors;
mod pipeline;
pub mod reference;
mod tick;
mod time_out;

pub use config::{CHECK_US, ControlConfig, LoopConfig, can_run, why_not};
pub use experiment::permits;
pub use monitors::Violation;
pub use pipeline::ActuatorCommand;
pub use tick::{Fallback, Instant, Permission, TickInput, TickOutput};

use crate::JOINTS;
use crate::arm::{Posture, State};
use crate::control::Reference;
use crate::estimate::Estimate;
use crate::flow_token::Machine;
use crate::link::message::{Drive, Fault, Guards, Sample};
use crate::servo::protocol1::Alarms;
use drive_command::DriveCommand;
use experiment::ActiveExperiment;
use monitors::{MonitorInput, Monitors};
use nalgebra::Vector2;
use pipeline::{Demand, FeedForward};
use reference::ReferenceSource;
use tick::Verdict;

/// Alarms upon which a stock servo, as it comes, lets go of its shaft.
const SHUTDOWN: Alarms = Alarms::OVERHEATING.or(Alarms::OVERLOAD);

/// The state of the control loop, see the [module](self).
#[derive(Clone, Debug)]
pub struct ControlLoop {
    estimate: Estimate<f32>,
    /// The estimator has not seen a sample since it was last in doubt.
    is_fresh: bool,
    monitors: Monitors,
    /// What drives the motors while that is permitted.
    commanded: DriveCommand,
    source: ReferenceSource,
    /// Of [`Drive::Experiment`].
    experiment: ActiveExperiment,
    /// What is still added to the torque since the set-up was replaced.
    bump_nm: Vector2<f32>,
    feed_forward: FeedForward,
    /// What the last tick estimated, asked for and decided.
    state: State<f32>,
    reference: Reference<f32>,
    command: ActuatorCommand,
}

impl ControlLoop {
    /// A loop that knows nothing of the arm.
    pub fn new(config: &LoopConfig) -> Self {
        let upright = Vector2::zeros();
        Self {
            estimate: config.control.estimator.at_rest(upright),
            is_fresh: true,
            monitors: Monitors::default(),
            commanded: DriveCommand::new(Drive::Hold, [0.0; JOINTS], 0),
            source: ReferenceSource::hold(upright),
            experiment: ActiveExperiment::default(),
            bump_nm: Vector2::zeros(),
            feed_forward: FeedForward::none(),
            state: State::at_rest(upright),
            reference: Reference::at_rest(upright),
            command: ActuatorCommand::OFF,
        }
    }

    /// Estimates, monitors, controls: everything that is decided in a tick.
    pub fn step(&mut self, config: &LoopConfig, input: &TickInput) -> TickOutput {
        let mut verdict = Verdict {
            permission: input.permission,
            fault: None,
        };
        self.check_command(&mut verdict);
        let mut fallback = self
            .watch_host(config, input, &mut verdict)
            .or_else(|| self.watch_age(config, input, &mut verdict));
        let counts = input.samples.map(Sample::counts);
        let measured = config.control.angles(counts);
        let is_fresh = self.is_fresh;
        if let (true, [Some(a), Some(b)]) = (is_fresh, measured) {
            self.estimate = config.control.estimator.at_rest([a, b].into());
            self.bump_nm = Vector2::zeros();
            self.is_fresh = false;
        }
        let predicted_rad = self.estimate.state().q.into();
        let believed = if verdict.is_armed() && !is_fresh {
            config.monitors.gate_innovation(measured, predicted_rad)
        } else {
            measured
        };
        let state = config
            .control
            .estimator
            .correct(&mut self.estimate, believed);
        // Of the estimate with these samples, whichever state is reported.
        let posture = Posture::of(self.estimate.state().q);
        self.monitor(config, input, &mut verdict, |is_armed| MonitorInput {
            counts,
            missing: input.samples.map(Sample::missing),
            measured_rad: measured,
            predicted_rad,
            is_fresh,
            state: &state,
            torque_nm: input.in_force.total_nm().into(),
            gravity_nm: posture.gravity(&config.control.arm).into(),
            is_alarmed: input.alarms.map(|alarms| !alarms.and(SHUTDOWN).is_empty()),
            is_armed,
        });
        // What is decided now acts from the next samples on.
        let ahead = self.predict(config, &posture, &input.in_force);
        let mut reference = self.source.at(input.acts_us);
        let mut experiment_end = None;
        if verdict.is_driven() && self.drive() == Drive::Experiment {
            let pwm = input.in_force.pwm;
            let fast_ticks = config.monitors.fast_ticks();
            let (at_us, asked) = (input.acts_us, &mut reference);
            experiment_end = self
                .experiment
                .tick(pwm, &state, &ahead, at_us, fast_ticks, asked);
            if experiment_end.is_some() {
                self.source = ReferenceSource::braking(asked, at_us);
                fallback = Some(self.brake(at_us));
                reference = self.source.at(at_us);
            }
        }
        let mut guards = Guards::NONE;
        let command = if verdict.is_driven() {
            self.control(config, &input.in_force, &ahead, &reference, &mut guards)
                .unwrap_or_else(|violation| {
                    verdict.trip(violation);
                    ActuatorCommand::OFF
                })
        } else {
            ActuatorCommand::OFF
        };
        (self.state, self.reference, self.command) = (state, reference, command);
        TickOutput {
            command,
            estimate: state,
            reference,
            disturbance_nm: self.estimate.disturbance().into(),
            guards,
            is_complete: believed.iter().all(Option::is_some),
            fallback,
            experiment_end,
            fault: verdict.fault,
            token: input.token.stamp(Machine::ControlLoop),
        }
    }

    /// Nothing is driven by a command or a reference that is not what was commanded.
    fn check_command(&self, verdict: &mut Verdict) {
        if verdict.is_armed() && !(self.commanded.is_intact() && self.source.is_intact()) {
            verdict.trip(Violation::plain(Fault::Corrupted));
        }
    }

    /// Turns a bit of what drives, chosen by `draw`: for tests of what becomes of it.
    pub fn inject_error(&mut self, draw: u32) {
        self.commanded.inject_error(draw);
    }

    /// Turns a bit of the reference's numbers.
    pub fn inject_reference_error(&mut self, draw: u32) {
        self.source.inject_error(draw);
    }

    fn monitor<'a>(
        &mut self,
        config: &LoopConfig,
        input: &TickInput,
        verdict: &mut Verdict,
        seen: impl FnOnce(bool) -> MonitorInput<'a>,
    ) {
        if verdict.permission != Permission::Unmonitored {
            let seen = seen(verdict.is_armed());
            if let Err(violation) = self.monitors.judge(&config.monitors, &seen) {
                verdict.trip(violation);
            }
        }
        if verdict.is_armed() && !input.is_config_intact {
            verdict.trip(Violation::plain(Fault::Corrupted));
        }
    }

    /// The state at the next samples, until which `in_force` acts.
    fn predict(
        &mut self,
        config: &LoopConfig,
        posture: &Posture<f32>,
        in_force: &ActuatorCommand,
    ) -> State<f32> {
        let control = &config.control;
        self.bump_nm *= control.fade;
        let known_nm = if control.knows_friction {
            in_force.total_nm()
        } else {
            in_force.torque_nm
        };
        control
            .estimator
            .advance_from(&control.arm, posture, &mut self.estimate, known_nm)
    }

    /// What the controller asks for, less what the estimator knows of a disturbance.
    fn demand(
        &self,
        config: &LoopConfig,
        state: &State<f32>,
        reference: &Reference<f32>,
        forward_nm: Vector2<f32>,
    ) -> Demand {
        let demand = config.control.demand(state, reference, forward_nm);
        Demand {
            torque_nm: demand.torque_nm + self.bump_nm - self.estimate.disturbance(),
            ..demand
        }
    }

    /// What drives the motors from the next tick on, within all limits.
    fn control(
        &mut self,
        config: &LoopConfig,
        in_force: &ActuatorCommand,
        ahead: &State<f32>,
        reference: &Reference<f32>,
        guards: &mut Guards,
    ) -> Result<ActuatorCommand, Violation> {
        let Demand {
            mut torque_nm,
            mut friction_nm,
        } = match self.drive() {
            Drive::Torque => Demand {
                torque_nm: self.commanded.torque_nm().into(),
                friction_nm: Vector2::zeros(),
            },
            Drive::Regulate | Drive::Track | Drive::Hold | Drive::Experiment => {
                let forward_nm = self.feed_forward.at(&config.control, reference);
                self.demand(config, ahead, reference, forward_nm)
            }
        };
        let control = &config.control;
        let exactly = (self.drive() == Drive::Experiment).then(|| {
            self.experiment
                .override_torque(&control.joints, &mut torque_nm, &mut friction_nm)
        });
        let before_nm = in_force.total_nm();
        let monitors = &config.monitors;
        let limited = self
            .monitors
            .limit(monitors, &control.arm, ahead, torque_nm, before_nm)?;
        let pwm_max = config.limits().pwm_counts;
        let commands = match exactly {
            None => control.commands(limited.torque_nm, friction_nm, pwm_max),
            Some(exactly) => {
                control.commands_exactly(exactly, limited.torque_nm, friction_nm, pwm_max)
            }
        };
        let (command, is_limited) = commands.ok_or(Violation::plain(Fault::NotFinite))?;
        *guards = limited.guards;
        if is_limited {
            *guards = guards.or(Guards::PWM);
        }
        self.monitors.note_pwm(monitors, is_limited)?;
        Ok(command)
    }

    /// Samples of this joint that are missing in a row.
    pub fn lost_in_row(&self, joint: usize) -> u32 {
        self.monitors.lost_in_row(joint)
    }
}
