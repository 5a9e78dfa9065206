//! Messages between board and host.
//!
//! Every type here is encoded by postcard; their schema is hashed into the
//! [`Hello`] of both sides, so that two builds that would misread each other
//! detect it before any other message.
//!
//! Commands are *states, not events*: "regulate about this reference" may be
//! repeated, lost and repeated again without harm. Each is acknowledged by the
//! sequence number of the frame that carried it.

pub use super::board::{BoardReport, End, LastEnd, SettingsFrom, SettingsGroups, Stack};
use super::experiment::{Conclusion, Experiment, Objection, Role};
pub use super::fault::{Fault, StopSource};
pub use super::limits::Limits;
pub use super::mode::{Drive, Guards, Mode, OffReport, OffState, Trip};
use super::motion::Motion;
pub use super::record::{Record, TickInput, TickOutput, Timing};
pub use super::setup::{Controller, FRICTION_LOAD_PERCENT_MAX, Gains, Settings, Setup};
pub use armbridge_servo::{Missing, Sample};

use armbridge_control::trajectory::Quantity;
use armbridge_servo::{Firmware, JOINTS};
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
    /// Emergency stop, with or without a session.
    Stop,
    /// The host leaves: disarm, which is no fault.
    Goodbye,
    /// A state the host wants the board to be in.
    Command(Command),
}

/// From board to host.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema, MaxSize)]
pub enum ToHost {
    /// Answer to the host's hello.
    Hello(Hello),
    /// Result of the command with this frame sequence number.
    Ack {
        /// Sequence number of the frame that carried the command.
        sequence: u16,
        /// Accepted, or the refusal.
        result: Result<(), Refusal>,
        /// Moment at which the tick took it; `None` if it did not reach the tick.
        moment: Option<Moment>,
    },
    /// The reference from which the motion with this frame sequence number is
    /// planned was taken at this moment; its acknowledgement follows.
    Departs {
        /// Sequence number of the frame that carried the command.
        sequence: u16,
        /// Moment at which the start was taken.
        moment: Moment,
    },
    /// The tick has received the hello: motors are off, the estimator restarts.
    Began(Moment),
    /// Settings in force: after a hello, and after every change.
    Settings(Settings),
    /// During bring-up: a servo did not answer.
    Absent {
        /// Index of the joint.
        joint: u8,
        /// Reason for the missing reply.
        missing: Missing,
    },
    /// The servos were found, with their firmware and speed. Also answers a hello, if they
    /// were found before it.
    Found {
        /// Firmware of both servos.
        firmware: Firmware,
        /// Speed of the bus in bits per second.
        baud: u32,
        /// Whether torque can be commanded; stock servos need [`Command::Prepare`] before.
        is_ready: bool,
    },
    /// During bring-up: the servos run different firmwares, joint by joint. They
    /// disturb each other; the bridge drives neither.
    Mixed([Firmware; JOINTS]),
    /// The stock servo of this joint answers, but rejects its settings.
    Unprepared {
        /// Index of the joint.
        joint: u8,
    },
    /// A client on the transparent port has the bus: no records are sent.
    Passthrough,
    /// Counters of a client's packets on the transparent port.
    Port(PortCounters),
    /// The board's report on itself.
    Board(BoardReport),
    /// Cause of a fault; also after a hello, while it is latched.
    Tripped(Trip),
    /// Evidence on motors that must be off.
    Off(OffReport),
    /// End of an experiment, unless by a fault or a goodbye: sent once.
    Concluded(Conclusion),
    /// A servo's temperature, as polled with torque on or off.
    Temperature {
        /// Index of the joint.
        joint: u8,
        /// In °C from a stock servo, in counts of its converter from Morpheus.
        value: u16,
    },
    /// One tick.
    Record(Record),
}

/// The moment at which the tick took a command, exactly enough for replay to take it then
/// again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema, MaxSize)]
pub struct Moment {
    /// The tick that had begun last.
    pub tick: u32,
    /// Whether it was decided by then; otherwise the command affects it.
    pub is_decided: bool,
    /// Time on the board's clock in µs.
    pub at_us: u64,
    /// Mode until then.
    pub mode: Mode,
}

