//! The control loop: computes the outputs of a tick from its inputs, as plain values.
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
//! no bus, queue, record or clock. Board, bench, emulator and
//! replay call it; equal inputs give equal outputs, to the bit.
//!
//! # Contract
//!
//! * Call [`step`](ControlLoop::step) once a tick, when the samples are in. Its
//!   command is sent at the beginning of the next tick, so a torque acts one period
//!   after the samples that it was decided from, always; the prediction accounts for it.
//! * The motors are driven only under [`Permission::Drive`]. Any fault, and any other
//!   permission, make the command [`ActuatorCommand::OFF`].
//! * The configuration is immutable between ticks and replaced as a whole
//!   ([`install`](ControlLoop::install)); the loop keeps none of its numbers.
//! * Angles in rad, speeds in rad/s, torques in N m, times in µs of a clock that never
//!   goes back.
//!
//! The reaction to a fault, the permission to drive and the evidence that motors are off
//! belong to the [`supervisor`](crate::supervisor) and the bus.
//!
//! # Example
//!
//! The loop closed around a simulated arm:
//!
//! ```
//! use armbridge_control::actuator::Joint;
//! use armbridge_control::arm::{Parameters, State};
//! use armbridge_board::control_loop::{ControlLoop, DriveRequest, Instant, LoopConfig};
//! use armbridge_board::checkpoints::Checkpoints;
//! use armbridge_link::message::{Sample, Settings};
//! use armbridge_link::record::{Permission, TickInput};
//! use armbridge_servo::Pwm;
//! use nalgebra::Vector2;
//!
//! let config = LoopConfig::build(&Settings::default()).unwrap();
//! let (arm, servo) = (Parameters::<f32>::paper(), Joint::<f32>::paper());
//! let mut plant = State::at_rest(Vector2::new(0.2, -0.1));
//! let (mut control, mut input) = (ControlLoop::new(&config), TickInput::AT_REST);
//! let upright = DriveRequest::Regulate([0.0, 0.0]);
//! control.request(&config, &upright, Instant::default()).unwrap();
//! for tick in 1..=2_000 {
//!     input.samples = [plant.q.x, plant.q.y].map(|q| Sample::Counts(servo.position(q) as u16));
//!     (input.start_us, input.lead_us) = (tick * 1_000, 1_000);
//!     input.permission = Permission::Drive;
//!     let torque = input.pwm_in_force.map(|pwm| servo.torque(Pwm::saturating(pwm)));
//!     input.pwm_in_force = control.step(&config, &input, &mut Checkpoints::default()).pwm;
//!     plant.dq += arm.acceleration(&plant, torque.into()) * 1e-3;
//!     plant.q += plant.dq * 1e-3;
//! }
//! assert!(plant.q.amax() < 0.02, "it stands at {}", plant.q);
//! ```
//!
//! | module         | content                                                  |
//! |----------------|----------------------------------------------------------|
//! | [`LoopConfig`] | parameters of a tick, under check words                  |
//! | `commands`     | commands, with bumpless transfer                         |
//! | `drive_command` | source that drives the motors, and its age              |
//! | `tick`         | inputs and outputs                                       |
//! | `time_out`     | silence of the host, age of commands                     |
//! | `pipeline`     | from state and reference to PWM                          |
//! | `monitors`     | fault detection and limits                               |
//! | `motor_check`  | direction and joint of each motor, before the loop closes |
//! | `motor_command` | demand of the drive, within all limits                  |
//! | [`mod@reference`] | sources of the reference                              |
//! | `experiment`   | experiments, from admission to the end                   |
//! | [`limits`]     | limits that no host can set                              |

mod commands;
mod config;
mod drive_command;
mod experiment;
pub mod limits;
mod monitors;
mod motor_check;
mod motor_command;
mod pipeline;
pub mod reference;
mod tick;
mod time_out;

pub use config::{CHECK_US, ControlConfig, LoopConfig, can_run, settings_refusal};
pub use experiment::permits;
pub use pipeline::ActuatorCommand;
pub use tick::Instant;

use crate::checkpoints::{Checkpoints, Machine};
use armbridge_control::arm::{Posture, State};
use armbridge_control::estimate::Estimate;
use armbridge_control::trajectory::Reference;
use armbridge_link::experiment::ExperimentEnd;
use armbridge_link::message::{Drive, Fault, Guards, Sample};
use armbridge_link::record::{Fallback, Permission, TickEvents, TickInput, TickOutput, Violation};
use armbridge_servo::{Alarms, JOINTS, Pwm};
use drive_command::DriveCommand;
pub use drive_command::DriveRequest;
use experiment::ActiveExperiment;
use monitors::{MonitorInput, Monitors};
use motor_check::{CheckStep, MotorCheck};
use nalgebra::Vector2;
use pipeline::FeedForward;
use reference::ReferenceSource;
use tick::TickStatus;

/// Alarms upon which a stock servo with factory settings switches its torque off.
const SHUTDOWN: Alarms = Alarms::OVERHEATING.or(Alarms::OVERLOAD);

