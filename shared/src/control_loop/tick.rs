//! Inputs and outputs of a tick, as plain values.

use super::monitors::Violation;
use super::pipeline::ActuatorCommand;
use crate::JOINTS;
use crate::arm::State;
use crate::control::Reference;
use crate::flow_token::FlowToken;
use crate::link::experiment::ExperimentEnd;
use crate::link::message::{Guards, Missing, Sample};
use crate::servo::protocol1::Alarms;

/// What the supervisor permits in a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Permission {
    /// Motors off, the search for servos is under way: samples feed the estimator, nothing
    /// is judged.
    Unmonitored,
    /// Motors off; only whether the servos answer is judged.
    Off,
    /// Motors off, everything is judged: they may be driven soon.
    Armed,
    /// The motors may be driven.
    Drive,
}

/// When a command is taken, between two ticks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Instant {
    /// Now, in µs.
    pub us: u64,
    /// When what is decided next acts, in µs: the planned beginning of the next tick.
    pub acts_us: u64,
    /// Motors have been driven until now.
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
    /// When the command that this tick decides begins to act, in µs: the planned
    /// beginning of the next tick.
    pub acts_us: u64,
    /// What the supervisor permits.
    pub permission: Permission,
    /// Time since the last frame of the host, in µs.
    pub host_silent_us: u64,
    /// The configuration is as it was built.
    pub is_config_intact: bool,
    /// Stamps of this tick so far.
    pub token: FlowToken,
}

impl TickInput {
    /// A tick that brought nothing, with motors off.
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

/// How the loop gives up what drives the motors, when the host is quiet or an
/// experiment is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fallback {
    /// The reference brakes to rest; the arm is held from then on.
    Brake,
    /// Torque ends.
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
    /// Torque in N m that acts without being commanded, as estimated.
    pub disturbance_nm: [f32; JOINTS],
    /// Limits that changed the torque.
    pub guards: Guards,
    /// Every joint has a sample that the estimator was given.
    pub is_complete: bool,
    /// End of a drive command by the loop itself.
    pub fallback: Option<Fallback>,
    /// An experiment is over.
    pub experiment_end: Option<ExperimentEnd>,
    /// Why the motors must be off; the command is [`ActuatorCommand::OFF`] then.
    pub fault: Option<Violation>,
    /// The token with the loop's own stamp.
    pub token: FlowToken,
}

/// Permission and first fault of a tick, as far as it has come.
pub(super) struct Verdict {
    pub(super) permission: Permission,
    pub(super) fault: Option<Violation>,
}

impl Verdict {
    pub(super) fn is_armed(&self) -> bool {
        matches!(self.permission, Permission::Armed | Permission::Drive)
    }

    pub(super) fn is_driven(&self) -> bool {
        self.permission == Permission::Drive
    }

    /// Motors off; the first cause stays, for what follows is often its consequence.
    pub(super) fn trip(&mut self, violation: Violation) {
        self.fault.get_or_insert(violation);
        if self.permission != Permission::Unmonitored {
            self.permission = Permission::Off;
        }
    }
}