/// Packets on the transparent port since boot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, Schema, MaxSize)]
pub struct PortCounters {
    /// Packets sent on the bus, or answered by the board itself.
    pub passed: u32,
    /// Number of those that waited for an idle slot of a later tick.
    pub delayed: u32,
    /// Packets not sent, because a control loop runs.
    pub refused: u32,
    /// Packets that the client began and did not end.
    pub halves: u32,
    /// Bytes that the client did not fetch in time.
    pub lost: u32,
    /// Number of times the bus was taken back from a silent client.
    pub ended: u32,
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
    /// Disarm: torque off; the bus is still read. Takes the bus back from the
    /// transparent port.
    Idle,
    /// Arm from idle, with zero torque. The session number proves that the host knows of the
    /// board's last reset.
    Arm {
        /// Session of [`BoardReport`].
        session: u32,
    },
    /// Constant joint torques in N m, clamped to what the servos can do.
    Torque([f32; JOINTS]),
    /// Hold the arm at these joint angles in rad: a step, if it is elsewhere.
    Regulate([f32; JOINTS]),
    /// Follow a motion, from wherever the reference is; it begins some ticks
    /// later, when it is planned. Repeated, it restarts, without a step.
    Follow(Motion),
    /// A point of a reference that the host streams: angles in rad, at a time of
    /// the board's clock.
    Stream {
        /// Time, in µs.
        at_us: u64,
        /// Angles, in rad.
        angle_rad: [f32; JOINTS],
        /// Speeds, in rad/s; `None` to compute them from the neighbouring points.
        speed_rad_s: Option<[f32; JOINTS]>,
    },
    /// Run an experiment from the present state of the arm; it begins with the next
    /// tick, and ends by itself in [`Drive::Hold`]. The same command while it runs
    /// has no effect; any other drive ends it.
    Experiment(Experiment),
    /// Make the arm weightless where it is, so that a hand leads it; see
    /// [`float`](armbridge_control::controller::float).
    Float,
    /// Park the arm: brake, move to the pose of [`Limits::park`], lower the arm until nothing
    /// holds it any more, then disarm. Without a pose, and where nothing drives the arm, as
    /// [`Command::Idle`].
    Park,
    /// Set stock servos to wheel mode and a short return delay, where they are
    /// not: both are kept in their EEPROM. Torque can be asked for when they are
    /// reported found again, and ready. Nothing to do on Morpheus servos.
    Prepare,
    /// Give stock servos back the mode and the return delay they were found with,
    /// and leave the bus to the transparent port.
    Release,
    /// Leave [`Mode::Fault`]: bring-up, then [`Mode::Idle`].
    ClearFault,
    /// Replace the set-up. While torque is on it is taken over without a step in
    /// the torque, and only period and calibration of the servos must stay.
    Configure(Setup),
    /// Replace the limits, while idle.
    Limit(Limits),
    /// Keep set-up and limits across power-off, while idle. Confirms them, after saved ones
    /// were lost.
    Save,
}

impl Command {
    /// First number other than 0 that it asks of a joint: an angle in rad, a speed in rad/s, a torque
    /// in N m; infinity of the signal of an experiment.
    pub fn demand_of(&self, joint: usize) -> Option<f32> {
        let numbers = match self {
            Self::Torque(values) | Self::Regulate(values) => [values.get(joint).copied(), None],
            Self::Follow(motion) => [motion.demand_of(joint), None],
            Self::Stream {
                angle_rad,
                speed_rad_s,
                ..
            } => [
                angle_rad.get(joint).copied(),
                speed_rad_s.and_then(|speeds| speeds.get(joint).copied()),
            ],
            Self::Experiment(plan) => {
                let signal = plan.roles.get(joint).and_then(Role::signal);
                [signal.map(|_| f32::INFINITY), None]
            }
            Self::Float
            | Self::Idle
            | Self::Park
            | Self::Arm { .. }
            | Self::Prepare
            | Self::Release
            | Self::ClearFault
            | Self::Configure(_)
            | Self::Limit(_)
            | Self::Save => [None, None],
        };
        numbers.into_iter().flatten().find(|number| *number != 0.0)
    }

