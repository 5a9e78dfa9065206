//! Motor command: what the source of the drive demands, within all limits.
//!
//! Torque in N m at the joints, of which the friction compensation is a part; the command has
//! the PWM, and the torque that is left after limits and rounding.

use super::motor_check::{CheckInput, CheckStep};
use super::pipeline::{ActuatorCommand, Demand};
use super::tick::TickStatus;
use super::{ControlLoop, LoopConfig};
use armbridge_control::arm::State;
use armbridge_control::trajectory::Reference;
use armbridge_link::message::{Drive, Fault, Guards};
use armbridge_link::record::{Permission, Violation};
use armbridge_servo::JOINTS;
use nalgebra::Vector2;

impl ControlLoop {
    /// A tick of the motor check, if it is permitted: the angles as `measured_rad` and as estimated,
    /// under the torque in force. Not inlined: few ticks have one.
    #[inline(never)]
    pub(super) fn check_motors(
        &mut self,
        config: &LoopConfig,
        status: &mut TickStatus,
        measured_rad: [Option<f32>; JOINTS],
        angle_rad: Vector2<f32>,
        in_force_nm: Vector2<f32>,
    ) -> Option<CheckStep> {
        if status.permission != Permission::MotorCheck || self.is_fresh {
            return None;
        }
        let step = self.motor_check.tick(&CheckInput {
            arm: &config.control.arm,
            acceleration_rad_s2: config.limits().check_rad_s2.into(),
            period_us: config.period_us().get(),
            noise_rad2: self.monitors.noise_rad2(&config.control.joints),
            measured_rad,
            angle_rad,
            in_force_nm,
        });
        if let CheckStep::Failed(violation) = step {
            status.trip(violation);
        }
        Some(step)
    }

    /// Torque of the integral action in the next tick, after this one in which the reference
    /// is `lag_rad` ahead of the arm. There is none before a controller drives the arm.
    pub(super) fn integrate(
        &mut self,
        config: &LoopConfig,
        is_driven: bool,
        lag_rad: Vector2<f32>,
        demand_nm: Option<Vector2<f32>>,
        command: &ActuatorCommand,
    ) {
        let control = &config.control;
        let Some(integral) = &control.integral else {
            return;
        };
        let is_controlled = is_driven && self.drive() != Drive::Torque;
        self.integral_nm = match demand_nm {
            Some(demand_nm) if is_controlled => integral.next(
                self.integral_nm,
                lag_rad,
                demand_nm - command.total_nm(),
                // A count of PWM.
                [0, 1].map(|joint| 1.0 / control.joints[joint].gain_counts_per_nm.abs()),
                config.limits().torque_nm,
            ),
            Some(_) | None => Vector2::zeros(),
        };
    }

    /// Controller output, integral action and torque offset, less the estimated disturbance.
    pub(super) fn demand(
        &self,
        config: &LoopConfig,
        state: &State<f32>,
        reference: &Reference<f32>,
        forward_nm: Vector2<f32>,
    ) -> Demand {
        let demand = config.control.demand(state, reference, forward_nm);
        Demand {
            torque_nm: demand.torque_nm + self.integral_nm + self.bump_nm
                - self.estimate.disturbance(),
            ..demand
        }
    }

    /// Torque that the source of the drive demands, or the proof of an encoder where gravity takes
    /// `gravity_nm`.
    pub(super) fn drive_demand(
        &mut self,
        config: &LoopConfig,
        ahead: &State<f32>,
        reference: &Reference<f32>,
        gravity_nm: Vector2<f32>,
    ) -> Demand {
        match self.drive() {
            Drive::Torque => Demand {
                torque_nm: self.commanded.torque_nm().into(),
                friction_nm: Vector2::zeros(),
            },
            Drive::Regulate | Drive::Track | Drive::Hold | Drive::Experiment => {
                let forward_nm = self.feed_forward.at(&config.control, reference);
                let demand = self.demand(config, ahead, reference, forward_nm);
                let monitors = &config.monitors;
                Demand {
                    torque_nm: self.monitors.proved(monitors, demand.torque_nm, gravity_nm),
                    ..demand
                }
            }
        }
    }

    /// Command for the motors in the next tick, within all limits; off without a demand.
    pub(super) fn command(
        &mut self,
        config: &LoopConfig,
        in_force: &ActuatorCommand,
        ahead: &State<f32>,
        demand: Option<Demand>,
        is_driven: bool,
        guards: &mut Guards,
    ) -> Result<ActuatorCommand, Violation> {
        let Some(Demand {
            mut torque_nm,
            mut friction_nm,
        }) = demand
        else {
            return Ok(ActuatorCommand::OFF);
        };
        let control = &config.control;
        let is_experiment = is_driven && self.drive() == Drive::Experiment;
        let exact_pwm = is_experiment.then(|| {
            self.experiment
                .override_torque(&control.joints, &mut torque_nm, &mut friction_nm)
        });
        let before_nm = in_force.total_nm();
        let monitors = &config.monitors;
        let limited = self
            .monitors
            .limit(monitors, &control.arm, ahead, torque_nm, before_nm)?;
        let pwm_max = config.limits().pwm_counts;
        let commands = match exact_pwm {
            None => control.commands(limited.torque_nm, friction_nm, pwm_max),
            Some(exact_pwm) => {
                control.commands_with_pwm(exact_pwm, limited.torque_nm, friction_nm, pwm_max)
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
}
