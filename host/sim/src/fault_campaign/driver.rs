//! The host of a case: brings the board up, makes the arm do what it shall,
//! keeps it alive, does to it what only a host can do, and in the end clears the
//! fault.
//!
//! It never gives up: what the board says is kept, to be judged.

use std::convert::Infallible;

use armbridge_client::Host;
use armbridge_client::session::{BoardMessage, CommandLink};
use armbridge_shared::JOINTS;
use armbridge_shared::experiment::Signal;
use armbridge_shared::link::experiment::{Experiment, Role};
use armbridge_shared::link::frame::Encoder;
use armbridge_shared::link::message::{
    Command, Hello, Limits, Mode, OffReport, Record, Setup, ToBoard, ToHost, Trip,
};
use armbridge_shared::link::schema;

/// How often a strange host says what it says, in µs: as often as a good one.
const STRANGE_US: u64 = 25_000;

/// What only a host can do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum HostFault {
    /// It works as it should.
    None,
    /// It says hello in another schema, and commands nobody can read.
    OtherSchema,
    /// It commands numbers beyond all bounds.
    OutOfRange,
    /// It says goodbye,
    Leaves,
    /// and then nothing.
    Gone,
}

/// Where it has come to.
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
    whim: HostFault,
    strange_us: u64,
    /// Of another build.
    stranger: Encoder,
    strange: Vec<u8>,
    turn: usize,
    session: u32,
    /// Whether servos were found, and may be given torque.
    is_ready: Option<bool>,
    /// What the board told of the latest fault.
    pub(super) trip: Option<Trip>,
    /// What it told of the servos after that.
    pub(super) off: Option<OffReport>,
    /// The latest record.
    pub(super) record: Option<Record>,
    /// Largest torque that a record told, in N m.
    pub(super) most_nm: f32,
    /// How often a command out of range was accepted.
    pub(super) swallowed: u32,
}

impl Driver {
    /// Who will set this up, and then command it; `None` for nothing but to arm,
    /// if that.
    pub(super) fn new(setup: Setup, limits: Limits, arms: bool, command: Option<Command>) -> Self {
        Self {
            client: CommandLink::default(),
            setup,
            limits,
            command,
            arms,
            phase: Phase::Connecting,
            whim: HostFault::None,
            strange_us: 0,
            stranger: Encoder::default(),
            strange: Vec::new(),
            turn: 0,
            session: 0,
            is_ready: None,
            trip: None,
            off: None,
            record: None,
            most_nm: 0.0,
            swallowed: 0,
        }
    }

    /// Whether the arm does what it shall.
    pub(super) fn is_working(&self) -> bool {
        self.phase == Phase::Working
    }

    /// Asks for an emergency stop.
    pub(super) fn stop(&mut self) {
        self.client.send(ToBoard::Stop);
    }

    pub(super) fn behave(&mut self, whim: HostFault) {
        if whim == HostFault::None && self.whim != HostFault::None {
            // Whoever comes back says hello.
            self.client = CommandLink::default();
        }
        self.whim = whim;
        self.strange_us = 0;
    }

    /// Wants the board to leave its fault.
    pub(super) fn clear(&mut self) {
        self.phase = Phase::Clearing;
        self.client.command(Command::ClearFault);
    }

    fn next(&mut self, phase: Phase, command: Command) {
        self.phase = phase;
        self.client.command(command);
    }

    fn take(&mut self, said: BoardMessage) {
        match (said, self.phase) {
            (BoardMessage::Hello(_), Phase::Connecting) => {
                self.next(Phase::SettingUp, Command::Configure(self.setup));
            }
            (BoardMessage::Done, Phase::SettingUp) => {
                self.next(Phase::Limiting, Command::Limit(self.limits));
            }
            (BoardMessage::Done, Phase::Limiting) => self.phase = Phase::Waiting,
            (BoardMessage::Done, Phase::Arming) => match self.command {
                Some(command) => self.next(Phase::Commanding, command),
                None => self.phase = Phase::Working,
            },
            (BoardMessage::Done, Phase::Commanding) => self.phase = Phase::Working,
            (BoardMessage::Done, Phase::Working) if self.whim == HostFault::OutOfRange => {
                self.swallowed += 1;
            }
            (BoardMessage::Told(ToHost::Board(report)), _) => self.session = report.session,
            (BoardMessage::Told(ToHost::Tripped(trip)), _) => self.trip = Some(trip),
            (BoardMessage::Told(ToHost::Off(report)), _) => self.off = Some(report),
            (BoardMessage::Told(ToHost::Found { is_ready, .. }), _) => {
                self.is_ready = Some(is_ready);
            }
            (BoardMessage::Told(ToHost::Record(record)), phase) => {
                self.record = Some(record);
                let torques = record.torque_nm.iter();
                self.most_nm = torques.fold(self.most_nm, |most, nm| most.max(nm.abs()));
                if record.mode == Mode::Idle {
                    self.begin(phase);
                }
            }
            _ => {}
        }
    }

    /// Arms the idle board if its servos are ready, and has them made ready if they
    /// are stock servos as they come.
    fn begin(&mut self, phase: Phase) {
        match (phase, self.is_ready) {
            (Phase::Waiting, Some(false)) => self.next(Phase::Preparing, Command::Prepare),
            (Phase::Waiting | Phase::Preparing, Some(true)) if self.arms => {
                let session = self.session;
                self.next(Phase::Arming, Command::Arm { session });
            }
            (Phase::Waiting | Phase::Preparing, Some(true)) => self.phase = Phase::Working,
            _ => {}
        }
    }

    /// Says what it should not.
    fn misbehave(&mut self) {
        self.turn += 1;
        match self.whim {
            HostFault::None | HostFault::Gone => {}
            HostFault::Leaves => self.client.send(ToBoard::Goodbye),
            HostFault::OtherSchema => {
                let hello = Hello {
                    schema: schema::HASH.map(|byte| !byte),
                    ..schema::HELLO
                };
                for message in [ToBoard::Hello(hello), ToBoard::Heartbeat] {
                    let (_, frame) = self.stranger.encode(&message);
                    self.strange.extend_from_slice(frame);
                }
            }
            HostFault::OutOfRange => self.client.command(beyond(self.turn)),
        }
    }
}

/// Commands with numbers that no board may take.
fn beyond(turn: usize) -> Command {
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
        self.strange.clear();
        if self.whim != HostFault::None && now_us >= self.strange_us {
            self.strange_us = now_us + STRANGE_US;
            self.misbehave();
        }
        match self.whim {
            HostFault::OtherSchema | HostFault::Gone => return Ok(&self.strange),
            HostFault::Leaves => self.whim = HostFault::Gone,
            HostFault::None | HostFault::OutOfRange => {}
        }
        Ok(self.client.transmit(now_us))
    }

    fn receive(&mut self, _now_us: u64, mut bytes: &[u8]) -> Result<(), Infallible> {
        while let Some(message) = self.client.receive(&mut bytes) {
            self.take(message);
        }
        Ok(())
    }

    fn wake_at_us(&self) -> u64 {
        match self.whim {
            HostFault::None => self.client.wake_at_us(),
            HostFault::Gone => u64::MAX,
            HostFault::OtherSchema => self.strange_us,
            HostFault::OutOfRange | HostFault::Leaves => {
                self.strange_us.min(self.client.wake_at_us())
            }
        }
    }

    fn is_done(&self) -> bool {
        false
    }
}
