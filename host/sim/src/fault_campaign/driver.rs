//! Host of a case: brings the board up, starts the scenario, keeps the session alive,
//! injects the host's own faults, and clears the board's fault at the end.
//!
//! It never ends by itself; the board's messages are stored for the checks.

use std::convert::Infallible;

use armbridge_client::Host;
use armbridge_client::session::{BoardMessage, CommandLink};
use armbridge_shared::JOINTS;
use armbridge_shared::experiment::Signal;
use armbridge_shared::link::experiment::{Experiment, Role};
use armbridge_shared::link::frame::Encoder;
use armbridge_shared::link::message::{
    Command, Hello, Limits, Mode, OffReport, Record, Refusal, Setup, ToBoard, ToHost, Trip,
};
use armbridge_shared::link::schema;

/// Period of a faulty host's messages, in µs: that of a good one.
const FAULT_US: u64 = 25_000;

/// From the refusal to clear a fault, because a servo is hot, to the next attempt, in µs.
const CLEAR_AGAIN_US: u64 = 100_000;

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
    Clearing,
}

/// The host of a case.
#[derive(Debug)]
pub(super) struct Driver {
    client: CommandLink,
    setup: Setup,
    limits: Limits,
    command: Option<Command>,
    arms: bool,
    phase: Phase,
    fault: HostFault,
    next_fault_us: u64,
    /// Encoder of the frames in another schema.
    other_encoder: Encoder,
    faulty_bytes: Vec<u8>,
    turn: usize,
    /// Whether the board refused to clear the fault because a servo is hot, and when the host
    /// tries again, in µs.
    is_hot: bool,
    clear_again_us: u64,
    session: u32,
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
}

impl Driver {
    /// A host that configures the board, arms it if `arms`, and then sends the command,
    /// if there is one.
    pub(super) fn new(setup: Setup, limits: Limits, arms: bool, command: Option<Command>) -> Self {
        Self {
            client: CommandLink::default(),
            setup,
            limits,
            command,
            arms,
            phase: Phase::Connecting,
            fault: HostFault::None,
            next_fault_us: 0,
            other_encoder: Encoder::default(),
            faulty_bytes: Vec::new(),
            turn: 0,
            is_hot: false,
            clear_again_us: 0,
            session: 0,
            is_ready: None,
            trip: None,
            off: None,
            record: None,
            max_torque_nm: 0.0,
            accepted_invalid: 0,
        }
    }

    /// Whether the scenario runs.
    pub(super) fn is_working(&self) -> bool {
        self.phase == Phase::Working
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

    fn process(&mut self, message: BoardMessage) {
        match (message, self.phase) {
            (BoardMessage::Hello(_), Phase::Connecting) => {
                self.send_command(Phase::SettingUp, Command::Configure(self.setup));
            }
            (BoardMessage::Done, Phase::SettingUp) => {
                self.send_command(Phase::Limiting, Command::Limit(self.limits));
            }
            (BoardMessage::Done, Phase::Limiting) => self.phase = Phase::Waiting,
            (BoardMessage::Done, Phase::Arming) => match self.command {
                Some(command) => self.send_command(Phase::Commanding, command),
                None => self.phase = Phase::Working,
            },
            (BoardMessage::Done, Phase::Commanding) => self.phase = Phase::Working,
            (BoardMessage::Done, Phase::Working) if self.fault == HostFault::OutOfRange => {
                self.accepted_invalid += 1;
            }
            (BoardMessage::Refused(Refusal::Hot { .. }), Phase::Clearing) => self.is_hot = true,
            (BoardMessage::Other(ToHost::Board(report)), _) => self.session = report.session,
            (BoardMessage::Other(ToHost::Tripped(trip)), _) => self.trip = Some(trip),
            (BoardMessage::Other(ToHost::Off(report)), _) => self.off = Some(report),
            (BoardMessage::Other(ToHost::Found { is_ready, .. }), _) => {
                self.is_ready = Some(is_ready);
            }
            (BoardMessage::Other(ToHost::Record(record)), phase) => {
                self.record = Some(record);
                let torques = record.torque_nm.iter();
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
            (Phase::Waiting, Some(false)) => self.send_command(Phase::Preparing, Command::Prepare),
            (Phase::Waiting | Phase::Preparing, Some(true)) if self.arms => {
                let session = self.session;
                self.send_command(Phase::Arming, Command::Arm { session });
            }
            (Phase::Waiting | Phase::Preparing, Some(true)) => self.phase = Phase::Working,
            _ => {}
        }
    }

    /// Sends the messages of the fault.
    fn send_fault(&mut self) {
        self.turn += 1;
        match self.fault {
            HostFault::None | HostFault::Silent => {}
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

/// A command with numbers that a board must refuse.
fn out_of_range(turn: usize) -> Command {
    let limits = Limits::default();
    let commands = [
        Command::Torque([f32::NAN; JOINTS]),
        Command::Regulate([9.0, 0.0]),
        Command::Torque([0.0, 1e9]),
        Command::Regulate([f32::INFINITY; JOINTS]),
        Command::Limit(Limits {
            angle_rad: [3.0; JOINTS],
            ..limits
        }),
        Command::Limit(Limits {
            silence_ms: u16::MAX,
            ..limits
        }),
        Command::Configure(Setup {
            period_us: 1,
            ..Setup::default()
        }),
        Command::Arm { session: 0 },
        Command::Experiment(Experiment {
            roles: [Role::Torque(Signal::Constant(f32::NAN)), Role::Hold],
            duration_s: 1.0,
            angle_rad: [[-1.0, 1.0]; JOINTS],
            speed_rad_s: [1.0; JOINTS],
        }),
        Command::Stream {
            at_us: u64::MAX,
            angle_rad: [f32::NAN; JOINTS],
            speed_rad_s: None,
        },
    ];
    commands[turn % commands.len()]
}

impl Host for Driver {
    type Error = Infallible;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], Infallible> {
        self.faulty_bytes.clear();
        if std::mem::take(&mut self.is_hot) {
            self.clear_again_us = now_us + CLEAR_AGAIN_US;
        }
        if self.clear_again_us > 0 && now_us >= self.clear_again_us {
            self.clear_again_us = 0;
            self.clear();
        }
        if self.fault != HostFault::None && now_us >= self.next_fault_us {
            self.next_fault_us = now_us + FAULT_US;
            self.send_fault();
        }
        match self.fault {
            HostFault::OtherSchema | HostFault::Silent => return Ok(&self.faulty_bytes),
            HostFault::Goodbye => self.fault = HostFault::Silent,
            HostFault::None | HostFault::OutOfRange => {}
        }
        Ok(self.client.transmit(now_us))
    }

    fn receive(&mut self, _now_us: u64, mut bytes: &[u8]) -> Result<(), Infallible> {
        while let Some(message) = self.client.receive(&mut bytes) {
            self.process(message);
        }
        Ok(())
    }

    fn wake_at_us(&self) -> u64 {
        match self.fault {
            HostFault::None => self.client.wake_at_us(),
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
