//! The record of a tick: what went into it, what came out, and its timing.
//!
//! Inputs and state determine the outputs to the bit, so a record is all that a replay needs of
//! a tick: it computes the outputs of the inputs, and compares them with those recorded.
//! Commands between two ticks change the state; each is acknowledged with its
//! [`Moment`](crate::message::Moment).

use crate::experiment::ExperimentEnd;
use crate::fault::Fault;
use crate::mode::{Guards, Mode};
use armbridge_servo::{JOINTS, Missing, Pwm, Sample};
use postcard::experimental::max_size::MaxSize;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Record of one tick.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema, MaxSize)]
pub struct Record {
    /// Number of the tick since boot.
    pub tick: u32,
    /// Mode of the board after the tick.
    pub mode: Mode,
    /// Inputs of the tick.
    pub input: TickInput,
    /// Outputs of the tick.
    pub output: TickOutput,
    /// Timing of the tick.
    pub timing: Timing,
    /// Records dropped so far because the host did not fetch them in time.
    pub dropped: u32,
}

impl Record {
    /// Record before the first tick.
    pub const NONE: Self = Self {
        tick: 0,
        mode: Mode::Boot,
        input: TickInput::AT_REST,
        output: TickOutput::NONE,
        timing: Timing {
            start_error_us: 0,
            bus_us: 0,
            compute_ns: 0,
            missed: 0,
        },
        dropped: 0,
    };
}

/// Permission of the supervisor, for bus and control loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema, MaxSize)]
pub enum Permission {
    /// Motors off, the search for servos is under way: samples feed the estimator, no
    /// monitor runs.
    Search,
    /// Motors off; the bus belongs to the client of the transparent port, and there are no ticks.
    Passthrough,
    /// Motors off; only the dropout monitor runs.
    Off,
    /// Motors off, all monitors run: they may be driven soon.
    Armed,
    /// Motors driven by the motor check, all monitors run.
    MotorCheck,
    /// The motors may be driven.
    Drive,
    /// The motors are driven to park the arm, by the board itself.
    Park,
}

impl Permission {
    /// Whether all monitors run: motors are driven, or may be soon.
    pub const fn is_armed(self) -> bool {
        match self {
            Self::Armed | Self::MotorCheck | Self::Drive | Self::Park => true,
            Self::Search | Self::Passthrough | Self::Off => false,
        }
    }

    /// Whether a motor may be on in the next tick.
    pub const fn drives_motors(self) -> bool {
        match self {
            Self::MotorCheck | Self::Drive | Self::Park => true,
            Self::Search | Self::Passthrough | Self::Off | Self::Armed => false,
        }
    }

    /// Whether a source of torque drives the motors: one of the host, or the park.
    pub const fn is_driven(self) -> bool {
        matches!(self, Self::Drive | Self::Park)
    }
}

/// The inputs of one tick.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema, MaxSize)]
pub struct TickInput {
    /// Start of the tick on the board's clock, in µs.
    pub start_us: u64,
    /// Time in µs from the start of the tick to the planned start of the next, when the
    /// command of this tick begins to act.
    pub lead_us: u32,
    /// Permission of the supervisor.
    pub permission: Permission,
    /// Whether ticks begin with this one: the servos have been found and set up; or an arm has
    /// been parked in which the session of a host began.
    pub is_first: bool,
    /// Whether the configuration is as it was built.
    pub is_config_intact: bool,
    /// Time since the last frame of the host, in ms, rounded up.
    pub host_silent_ms: u16,
    /// Sample of each servo.
    pub samples: [Sample; JOINTS],
    /// Error byte of each stock servo in its answer; its bits are
    /// [`Alarms`](armbridge_servo::Alarms).
    pub alarms: [u8; JOINTS],
    /// PWM sent at the start of the tick, in force from there on: that of the tick before, or off.
    pub pwm_in_force: [u16; JOINTS],
}

impl TickInput {
    /// Inputs of a tick without samples, with motors off.
    pub const AT_REST: Self = Self {
        start_us: 0,
        lead_us: 0,
        permission: Permission::Off,
        is_first: false,
        is_config_intact: true,
        host_silent_ms: 0,
        samples: [Sample::Missing(Missing::NotAsked); JOINTS],
        alarms: [0; JOINTS],
        pwm_in_force: [Pwm::OFF.counts(); JOINTS],
    };

