//! Host of a case: configures and arms the board, starts the activity and keeps it up, keeps
//! the session alive, injects the host's own faults, and clears the board's fault at the end.
//!
//! It never ends by itself; the board's messages are stored for the checks.

use std::convert::Infallible;

use armbridge_client::Host;
use armbridge_client::session::{BoardMessage, CommandLink};
use armbridge_link::frame::Encoder;
use armbridge_link::message::{
    BoardReport, Command, Hello, Limits, Mode, OffReport, Record, Refusal, Settings, ToBoard,
    ToHost, Trip,
};
use armbridge_link::schema;
use armbridge_servo::JOINTS;

use super::activity::Activity;
use super::case::Case;
use super::invalid_commands::out_of_range;
use super::stream_path::{StreamPath, is_followed};

/// Period of a faulty host's messages, in µs: that of a good one.
const FAULT_US: u64 = 25_000;
/// Period of a stream's points, of saves, and of a torque that is repeated, in µs.
const POINT_US: u64 = 20_000;
const SAVE_US: u64 = 100_000;
const TORQUE_US: u64 = 500_000;
/// Time after which a fault is cleared again that could not be yet, in µs.
const CLEAR_US: u64 = 20_000;
/// Time in µs by which a streamed point is ahead: more than a lost frame takes.
const AHEAD_US: u64 = 200_000;
/// Faults of the host itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum HostFault {
    /// None.
    None,
    /// Its hello has another schema, and its commands cannot be decoded.
    OtherSchema,
    /// It commands numbers that are out of range.
    OutOfRange,
    /// It sends a goodbye, and then nothing.
    Goodbye,
    /// It sends nothing.
    Silent,
    /// It sends heartbeats only.
    Heartbeats,
}

/// Progress of the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Connecting,
    SettingUp,
    Limiting,
    Waiting,
    Preparing,
    Arming,
    Commanding,
    Working,
    /// A command was refused.
    Refused,
    Clearing,
    Cleared,
}

/// The host of a case.
#[derive(Debug)]
pub(super) struct Driver {
    client: CommandLink,
    /// Parameters and limits that it sets, if any.
    settings: Option<Settings>,
    activity: Activity,
    /// Target angles or amplitudes in rad.
    to_rad: [f32; JOINTS],
    command: Option<Command>,
    next_repeat_us: u64,
    stream: Option<StreamPath>,
    phase: Phase,
    fault: HostFault,
    next_fault_us: u64,
    /// Encoder of the frames in another schema.
    other_encoder: Encoder,
    faulty_bytes: Vec<u8>,
    turn: usize,
    /// The board's latest report on itself.
    pub(super) board: Option<BoardReport>,
    /// Whether the servos accept torque; `None` before they are found.
    is_ready: Option<bool>,
    /// The board's report of the latest fault.
    pub(super) trip: Option<Trip>,
    /// The board's report of the servos after that.
    pub(super) off: Option<OffReport>,
    /// The latest record.
    pub(super) record: Option<Record>,
    /// Largest torque of all records, in N m.
    pub(super) max_torque_nm: f32,
    /// Accepted commands that were out of range.
    pub(super) accepted_invalid: u32,
    /// The refusal for which it gave up.
    pub(super) refusal: Option<Refusal>,
    /// Time of the last command of a torque, in µs.
    pub(super) torque_us: u64,
    /// Time of the last command to arm, in µs.
    pub(super) armed_us: Option<u64>,
    /// Time of the latest message from the board, in µs.
    now_us: u64,
}

impl Driver {
    /// The host of a case.
    pub(super) fn new(case: &Case) -> Self {
        let settings = Settings {
            setup: case.setup(),
            limits: case.limits(),
        };
        Self {
            client: CommandLink::default(),
            settings: case.is_configured().then_some(settings),
            activity: case.activity,
            to_rad: case.to_rad,
            command: case.command(),
            next_repeat_us: 0,
            stream: None,
            phase: Phase::Connecting,
            fault: HostFault::None,
            next_fault_us: 0,
            other_encoder: Encoder::default(),
            faulty_bytes: Vec::new(),
            turn: 0,
            board: None,
            is_ready: None,
            trip: None,
            off: None,
            record: None,
            max_torque_nm: 0.0,
            accepted_invalid: 0,
            refusal: None,
            torque_us: 0,
            armed_us: None,
            now_us: 0,
        }
    }

