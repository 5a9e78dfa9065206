//! What board and host say to each other.
//!
//! Every type here is encoded by postcard; their schema is hashed into the
//! [`Hello`] of both sides, so that two builds that would misread each other
//! find out before anything else is said.
//!
//! Commands are *states, not events*: "regulate about this reference" may be
//! repeated, lost and repeated again without harm. Each is acknowledged by the
//! sequence number of the frame that carried it.

use crate::JOINTS;
use postcard::experimental::max_size::MaxSize;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// From host to board.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema, MaxSize)]
pub enum ToBoard {
    /// Opens a session; the board answers with its own.
    Hello(Hello),
    /// The host is alive. Any accepted message counts as one.
    Heartbeat,
    /// A state the host wants the board to be in.
    Command(Command),
}

/// From board to host.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema, MaxSize)]
pub enum ToHost {
    /// Answer to the host's hello.
    Hello(Hello),
    /// What became of the command with this frame sequence number.
    Ack {
        /// Sequence number of the frame that carried the command.
        sequence: u16,
        /// Accepted, or why not.
        result: Result<(), Refusal>,
    },
    /// During bring-up: a servo was asked for and did not answer.
    Absent {
        /// Index of the joint.
        joint: u8,
        /// What was heard instead.
        missing: Missing,
    },
    /// One tick.
    Record(Record),
}

/// Identity of one end of the link.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema, MaxSize)]
pub struct Hello {
    /// Hash over the schema of [`ToBoard`] and [`ToHost`].
    pub schema: [u8; 8],
    /// Version of this crate, major, minor, patch.
    pub version: [u8; 3],
}

/// A state the board shall be in.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema, MaxSize)]
pub enum Command {
    /// Torque off; the bus is still read.
    Idle,
    /// Constant joint torques in N m, clamped to what the servos can do.
    Torque([f32; JOINTS]),
    /// Hold the arm at these joint angles in rad, by state feedback.
    Regulate([f32; JOINTS]),
    /// Leave [`Mode::Fault`] for [`Mode::Idle`].
    ClearFault,
    /// Replace the set-up; refused unless idle.
    Configure(Setup),
}

/// Why a command was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema, MaxSize)]
pub enum Refusal {
    /// A fault is latched; send [`Command::ClearFault`] first.
    Faulted,
    /// Servos are still being brought up, or do not answer.
    NotReady,
    /// The set-up can only be replaced when idle.
    NotIdle,
    /// A number is not finite or outside its range.
    OutOfRange,
    /// No gains exist for this set-up: the Riccati iteration did not converge.
    NoGains,
    /// A command queue is full; send it again.
    Busy,
}

/// What the application computes with, replaced as one atomic group.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema, MaxSize)]
pub struct Setup {
    /// Tick period in µs.
    pub period_us: u32,
    /// State feedback.
    pub gains: Gains,
    /// Where joint speeds come from.
    pub estimator: Estimator,
    /// Add the dead-zone half width to every torque (equation (5), 50 counts).
    pub compensate_dead_zone: bool,
}

impl Default for Setup {
    /// 1 kHz, the paper's weights (8), and an observer with time constants of
    /// 15 and 16 ms: little noise in the torque, little damping lost.
    fn default() -> Self {
        Self {
            period_us: 1_000,
            gains: Gains::Design {
                q: [15.0, 15.0, 1.0, 1.0],
                r: [10.0, 10.0],
            },
            estimator: Estimator::Luenberger {
                poles_45ms: [[0.05, 0.06]; JOINTS],
            },
            compensate_dead_zone: false,
        }
    }
}

/// Where the state-feedback gain comes from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema, MaxSize)]
pub enum Gains {
    /// The printed gain, equation (10), meant for 45 ms.
    Paper,
    /// Designed on the board for the running period from diagonal weights.
    Design {
        /// Diagonal of Q: both angles, both speeds (equation (8)).
        q: [f32; 2 * JOINTS],
        /// Diagonal of R: both torques (equation (8)).
        r: [f32; JOINTS],
    },
}

/// Where joint speeds come from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema, MaxSize)]
pub enum Estimator {
    /// Backward difference through a first-order low pass.
    FiniteDifference {
        /// Time constant of the low pass in s; 0 leaves the plain difference.
        filter_s: f32,
    },
    /// Observer (11) in current form on the exact discretisation, poles per
    /// joint given at 45 ms and mapped to the running period.
    Luenberger {
        /// Two real poles in (0, 1) for each joint, at a period of 45 ms.
        poles_45ms: [[f32; 2]; JOINTS],
    },
}

/// What the application is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, Schema, MaxSize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Mode {
    /// Stop sequence, then START: servos are being found.
    BringUp,
    /// Torque off, reading.
    Idle,
    /// Constant torque.
    Torque,
    /// State feedback about a reference.
    Regulate,
    /// Torque off and latched.
    Fault(Fault),
}

/// Why the supervisor switched torque off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, Schema, MaxSize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Fault {
    /// No valid frame from the host for too long.
    HostSilent,
    /// Too many samples in a row were missing.
    SamplesLost,
    /// A joint left its angle limit.
    AngleLimit,
    /// A tick took longer than its period.
    Overrun,
    /// The control law produced something that is not a number.
    NotFinite,
}

/// One tick: inputs, outputs, and what it took.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema, MaxSize)]
pub struct Record {
    /// Number of the tick since boot.
    pub tick: u32,
    /// Start of the tick on the board's clock.
    pub start_us: u64,
    /// Mode in which the tick was decided.
    pub mode: Mode,
    /// What each servo answered.
    pub samples: [Sample; JOINTS],
    /// PWM sent at the start of this tick; in force from here on.
    pub pwm_in_force: [u16; JOINTS],
    /// PWM decided in this tick, to be sent in the next.
    pub pwm_next: [u16; JOINTS],
    /// Reference angles in rad.
    pub reference_rad: [f32; JOINTS],
    /// Estimated angles in rad.
    pub angle_rad: [f32; JOINTS],
    /// Estimated speeds in rad/s.
    pub speed_rad_s: [f32; JOINTS],
    /// Torque in N m that `pwm_next` stands for, after clamp and rounding, less
    /// what dead-zone compensation adds.
    pub torque_nm: [f32; JOINTS],
    /// What the tick took.
    pub timing: Timing,
    /// Records dropped so far because the host did not fetch them in time.
    pub dropped: u32,
}

/// How long a tick took.
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

/// What a servo answered when asked for its position.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema, MaxSize)]
pub enum Sample {
    /// Position in encoder counts, 0..=1023.
    Counts(u16),
    /// Nothing to use, and why.
    Missing(Missing),
}

impl Sample {
    /// The counts, if there are any.
    pub fn counts(self) -> Option<u16> {
        match self {
            Self::Counts(counts) => Some(counts),
            Self::Missing(_) => None,
        }
    }
}

/// Kinds of missing samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, Schema, MaxSize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Missing {
    /// Not asked.
    NotAsked,
    /// Nothing was heard.
    Silence,
    /// Only our own request was heard.
    EchoOnly,
    /// A reply with a wrong checksum.
    BadChecksum,
    /// A reply from another servo.
    WrongId,
    /// A reply ended early.
    Short,
    /// The receiver reported framing, noise or overrun.
    Line,
}