    /// Planned start of the next tick on the board's clock, in µs.
    pub const fn acts_us(&self) -> u64 {
        self.start_us.saturating_add(self.lead_us as u64)
    }
}

/// The outputs of one tick.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema, MaxSize)]
pub struct TickOutput {
    /// PWM to be sent at the start of the next tick.
    pub pwm: [u16; JOINTS],
    /// Torque in N m that `pwm` stands for, after clamp and rounding, less the friction
    /// compensation; of an arm that floats, the part of it that the model of the arm explains.
    pub torque_nm: [f32; JOINTS],
    /// Reference angles in rad, at the planned start of the next tick.
    pub reference_rad: [f32; JOINTS],
    /// Reference speeds in rad/s, at the same time.
    pub reference_speed_rad_s: [f32; JOINTS],
    /// Estimated angles in rad, at the samples.
    pub angle_rad: [f32; JOINTS],
    /// Estimated speeds in rad/s, at the samples.
    pub speed_rad_s: [f32; JOINTS],
    /// Estimated disturbance torque in N m; 0 from an estimator without disturbances.
    pub disturbance_nm: [f32; JOINTS],
    /// Limits that changed the torque.
    pub guards: Guards,
    /// Whether every joint has a sample that passed the innovation gate.
    pub is_complete: bool,
    /// Events of the tick; most have none.
    pub events: Option<TickEvents>,
}

impl TickOutput {
    /// Outputs before the first tick: motors off.
    pub const NONE: Self = Self {
        pwm: [Pwm::OFF.counts(); JOINTS],
        torque_nm: [0.0; JOINTS],
        reference_rad: [0.0; JOINTS],
        reference_speed_rad_s: [0.0; JOINTS],
        angle_rad: [0.0; JOINTS],
        speed_rad_s: [0.0; JOINTS],
        disturbance_nm: [0.0; JOINTS],
        guards: Guards::NONE,
        is_complete: false,
        events: None,
    };

    /// Violation for which the motors must be off.
    pub fn fault(&self) -> Option<Violation> {
        self.events?.fault
    }
}

/// Rare outputs of a tick.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema, MaxSize)]
pub struct TickEvents {
    /// Whether the motor check has been passed.
    pub are_motors_checked: bool,
    /// End of a drive command by the loop itself.
    pub fallback: Option<Fallback>,
    /// End of an experiment.
    pub experiment_end: Option<ExperimentEnd>,
    /// Violation for which the motors must be off.
    pub fault: Option<Violation>,
}

impl TickEvents {
    /// These events, if there is one.
    pub fn some(self) -> Option<Self> {
        let is_any = self.are_motors_checked
            || self.fallback.is_some()
            || self.experiment_end.is_some()
            || self.fault.is_some();
        is_any.then_some(self)
    }
}

/// Reaction of the loop when the host is silent, a command has expired, or an experiment or a park
/// has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema, MaxSize)]
pub enum Fallback {
    /// The reference brakes to rest; the arm is held from then on.
    Brake,
    /// The torque is switched off.
    Release,
    /// The arm is parked.
    Park,
    /// The arm has been parked: disarmed.
    Parked,
}

/// Fault found by a monitor, with its magnitude.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema, MaxSize)]
pub struct Violation {
    /// Fault.
    pub fault: Fault,
    /// Joint, counting from 0, if the fault concerns one.
    pub joint: Option<u8>,
    /// Observed value, in the unit of the limit.
    pub value: f32,
    /// Limit.
    pub limit: f32,
}

impl Violation {
    /// A violation without joint and values.
    pub const fn plain(fault: Fault) -> Self {
        Self {
            fault,
            joint: None,
            value: 0.0,
            limit: 0.0,
        }
    }
}

/// Timing of a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, Schema, MaxSize)]
pub struct Timing {
    /// Actual minus planned start, in µs.
    pub start_error_us: u32,
    /// From the first bit of the tick's request to the last of the replies, in µs.
    pub bus_us: u32,
    /// Estimator, controller and supervisor, in ns; 0 where not measured.
    pub compute_ns: u32,
    /// Ticks skipped so far because the one before was not done.
    pub missed: u32,
}
