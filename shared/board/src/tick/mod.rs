//! The tick: computes the outputs of the control loop from its inputs, as plain values.
//!
//! ```text
//!  TickInput: samples, permission, time            TickOutput: PWM, estimate, reference, fault
//!      |                                                 ^
//!      v                                                 |
//!    sense -> estimate -> monitor -> predict -> reference -> control -> limit
//!                            |                               |
//!                            +----- Violation: motors off ---+
//! ```
//!
//! [`step`] is that drawing, a stage after the other. The state from one tick to the next is
//! [`ControlLoop`], with a part for each stage; the parameters are [`LoopConfig`]. There is no
//! bus, queue, record or clock in it. Board, bench, emulator and
//! replay call it; equal inputs give equal outputs, to the bit.
//!
//! # Contract
//!
//! * Call [`step`] once a tick, when the samples are in. Its
//!   command is sent at the beginning of the next tick, so a torque acts one period
//!   after the samples that it was decided from, always; the prediction accounts for it.
//! * The motors are driven only under [`Permission::Drive`]. Any fault, and any other
//!   permission, make the command [`ActuatorCommand::OFF`].
//! * The configuration is immutable between ticks and replaced as a whole
//!   ([`install`](ControlLoop::install)); the state keeps none of its numbers.
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
//! use armbridge_board::checkpoints::Checkpoints;
//! use armbridge_board::tick::{ControlLoop, DriveRequest, Instant, LoopConfig, step};
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
//!     input.pwm_in_force = step(&config, &mut control, &input, &mut Checkpoints::default()).pwm;
//!     plant.dq += arm.acceleration(&plant, torque.into()) * 1e-3;
//!     plant.q += plant.dq * 1e-3;
//! }
//! assert!(plant.q.amax() < 0.02, "it stands at {}", plant.q);
//! ```
//!
//! | module         | stage     | content                                             |
//! |----------------|-----------|-----------------------------------------------------|
//! | `sense`        | sense     | samples as angles, and the command in force         |
//! | `estimation`   | estimate, predict | state at the samples, and at the next       |
//! | `monitors`     | monitor, limit | fault detection, limits of the torque          |
//! | `drive_source` | reference | what drives the motors, and its time-outs           |
//! | [`mod@reference`] | reference | setpoint, motion or stream                       |
//! | `experiment`   | reference, control | experiments, from admission to the end     |
//! | `motor_check`  | control   | direction and joint of each motor, before the loop closes |
//! | `torque_control` | control | from state and reference to torque                 |
//! | `actuator_command` | limit | torque within all limits, and its PWM               |
//! | `control_loop` |           | state between two ticks, and requests that change it |
//! | `drive_command` |          | source that drives the motors, and its age          |
//! | [`LoopConfig`] |           | parameters of a tick, under check words             |
//! | `status`       |           | permission and first fault of a tick under way      |
//! | [`limits`]     |           | limits that no host can set                         |

mod actuator_command;
mod config;
mod control_loop;
mod drive_command;
mod drive_source;
mod estimation;
mod experiment;
pub mod limits;
mod monitor_input;
mod monitors;
mod motor_check;
pub mod reference;
mod sense;
mod status;
mod torque_control;

pub use actuator_command::ActuatorCommand;
pub use config::{CHECK_US, ControlConfig, LoopConfig, can_run, settings_refusal};
pub use control_loop::ControlLoop;
pub use drive_command::DriveRequest;
pub use experiment::permits;
pub use status::Instant;

use crate::checkpoints::{Checkpoints, Machine};
use actuator_command::limit;
use armbridge_control::arm::State;
use armbridge_control::trajectory::Reference;
use armbridge_link::message::{Drive, Fault, Guards};
use armbridge_link::record::{Fallback, Permission, TickEvents, TickInput, TickOutput, Violation};
use armbridge_servo::Pwm;
use estimation::Estimated;
use monitor_input::monitor_input;
use motor_check::{CheckInput, CheckStep};
use sense::Sensed;
use status::TickStatus;
use torque_control::Demand;

