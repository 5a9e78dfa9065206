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
//! [`step`] is that drawing, one stage after another. The state from one tick to the next is
//! [`ControlLoop`], with a part for each stage; the parameters are [`LoopConfig`]. There is no
//! bus, queue, record or clock in it. Board, bench, emulator and
//! replay call it; equal inputs give equal outputs, to the bit.
//!
//! # Contract
//!
//! * Call [`step`] once a tick, when the samples are in. Its command is sent at the beginning
//!   of the next tick, always, so that the delay is one period:
//!
//!   ```text
//!   tick k                                 tick k+1
//!   | SYNC_WR u(k-1) | CYCLE: samples | step -> u(k) ... | SYNC_WR u(k) | CYCLE: samples |
//!   ```
//!
//!   The estimator takes samples and command of a tick for simultaneous. The bus has the one after
//!   the other, and a servo applies a PWM in its own control step: the bench simulates both, the
//!   model has neither.
//! * The motors are driven only under [`Permission::Drive`], [`Permission::Park`] and
//!   [`Permission::MotorCheck`]. Any fault, and any other permission, make the command [`ActuatorCommand::OFF`].
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
//! use armbridge_servo::{JOINTS, Pwm};
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
//! | `park`         | reference | the board's own motion to a pose, and the lowering there |
//! | `lowering`     | reference, control | lowering of a joint, which its motor only carries |
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
mod lowering;
mod monitor_input;
mod monitors;
mod motor_check;
mod park;
pub mod reference;
mod sense;
mod status;
mod torque_control;

pub use actuator_command::ActuatorCommand;
pub use config::{CHECK_US, ControlConfig, LoopConfig, can_run, settings_refusal};
pub use control_loop::ControlLoop;
pub use drive_command::DriveRequest;
pub(crate) use drive_source::host_silence;
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
use lowering::{Lowered, carried};
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
    if input.is_first {
        // The bridge restarts the loop when bring-up ends; a replay sees the end by this input.
        control_loop.restart();
    }
    let acts_us = input.acts_us();
    let mut status = TickStatus::new(input.permission);

    // Sense: counts to angles, with the sign of the model; the command that was sent.
    let sensed = Sensed::new(&config.control, input, &control_loop.command);

    // Time-outs: silence of the host, age and integrity of the drive command.
    let time_out = control_loop
        .source
        .check(config.limits(), input, &mut status);

    // Estimate: the prediction of the last tick, corrected by these samples.
    let estimated = control_loop
        .estimation
        .correct(config, &sensed, status.is_armed());
    if estimated.is_fresh && control_loop.estimation.has_state() {
        control_loop.control.end_offset();
    }

    // Monitor: samples, estimate and motion, under the torque in force and the reference of the
    // last tick, which the arm follows now.
    let lowered = control_loop.source.lowered();
    monitor(
        config,
        control_loop,
        &sensed,
        &estimated,
        lowered,
        &mut status,
    );
    if status.is_armed() && !input.is_config_intact {
        status.trip(Violation::plain(Fault::Corrupted));
    }

    // Predict: the state one period later, from when on the command of this tick acts.
    let ahead = control_loop.estimation.predict(
        &config.control,
        &estimated,
        &sensed.in_force,
        status.drives_motors(),
    );

    // Park: its beginning, its next phase, or its end.
    let time_out = match status.permission {
        Permission::Park => control_loop.advance_park(config, &estimated, acts_us),
        _ => time_out,
    };

    // Reference: at the planned start of the next tick, which is the same time.
    let (reference, experiment_end) = control_loop.source.reference(
        config.monitors.fast_ticks(),
        sensed.in_force.pwm,
        [&estimated.state, &ahead],
        acts_us,
        status.is_drive_permitted(),
    );

    // Control: a joint torque, with the sign of the angles; none without permission and state.
    control_loop.control.fade(&config.control);
    let motor_check = check_motors(config, control_loop, &sensed, &estimated, &mut status);
    let is_controlled = status.is_drive_permitted() && control_loop.estimation.has_state();
    let demand = match motor_check {
        Some(step) => step.torque_nm().map(Demand::plain),
        None if is_controlled => {
            let demand = control_torque(config, control_loop, &ahead, &reference, &estimated);
            Some(demand)
        }
        None => None,
    };

    // Limit: torque, soft stop, rate; then PWM, in the direction of each servo.
    let monitors = &mut control_loop.monitors;
    let limited = limit(config, monitors, &ahead, demand, sensed.torque_nm, lowered);
    let (command, guards) = limited.unwrap_or_else(|violation| {
        status.trip(violation);
        (ActuatorCommand::OFF, Guards::NONE)
    });

    // Commit: the integral action, and the results of the tick.
    if config.control.integral.is_some() {
        let has_reference = !matches!(control_loop.drive(), Drive::Torque | Drive::Float);
        let controlled = demand.filter(|_| is_controlled && has_reference);
        control_loop.control.integrate(
            config,
            reference.q - ahead.q,
            controlled.map(|demand| demand.torque_nm),
            command.total_nm(),
        );
    }
    control_loop.state = estimated.state;
    control_loop.reference = reference;
    control_loop.command = command;
    let are_motors_checked = matches!(motor_check, Some(CheckStep::Passed));
    if are_motors_checked {
        control_loop.end_motor_check();
    }
    *checkpoints = checkpoints.pass(Machine::ControlLoop);
    let events = TickEvents {
        are_motors_checked,
        fallback: experiment_end.map_or(time_out, |_| Some(Fallback::Brake)),
        experiment_end,
        fault: status.fault,
    };
    output(control_loop, guards, estimated.is_complete, events)
}