/// Whether a servo with this error byte switches its torque off.
fn switches_off(alarms: u8) -> bool {
    !Alarms::from_bits(alarms).and(SHUTDOWN).is_empty()
}

/// The state of the control loop, see the [module](self).
#[derive(Clone, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct ControlLoop {
    estimate: Estimate<f32>,
    /// Whether the estimator has had no sample since its last reset.
    is_fresh: bool,
    monitors: Monitors,
    motor_check: MotorCheck,
    /// Source that drives the motors while that is permitted.
    commanded: DriveCommand,
    source: ReferenceSource,
    /// Experiment of [`Drive::Experiment`].
    experiment: ActiveExperiment,
    /// Torque offset since the set-up was replaced, which fades out.
    bump_nm: Vector2<f32>,
    /// Torque of the integral action.
    integral_nm: Vector2<f32>,
    feed_forward: FeedForward,
    /// Estimate, reference and command of the last tick.
    state: State<f32>,
    reference: Reference<f32>,
    command: ActuatorCommand,
}

impl ControlLoop {
    /// A loop without an estimate of the arm.
    pub fn new(config: &LoopConfig) -> Self {
        let upright = Vector2::zeros();
        Self {
            estimate: config.control.estimator.at_rest(upright),
            is_fresh: true,
            monitors: Monitors::default(),
            motor_check: MotorCheck::default(),
            commanded: DriveCommand::new(Drive::Hold, [0.0; JOINTS], 0),
            source: ReferenceSource::hold(upright),
            experiment: ActiveExperiment::default(),
            bump_nm: Vector2::zeros(),
            integral_nm: Vector2::zeros(),
            feed_forward: FeedForward::none(),
            state: State::at_rest(upright),
            reference: Reference::at_rest(upright),
            command: ActuatorCommand::OFF,
        }
    }

    /// Runs a tick: estimates, monitors, controls; and passes its checkpoint.
    pub fn step(
        &mut self,
        config: &LoopConfig,
        input: &TickInput,
        checkpoints: &mut Checkpoints,
    ) -> TickOutput {
        if input.is_first {
            // On a board it has done so when bring-up ended; a replay has no other sign of that.
            self.restart();
        }
        let in_force = self.in_force(input);
        let acts_us = input.acts_us();
        let mut status = TickStatus {
            permission: input.permission,
            fault: None,
        };
        self.check_command(&mut status);
        let mut fallback = self
            .check_host_silence(config, input, &mut status)
            .or_else(|| self.check_command_age(config, input, &mut status));
        let counts = input.samples.map(Sample::counts);
        let measured = config.control.angles(counts);
        let (is_fresh, followed_rad_s) = (self.is_fresh, self.reference.dq);
        self.begin_estimate(config, measured);
        let predicted_rad = self.estimate.state().q.into();
        let gated = if status.is_armed() && !is_fresh {
            config.monitors.gate_innovation(measured, predicted_rad)
        } else {
            measured
        };
        let state = config.control.estimator.correct(&mut self.estimate, gated);
        // From the estimate with these samples, whichever state is reported.
        let posture = Posture::of(self.estimate.state().q);
        let torque_nm = in_force.total_nm();
        let gravity_nm = posture.gravity(&config.control.arm);
        let is_held = status.is_driven() && self.drive().is_closed_loop();
        let rest_nm = gravity_nm - torque_nm;
        let balance = is_held.then(|| config.balance(&posture, &state, rest_nm));
        self.monitor(config, input, &mut status, |is_armed| MonitorInput {
            counts,
            missing: input.samples.map(Sample::missing),
            measured_rad: measured,
            predicted_rad,
            is_fresh,
            state: &state,
            torque_nm: torque_nm.into(),
            gravity_nm: gravity_nm.into(),
            balance,
            reference_rad_s: followed_rad_s.into(),
            is_alarmed: input.alarms.map(switches_off),
            is_armed,
        });
        // The command of this tick acts from the next samples on.
        let known_nm = if status.drives_motors() || in_force != ActuatorCommand::OFF {
            config.control.known_torque(&in_force)
        } else {
            // The arm rests on something: a model that falls would estimate a speed there.
            gravity_nm
        };
        let ahead = self.predict(config, &posture, known_nm);
        let is_experiment = status.is_driven() && self.drive() == Drive::Experiment;
        let mut reference = self.source.at(acts_us);
        let mut experiment_end = None;
        if is_experiment {
            experiment_end = self.override_reference(
                config,
                in_force.pwm,
                [&state, &ahead],
                acts_us,
                &mut reference,
            );
            if experiment_end.is_some() {
                fallback = Some(Fallback::Brake);
            }
        }
        let check = self.check_motors(config, &mut status, measured, state.q, torque_nm);
        // Without a first sample of each joint there is no state to control.
        let is_driven = status.is_driven() && !self.is_fresh;
        let demand = match check {
            Some(check) => check.demand(),
            None => is_driven.then(|| self.drive_demand(config, &ahead, &reference, gravity_nm)),
        };
        let demand_nm = demand.map(|demand| demand.torque_nm);
        let mut guards = Guards::NONE;
        let command = self
            .command(config, &in_force, &ahead, demand, is_driven, &mut guards)
            .unwrap_or_else(|violation| {
                status.trip(violation);
                ActuatorCommand::OFF
            });
        let lag_rad = reference.q - ahead.q;
        self.integrate(config, is_driven, lag_rad, demand_nm, &command);
        (self.state, self.reference, self.command) = (state, reference, command);
        let are_motors_checked = matches!(check, Some(CheckStep::Passed));
        if are_motors_checked {
            self.end_motor_check();
        }
        *checkpoints = checkpoints.pass(Machine::ControlLoop);
        let events = TickEvents {
            are_motors_checked,
            fallback,
            experiment_end,
            fault: status.fault,
        };
        self.output(guards, gated.iter().all(Option::is_some), events)
    }