    /// Whether the activity runs, as far as the host starts it.
    pub(super) fn is_working(&self) -> bool {
        let is_streamed =
            self.activity != Activity::Stream || self.record.as_ref().is_some_and(is_followed);
        self.phase == Phase::Working && is_streamed
    }

    /// Sends `heartbeats` heartbeats and a hello in one write.
    pub(super) fn burst(&mut self, heartbeats: usize) {
        for _ in 0..heartbeats {
            self.client.send(ToBoard::Heartbeat);
        }
        self.client.send(ToBoard::Hello(schema::HELLO));
    }

    /// Requests an emergency stop.
    pub(super) fn stop(&mut self) {
        self.client.send(ToBoard::Stop);
    }

    pub(super) fn inject(&mut self, fault: HostFault) {
        if fault == HostFault::None && self.fault != HostFault::None {
            // A new session begins with a hello.
            self.client = CommandLink::default();
        }
        self.fault = fault;
        self.next_fault_us = 0;
    }

    /// Requests that the board leaves its fault.
    pub(super) fn clear(&mut self) {
        self.phase = Phase::Clearing;
        self.client.command(Command::ClearFault);
    }

    fn send_command(&mut self, phase: Phase, command: Command) {
        self.phase = phase;
        self.client.command(command);
    }

    fn process(&mut self, message: &BoardMessage) {
        match (message, self.phase) {
            // A board that has restarted is configured again, unless the activity ran.
            (
                BoardMessage::Hello(_),
                Phase::Connecting
                | Phase::SettingUp
                | Phase::Limiting
                | Phase::Waiting
                | Phase::Preparing
                | Phase::Arming,
            ) => match self.settings {
                Some(Settings { setup, .. }) => {
                    self.send_command(Phase::SettingUp, Command::Configure(setup));
                }
                None => self.phase = Phase::Waiting,
            },
            (BoardMessage::Done, Phase::SettingUp) => {
                let limits = self.settings.map_or_else(Limits::default, |it| it.limits);
                self.send_command(Phase::Limiting, Command::Limit(limits));
            }
            (BoardMessage::Done, Phase::Limiting) => self.phase = Phase::Waiting,
            (BoardMessage::Done, Phase::Arming) => {
                self.armed_us = Some(self.now_us);
                match self.command {
                    Some(command) => self.send_command(Phase::Commanding, command),
                    None => self.phase = Phase::Working,
                }
            }
            (BoardMessage::Done, Phase::Commanding) => {
                self.torque_us = self.now_us;
                self.phase = Phase::Working;
            }
            (BoardMessage::Done, Phase::Clearing) => self.phase = Phase::Cleared,
            (BoardMessage::Done, Phase::Working) if self.fault == HostFault::OutOfRange => {
                self.accepted_invalid += 1;
            }
            (
                BoardMessage::Refused(refusal),
                Phase::SettingUp | Phase::Limiting | Phase::Arming | Phase::Commanding,
            ) => {
                self.refusal = Some(*refusal);
                self.phase = Phase::Refused;
            }
            (BoardMessage::Refused(Refusal::NotOff | Refusal::Hot { .. }), Phase::Clearing) => {
                self.next_repeat_us = self.now_us + CLEAR_US;
            }
            (BoardMessage::Other(ToHost::Board(report)), _) => self.board = Some(*report),
            (BoardMessage::Other(ToHost::Tripped(trip)), _) => self.trip = Some(*trip),
            (BoardMessage::Other(ToHost::Off(report)), _) => self.off = Some(*report),
            (BoardMessage::Other(ToHost::Found { is_ready, .. }), _) => {
                self.is_ready = Some(*is_ready);
            }
            (BoardMessage::Other(ToHost::Record(record)), phase) => {
                self.record = Some(*record);
                let torques = record.output.torque_nm.iter();
                self.max_torque_nm =
                    torques.fold(self.max_torque_nm, |most, nm| most.max(nm.abs()));
                if record.mode == Mode::Idle {
                    self.arm_when_ready(phase);
                }
            }
            _ => {}
        }
    }