/// Runs a tick, and passes its checkpoint.
pub fn step(
    config: &LoopConfig,
    control_loop: &mut ControlLoop,
    input: &TickInput,
    checkpoints: &mut Checkpoints,
) -> TickOutput {
    let this = control_loop;
    if input.is_first {
        // On a board it has done so when bring-up ended; a replay has no other sign of that.
        this.restart();
    }
    let acts_us = input.acts_us();
    let mut status = TickStatus::new(input.permission);

    // Sense: counts to angles, positive as the paper's.
    let sensed = Sensed::new(&config.control, input, &this.command);
    // Torque ends when its command is corrupted or too old, or the host is silent.
    let fallback = this.source.check(config.limits(), input, &mut status);

    // Estimate: the state at these samples.
    let estimated = this.estimation.correct(config, &sensed, status.is_armed());
    if estimated.is_fresh && this.estimation.has_state() {
        this.control.end_offset();
    }

    // Monitor: samples, estimate and motion against the limits, under the torque that acted.
    if status.permission != Permission::Search {
        let is_held = status.is_driven() && this.drive().is_closed_loop();
        let reference_rad_s = this.reference.dq.into();
        let is_armed = status.is_armed();
        let seen = monitor_input(
            config,
            &sensed,
            &estimated,
            is_armed,
            is_held,
            reference_rad_s,
        );
        status.require(this.monitors.check(&config.monitors, &seen));
    }
    if status.is_armed() && !input.is_config_intact {
        status.trip(Violation::plain(Fault::Corrupted));
    }

    // Predict: the state at the next samples, when the command of this tick begins to act.
    let drives_motors = status.drives_motors();
    let control = &config.control;
    let ahead = this
        .estimation
        .predict(control, &estimated, &sensed.in_force, drives_motors);

    // Reference: at that time, too.
    let mut reference = this.source.reference.at(acts_us);
    let mut experiment_end = None;
    if status.is_driven() && this.drive() == Drive::Experiment {
        experiment_end = this.source.override_reference(
            config.monitors.fast_ticks(),
            sensed.in_force.pwm,
            [&estimated.state, &ahead],
            acts_us,
            &mut reference,
        );
    }
    let fallback = experiment_end.map_or(fallback, |_| Some(Fallback::Brake));

    // Control: a torque, positive as the angles; none without permission and state.
    this.control.fade(control);
    let check = check_motors(config, this, &sensed, &estimated, &mut status);
    let is_controlled = status.is_driven() && this.estimation.has_state();
    let demand = match check {
        Some(check) => check.torque_nm().map(Demand::plain),
        None if is_controlled => Some(control_torque(config, this, &ahead, &reference, &estimated)),
        None => None,
    };

    // Limit: torque, soft stop, rate, PWM; motors off without a demand.
    let limited = demand
        .as_ref()
        .map(|demand| limit(config, &mut this.monitors, &ahead, demand, sensed.torque_nm));
    let (command, guards) = match limited {
        None => (ActuatorCommand::OFF, Guards::NONE),
        Some(Ok(limited)) => limited,
        Some(Err(violation)) => {
            status.trip(violation);
            (ActuatorCommand::OFF, Guards::NONE)
        }
    };
    let controlled_nm = demand.filter(|_| is_controlled && this.drive() != Drive::Torque);
    let controlled_nm = controlled_nm.map(|demand| demand.torque_nm);
    let lag_rad = reference.q - ahead.q;
    this.control
        .integrate(config, lag_rad, controlled_nm, command.total_nm());

    (this.state, this.reference, this.command) = (estimated.state, reference, command);
    let are_motors_checked = matches!(check, Some(CheckStep::Passed));
    if are_motors_checked {
        this.end_motor_check();
    }
    *checkpoints = checkpoints.pass(Machine::ControlLoop);
    let events = TickEvents {
        are_motors_checked,
        fallback,
        experiment_end,
        fault: status.fault,
    };
    output(this, guards, estimated.is_complete, events)
}

/// A tick of the motor check, if it is permitted. Not inlined: few ticks have one.
#[inline(never)]
fn check_motors(
    config: &LoopConfig,
    this: &mut ControlLoop,
    sensed: &Sensed,
    estimated: &Estimated,
    status: &mut TickStatus,
) -> Option<CheckStep> {
    if status.permission != Permission::MotorCheck || !this.estimation.has_state() {
        return None;
    }
    let step = this.motor_check.tick(&CheckInput {
        arm: &config.control.arm,
        acceleration_rad_s2: config.limits().check_rad_s2.into(),
        period_us: config.period_us().get(),
        noise_rad2: this.monitors.noise_rad2(&config.control.joints),
        measured_rad: sensed.measured_rad,
        angle_rad: estimated.state.q,
        in_force_nm: sensed.torque_nm,
    });
    if let CheckStep::Failed(violation) = step {
        status.trip(violation);
    }
    Some(step)
}

/// Torque that the drive source demands. A controller's is replaced for a joint whose encoder
/// has to prove itself; an experiment has the last word.
#[inline]
fn control_torque(
    config: &LoopConfig,
    this: &mut ControlLoop,
    ahead: &State<f32>,
    reference: &Reference<f32>,
    estimated: &Estimated,
) -> Demand {
    let drive = this.drive();
    if drive == Drive::Torque {
        return Demand::plain(this.source.command.torque_nm().into());
    }
    let disturbance_nm = this.estimation.disturbance_nm();
    let control = &config.control;
    let mut demand = this
        .control
        .demand(control, ahead, reference, disturbance_nm);
    demand.torque_nm =
        this.monitors
            .proved(&config.monitors, demand.torque_nm, estimated.gravity_nm);
    if drive == Drive::Experiment {
        this.source
            .experiment
            .override_torque(&control.joints, &mut demand);
    }
    demand
}

/// The outputs of the tick whose results the loop holds.
#[inline]
fn output(this: &ControlLoop, guards: Guards, is_complete: bool, events: TickEvents) -> TickOutput {
    TickOutput {
        pwm: this.command.pwm.map(Pwm::counts),
        torque_nm: this.command.torque_nm.into(),
        reference_rad: this.reference.q.into(),
        reference_speed_rad_s: this.reference.dq.into(),
        angle_rad: this.state.q.into(),
        speed_rad_s: this.state.dq.into(),
        disturbance_nm: this.estimation.disturbance_nm().into(),
        guards,
        is_complete,
        events: events.some(),
    }
}

#[cfg(test)]
mod tests;