    /// The outputs of the tick whose results the loop holds.
    #[inline]
    fn output(&self, guards: Guards, is_complete: bool, events: TickEvents) -> TickOutput {
        TickOutput {
            pwm: self.command.pwm.map(Pwm::counts),
            torque_nm: self.command.torque_nm.into(),
            reference_rad: self.reference.q.into(),
            reference_speed_rad_s: self.reference.dq.into(),
            angle_rad: self.state.q.into(),
            speed_rad_s: self.state.dq.into(),
            disturbance_nm: self.estimate.disturbance().into(),
            guards,
            is_complete,
            events: events.some(),
        }
    }

    /// Overrides the reference by that of an experiment. Returns its end, which brakes the arm.
    #[inline(never)]
    fn override_reference(
        &mut self,
        config: &LoopConfig,
        pwm: [Pwm; JOINTS],
        states: [&State<f32>; 2],
        at_us: u64,
        reference: &mut Reference<f32>,
    ) -> Option<ExperimentEnd> {
        let ([state, ahead], fast_ticks) = (states, config.monitors.fast_ticks());
        let end = self
            .experiment
            .tick(pwm, state, ahead, at_us, fast_ticks, reference);
        if end.is_some() {
            self.source = ReferenceSource::braking(reference, at_us);
            self.brake(at_us);
            *reference = self.source.at(at_us);
        }
        end
    }

    /// The command in force: the last one, if its PWM was sent, or motors off.
    fn in_force(&self, input: &TickInput) -> ActuatorCommand {
        if self.command.pwm.map(Pwm::counts) == input.pwm_in_force {
            self.command
        } else {
            ActuatorCommand::OFF
        }
    }

    /// Trips if command or reference are corrupted.
    fn check_command(&self, status: &mut TickStatus) {
        if status.is_armed() && !(self.commanded.is_intact() && self.source.is_intact()) {
            status.trip(Violation::plain(Fault::Corrupted));
        }
    }

    /// Turns a bit of the drive command, chosen by `draw`, for tests.
    pub fn inject_error(&mut self, draw: u32) {
        self.commanded.inject_error(draw);
    }

    /// Turns a bit of the reference's numbers, for tests.
    pub fn inject_reference_error(&mut self, draw: u32) {
        self.source.inject_error(draw);
    }

    /// Runs the monitors.
    fn monitor<'a>(
        &mut self,
        config: &LoopConfig,
        input: &TickInput,
        status: &mut TickStatus,
        monitor_input: impl FnOnce(bool) -> MonitorInput<'a>,
    ) {
        if status.permission != Permission::Unmonitored {
            let monitor_input = monitor_input(status.is_armed());
            if let Err(violation) = self.monitors.check(&config.monitors, &monitor_input) {
                status.trip(violation);
            }
        }
        if status.is_armed() && !input.is_config_intact {
            status.trip(Violation::plain(Fault::Corrupted));
        }
    }

    /// Begins the estimate at rest, with the first sample of each joint.
    fn begin_estimate(&mut self, config: &LoopConfig, measured: [Option<f32>; JOINTS]) {
        if let (true, [Some(a), Some(b)]) = (self.is_fresh, measured) {
            self.estimate = config.control.estimator.at_rest([a, b].into());
            self.bump_nm = Vector2::zeros();
            self.is_fresh = false;
        }
    }

    /// The state at the next samples, until which this torque acts.
    fn predict(
        &mut self,
        config: &LoopConfig,
        posture: &Posture<f32>,
        known_nm: Vector2<f32>,
    ) -> State<f32> {
        let control = &config.control;
        self.bump_nm *= control.fade;
        control
            .estimator
            .advance_from(&control.arm, posture, &mut self.estimate, known_nm)
    }

    /// PWM decided in the last tick.
    pub fn pwm(&self) -> [Pwm; JOINTS] {
        self.command.pwm
    }

    /// Consecutive missing samples of this joint.
    pub fn lost_in_row(&self, joint: usize) -> u32 {
        self.monitors.lost_in_row(joint)
    }
}

#[cfg(test)]
mod tests;
