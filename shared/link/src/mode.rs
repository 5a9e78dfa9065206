//! Modes of the board.

use super::fault::Fault;
use postcard::experimental::max_size::MaxSize;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Mode of the board.
///
/// Torque is on in [`Mode::MotorCheck`], [`Mode::Armed`], [`Mode::Running`] and
/// [`Mode::Degraded`], and in no other mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, Schema, MaxSize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Mode {
    /// Stop sequence, then the search for the servos.
    Boot,
    /// Disarmed: motors off, angles read.
    Idle,
    /// Direction and joint of each motor are tested, before the first command.
    MotorCheck,
    /// Ready to move: zero torque.
    Armed,
    /// The motors are driven.
    Running(Drive),
    /// The motors are driven, with a sample missing: the estimator predicts.
    Degraded(Drive),
    /// The bus belongs to the client of the transparent port: no ticks.
    Passthrough,
    /// Motors off, latched until the host clears it.
    Fault(Fault),
}

impl Mode {
    /// Source that drives the motors, if they are driven.
    pub const fn drive(self) -> Option<Drive> {
        match self {
            Self::Running(drive) | Self::Degraded(drive) => Some(drive),
            Self::Boot
            | Self::Idle
            | Self::MotorCheck
            | Self::Armed
            | Self::Passthrough
            | Self::Fault(_) => None,
        }
    }

    /// Whether a motor may be on.
    pub const fn is_on(self) -> bool {
        matches!(
            self,
            Self::MotorCheck | Self::Running(_) | Self::Degraded(_)
        )
    }

    /// Whether the motors may be driven.
    pub const fn is_armed(self) -> bool {
        match self {
            Self::MotorCheck | Self::Armed | Self::Running(_) | Self::Degraded(_) => true,
            Self::Boot | Self::Idle | Self::Passthrough | Self::Fault(_) => false,
        }
    }
}

/// Source that drives the motors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, Schema, MaxSize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Drive {
    /// Constant torque.
    Torque,
    /// Holding a reference that only the host changes.
    Regulate,
    /// Following a motion or a stream.
    Track,
    /// Braked to rest and holding, because the host went silent or an experiment is
    /// over.
    Hold,
    /// The signals of an experiment.
    Experiment,
    /// Weightless: a hand leads the arm, which stays where it is left.
    Float,
    /// The board's own motion to the pose in which the arm is parked, and its lowering there.
    Park,
}

impl Drive {
    /// Whether a controller holds the arm at a reference.
    pub const fn is_closed_loop(self) -> bool {
        match self {
            Self::Regulate | Self::Track | Self::Hold | Self::Park => true,
            Self::Torque | Self::Experiment | Self::Float => false,
        }
    }
}

/// Trip of the supervisor: the first cause, with its values.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema, MaxSize)]
pub struct Trip {
    /// Fault.
    pub fault: Fault,
    /// Joint, counting from 0, if the fault concerns one.
    pub joint: Option<u8>,
    /// Tick of the fault.
    pub tick: u32,
    /// Time on the board's clock in µs.
    pub at_us: u64,
    /// Observed value, in the unit of the limit.
    pub value: f32,
    /// Limit.
    pub limit: f32,
}

/// Report on motors that must be off: after a fault, and whenever one is not seen to be
/// off for long.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema, MaxSize)]
pub struct OffReport {
    /// Number of stop sequences sent.
    pub stops: u16,
    /// Evidence on each joint's motor.
    pub joints: [OffState; armbridge_servo::JOINTS],
}

/// Evidence on a motor that must be off. A joint at rest is none: it may be driven
/// against an obstacle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema, MaxSize)]
pub enum OffState {
    /// Its servo's registers read back as off.
    Off,
    /// It has been commanded off, and answers, but its registers have not shown it.
    Unconfirmed,
    /// Its servo does not answer.
    OutOfReach,
}

/// Limits that changed the torque, as bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, Schema, MaxSize)]
pub struct Guards(u8);

impl Guards {
    /// No limit.
    pub const NONE: Self = Self(0);
    /// A joint was braked before its angle limit.
    pub const BRAKED: Self = Self(1 << 0);
    /// The torque was more than its limit.
    pub const TORQUE: Self = Self(1 << 1);
    /// The torque changed faster than its limit.
    pub const RATE: Self = Self(1 << 2);
    /// The PWM was more than its limit.
    pub const PWM: Self = Self(1 << 3);

    /// The byte that a record carries.
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// Decodes the byte.
    pub const fn from_bits(bits: u8) -> Self {
        Self(bits)
    }

    /// Whether all of `guards` are set.
    pub const fn contains(self, guards: Self) -> bool {
        self.0 & guards.0 == guards.0
    }

    /// Limits that are in either.
    #[must_use]
    pub const fn or(self, guards: Self) -> Self {
        Self(self.0 | guards.0)
    }
}