    /// Arms the idle board if its servos are ready, and requests the configuration of stock
    /// servos if they are not.
    fn arm_when_ready(&mut self, phase: Phase) {
        match (phase, self.is_ready) {
            // The client makes the servos ready, and a command would keep it off the bus.
            (Phase::Waiting, Some(_)) if self.activity == Activity::Port => {
                self.phase = Phase::Working;
            }
            (Phase::Waiting, Some(false)) => self.send_command(Phase::Preparing, Command::Prepare),
            (Phase::Waiting | Phase::Preparing, Some(true)) if self.activity.is_armed() => {
                let session = self.board.map_or(0, |board| board.session);
                self.send_command(Phase::Arming, Command::Arm { session });
            }
            (Phase::Waiting | Phase::Preparing, Some(true)) => self.phase = Phase::Working,
            _ => {}
        }
    }

    /// Period of what the host repeats to keep the activity up, in µs.
    fn repeat_period_us(&self) -> Option<u64> {
        if self.phase == Phase::Clearing && self.client.is_settled() {
            return Some(CLEAR_US);
        }
        let is_at_it = self.phase == Phase::Working && self.fault == HostFault::None;
        match self.activity {
            Activity::Stream => Some(POINT_US),
            Activity::Save => Some(SAVE_US),
            Activity::Torque => Some(TORQUE_US),
            _ => None,
        }
        .filter(|_| is_at_it)
    }

    /// Repeats what keeps the activity up.
    fn repeat(&mut self, now_us: u64) {
        let Some(period_us) = self.repeat_period_us() else {
            return;
        };
        if now_us < self.next_repeat_us {
            return;
        }
        self.next_repeat_us = now_us + period_us;
        if self.phase == Phase::Clearing {
            return self.client.command(Command::ClearFault);
        }
        match (self.activity, self.command, self.record) {
            (Activity::Stream, _, Some(record)) => {
                let at_us = record.input.start_us + AHEAD_US;
                let path = StreamPath::next(self.stream, at_us, &record);
                self.stream = Some(path);
                self.client.command(Command::Stream {
                    at_us,
                    angle_rad: path.angle_rad(self.to_rad, at_us),
                    speed_rad_s: None,
                });
            }
            (Activity::Save, ..) => self.client.command(Command::Save),
            (Activity::Torque, Some(command), _) => {
                self.torque_us = now_us;
                self.client.command(command);
            }
            _ => {}
        }
    }

    /// Sends the messages of the fault.
    fn send_fault(&mut self) {
        self.turn += 1;
        match self.fault {
            HostFault::None | HostFault::Silent | HostFault::Heartbeats => {}
            HostFault::Goodbye => self.client.send(ToBoard::Goodbye),
            HostFault::OtherSchema => {
                let hello = Hello {
                    schema: schema::HASH.map(|byte| !byte),
                    ..schema::HELLO
                };
                for message in [ToBoard::Hello(hello), ToBoard::Heartbeat] {
                    let (_, frame) = self.other_encoder.encode(&message);
                    self.faulty_bytes.extend_from_slice(frame);
                }
            }
            HostFault::OutOfRange => self.client.command(out_of_range(self.turn)),
        }
    }
}

impl Host for Driver {
    type Error = Infallible;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], Infallible> {
        self.faulty_bytes.clear();
        if self.fault != HostFault::None && now_us >= self.next_fault_us {
            self.next_fault_us = now_us + FAULT_US;
            self.send_fault();
        }
        match self.fault {
            HostFault::OtherSchema | HostFault::Silent => return Ok(&self.faulty_bytes),
            HostFault::Goodbye => self.fault = HostFault::Silent,
            HostFault::None | HostFault::OutOfRange | HostFault::Heartbeats => {}
        }
        self.repeat(now_us);
        Ok(self.client.transmit(now_us))
    }

    fn receive(&mut self, now_us: u64, mut bytes: &[u8]) -> Result<(), Infallible> {
        self.now_us = now_us;
        while let Some(message) = self.client.receive(&mut bytes) {
            self.process(&message);
        }
        Ok(())
    }

    fn wake_at_us(&self) -> u64 {
        match self.fault {
            HostFault::None | HostFault::Heartbeats => match self.repeat_period_us() {
                Some(_) => self.next_repeat_us.min(self.client.wake_at_us()),
                None => self.client.wake_at_us(),
            },
            HostFault::Silent => u64::MAX,
            HostFault::OtherSchema => self.next_fault_us,
            HostFault::OutOfRange | HostFault::Goodbye => {
                self.next_fault_us.min(self.client.wake_at_us())
            }
        }
    }

    fn is_done(&self) -> bool {
        false
    }
}