    /// Whether it drives the arm, which has to be armed.
    pub const fn is_drive(&self) -> bool {
        match self {
            Self::Torque(_)
            | Self::Regulate(_)
            | Self::Follow(_)
            | Self::Stream { .. }
            | Self::Experiment(_)
            | Self::Float => true,
            Self::Idle
            | Self::Park
            | Self::Arm { .. }
            | Self::Prepare
            | Self::Release
            | Self::ClearFault
            | Self::Configure(_)
            | Self::Limit(_)
            | Self::Save => false,
        }
    }
}

/// Reason for the refusal of a command.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema, MaxSize)]
pub enum Refusal {
    /// A fault is latched; send [`Command::ClearFault`] first.
    Faulted,
    /// Servos are still being brought up, or do not answer.
    NotReady,
    /// After a stop, motors have not been seen to be off, and the host has not been notified
    /// which are not: send it again. That takes 0.3 s at most.
    NotOff,
    /// The board is not armed; send [`Command::Arm`] first.
    Disarmed,
    /// The board has been reset since; its report has the session.
    OtherSession,
    /// The frame is older than one that was executed.
    Stale,
    /// Period, calibration and limits can only be replaced, settings saved and servos
    /// released, when idle; the set-up not while an experiment runs.
    NotIdle,
    /// The settings could not be kept: the memory is full until the next reset, or
    /// does not work.
    NotSaved,
    /// The saved settings, or some of them, are lost, and others are in force:
    /// [`BoardReport`] has which. [`Command::Save`] confirms those in force.
    SettingsLost,
    /// A servo is too hot to be armed, or has not cooled since its fault.
    Hot {
        /// This joint, counting from 0.
        joint: u8,
    },
    /// An encoder has not yet given the samples at rest, 48 of them, that show its noise: one
    /// that stops would go unnoticed. Send it again.
    EncoderUnknown {
        /// This joint, counting from 0.
        joint: u8,
    },
    /// The arm stands beyond an angle limit: move it by hand, or check zero and direction of
    /// the joint.
    BeyondLimit {
        /// This joint, counting from 0.
        joint: u8,
    },
    /// The motors cannot be checked at periods above 10 ms, for the arm would fall meanwhile.
    /// Check them at a shorter period, or arm without the check by `limits.check_rad_s2` 0.
    MotorsUnchecked,
    /// Stock servos as they come take no torque: send [`Command::Prepare`] first.
    Unprepared,
    /// A client on the transparent port has the bus; [`Command::Idle`] takes it
    /// back.
    Passthrough,
    /// The servos cannot be asked so often: the shortest period in µs.
    TooFast {
        /// At the bus's speed and with this firmware.
        least_us: u32,
    },
    /// Ticks are too rare for an arm that floats: the longest period in µs.
    TooSlow {
        /// Of a float.
        most_us: u32,
    },
    /// A motion would go beyond what the arm is allowed.
    Beyond {
        /// This joint, counting from 0.
        joint: u8,
        /// Quantity that exceeds its bound.
        quantity: Quantity,
        /// Value, in the quantity's unit.
        value: f32,
        /// Bound of its magnitude.
        limit: f32,
    },
    /// An experiment is invalid, or cannot begin from the present state.
    Experiment(Objection),
    /// The time of a streamed point is not a tick, 1 ms at least, after that of the point
    /// before it and of the next reference.
    Late {
        /// Time in µs by which it would have to be later.
        by_us: u32,
    },
    /// A number is not finite or outside its range.
    OutOfRange,
    /// No gains exist for this set-up: the Riccati iteration did not converge.
    NoGains,
    /// The closed loop would grow: its largest eigenvalue.
    Unstable {
        /// Real part, in z.
        re: f32,
        /// Imaginary part, in z; its conjugate is one too.
        im: f32,
    },
    /// The observer's error would grow: its largest eigenvalue.
    UnstableObserver {
        /// Real part, in z.
        re: f32,
        /// Imaginary part, in z; its conjugate is one too.
        im: f32,
    },
    /// A queue is full, that of commands or that of a stream's points: send it again.
    Busy,
    /// A joint's calibration is that of another kind of servo than was found: set its zero and
    /// its angle of a count.
    OtherEncoder {
        /// This joint, counting from 0.
        joint: u8,
    },
}