/// Runs the monitors, once the servos have been found.
#[inline]
fn monitor(
    config: &LoopConfig,
    control_loop: &mut ControlLoop,
    sensed: &Sensed,
    estimated: &Estimated,
    lowered: Lowered,
    status: &mut TickStatus,
) {
    if status.permission == Permission::Search {
        return;
    }
    let drive = control_loop.drive();
    let drive = status.is_drive_permitted().then_some(drive);
    let reference_rad_s = control_loop.reference.dq.into();
    let is_armed = status.is_armed();
    let seen = monitor_input(
        config,
        sensed,
        estimated,
        is_armed,
        drive,
        lowered,
        reference_rad_s,
    );
    status.require(control_loop.monitors.check(&config.monitors, &seen));
}

/// A tick of the motor check, if it is permitted. Not inlined: few ticks have one.
#[inline(never)]
fn check_motors(
    config: &LoopConfig,
    control_loop: &mut ControlLoop,
    sensed: &Sensed,
    estimated: &Estimated,
    status: &mut TickStatus,
) -> Option<CheckStep> {
    if status.permission != Permission::MotorCheck || !control_loop.estimation.has_state() {
        return None;
    }
    let step = control_loop.motor_check.tick(&CheckInput {
        arm: &config.control.arm,
        acceleration_rad_s2: config.limits().check_rad_s2.into(),
        period_us: config.period_us().get(),
        noise_rad2: control_loop.monitors.noise_rad2(&config.control.joints),
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
    control_loop: &mut ControlLoop,
    ahead: &State<f32>,
    reference: &Reference<f32>,
    estimated: &Estimated,
) -> Demand {
    let drive = control_loop.drive();
    if drive == Drive::Torque {
        return Demand::plain(control_loop.source.command.torque_nm().into());
    }
    if drive == Drive::Float {
        return float_torque(config, control_loop, ahead);
    }
    let disturbance_nm = control_loop.estimation.disturbance_nm();
    let control = &mut control_loop.control;
    let mut demand = control.demand(&config.control, ahead, reference, disturbance_nm);
    demand.torque_nm =
        control_loop
            .monitors
            .proved(&config.monitors, demand.torque_nm, estimated.gravity_nm);
    if drive == Drive::Park {
        demand.torque_nm = carried(
            control_loop.source.lowered(),
            demand.torque_nm,
            estimated.gravity_nm,
        );
    }
    if drive == Drive::Experiment {
        control_loop
            .source
            .experiment
            .override_torque(&config.control.joints, &mut demand);
    }
    demand
}

/// Torque of an arm that floats, which the estimated disturbance, the hand, does not change. It is
/// in balance under this torque, about which an encoder proves itself. Not inlined: few ticks have
/// one.
#[inline(never)]
fn float_torque(config: &LoopConfig, control_loop: &mut ControlLoop, ahead: &State<f32>) -> Demand {
    let mut demand = control_loop.control.float_demand(&config.control, ahead);
    demand.torque_nm =
        control_loop
            .monitors
            .proved(&config.monitors, demand.torque_nm, demand.torque_nm);
    demand
}

/// Outputs of the tick that has just been committed.
#[inline]
fn output(
    control_loop: &ControlLoop,
    guards: Guards,
    is_complete: bool,
    events: TickEvents,
) -> TickOutput {
    TickOutput {
        pwm: control_loop.command.pwm.map(Pwm::counts),
        torque_nm: control_loop.command.torque_nm.into(),
        reference_rad: control_loop.reference.q.into(),
        reference_speed_rad_s: control_loop.reference.dq.into(),
        angle_rad: control_loop.state.q.into(),
        speed_rad_s: control_loop.state.dq.into(),
        disturbance_nm: control_loop.estimation.disturbance_nm().into(),
        guards,
        is_complete,
        events: events.some(),
    }
}

#[cfg(test)]
mod tests;
