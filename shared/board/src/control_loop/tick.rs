//! Inputs and outputs of a tick, as plain values.

use super::monitors::Violation;
use super::pipeline::ActuatorCommand;
use crate::flow_token::FlowToken;
use armbridge_control::arm::State;
use armbridge_control::trajectory::Reference;
use armbridge_link::experiment::ExperimentEnd;
use armbridge_link::message::{Guards, Missing, Sample};
use armbridge_servo::Alarms;
use armbridge_servo::JOINTS;

/// Permission of the supervisor in a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Permission {
    /// Motors off, the search for servos is under way: samples feed the estimator, no
    /// monitor runs.
    Unmonitored,
    /// Motors off; only the dropout monitor runs.
    Off,
    /// Motors off, all monitors run: they may be driven soon.
    Armed,
    /// Motors driven by the motor check, all monitors run.
    MotorCheck,
    /// The motors may be driven.
    Drive,
}

/// Time at which a command is taken, between two ticks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Instant {
    /// Present time, in µs.
    pub us: u64,
    /// Time in µs at which the next command acts: the planned beginning of the next tick.
    pub acts_us: u64,
    /// Whether motors have been driven until now.
    pub is_driven: bool,
}

/// The inputs of one tick.
#[derive(Clone, Copy, Debug)]
pub struct TickInput {
    /// Sample of each servo.
    pub samples: [Sample; JOINTS],
    /// Alarms of each stock servo in its answer.
    pub alarms: [Alarms; JOINTS],
    /// Commands sent to the servos at the beginning of the tick.
    pub in_force: ActuatorCommand,
    /// Time in µs at which the command of this tick begins to act: the planned
    /// beginning of the next tick.
    pub acts_us: u64,
    /// Permission of the supervisor.
    pub permission: Permission,
    /// Time since the last frame of the host, in µs.
    pub host_silent_us: u64,
    /// Whether the configuration is as it was built.
    pub is_config_intact: bool,
    /// Stamps of this tick so far.
    pub token: FlowToken,
}

impl TickInput {
    /// Inputs of a tick without samples, with motors off.
    pub const AT_REST: Self = Self {
        samples: [Sample::Missing(Missing::NotAsked); JOINTS],
        alarms: [Alarms::NONE; JOINTS],
        in_force: ActuatorCommand::OFF,
        acts_us: 0,
        permission: Permission::Off,
        host_silent_us: 0,
        is_config_intact: true,
        token: FlowToken::begin(0),
    };
}

/// Reaction of the loop when the host is silent or an experiment has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fallback {
    /// The reference brakes to rest; the arm is held from then on.
    Brake,
    /// The torque is switched off.
    Release,
}

/// The outputs of one tick.
#[derive(Clone, Copy, Debug)]
pub struct TickOutput {
    /// Commands for the servos at the beginning of the next tick.
    pub command: ActuatorCommand,
    /// The state at the samples.
    pub estimate: State<f32>,
    /// The reference at `acts_us`.
    pub reference: Reference<f32>,
    /// Estimated disturbance torque in N m.
    pub disturbance_nm: [f32; JOINTS],
    /// Limits that changed the torque.
    pub guards: Guards,
    /// Whether every joint has a sample that passed the innovation gate.
    pub is_complete: bool,
    /// End of a drive command by the loop itself.
    pub fallback: Option<Fallback>,
    /// End of an experiment.
    pub experiment_end: Option<ExperimentEnd>,
    /// Whether the motor check has been passed in this tick.
    pub are_motors_checked: bool,
    /// Violation for which the motors must be off, with [`ActuatorCommand::OFF`].
    pub fault: Option<Violation>,
    /// The token with the loop's own stamp.
    pub token: FlowToken,
}

/// Permission and first fault of the tick so far.
pub(super) struct TickStatus {
    pub(super) permission: Permission,
    pub(super) fault: Option<Violation>,
}

impl TickStatus {
    pub(super) fn is_armed(&self) -> bool {
        matches!(
            self.permission,
            Permission::MotorCheck | Permission::Armed | Permission::Drive
        )
    }

    /// Whether a motor may be on in the next tick.
    pub(super) fn drives_motors(&self) -> bool {
        matches!(self.permission, Permission::MotorCheck | Permission::Drive)
    }

    pub(super) fn is_driven(&self) -> bool {
        self.permission == Permission::Drive
    }

    /// Switches motors off; the first cause is kept, because later ones often follow from it.
    pub(super) fn trip(&mut self, violation: Violation) {
        self.fault.get_or_insert(violation);
        if self.permission != Permission::Unmonitored {
            self.permission = Permission::Off;
        }
    }
}
