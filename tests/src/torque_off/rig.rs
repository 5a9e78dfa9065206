//! The board with everything around it: servos and arm, a host at the link, a
//! client at the transparent port.

use armbridge_board::bridge::Channels;
use armbridge_link::message::{Command, Fault, Mode, Refusal, ToHost};
use armbridge_servo::{Firmware, JOINTS, Pwm};
use armbridge_sim::Bench;
use armbridge_sim::board::{Board, Input, Output, VirtualBoard, Wake};
use armbridge_sim::cosim::Cosim;
use armbridge_sim::emulator::{EmulatedBoard, QemuError};
use armbridge_sim::half_duplex_bus::Device;
use armbridge_sim::plant::{Plant, PlantConfig};
use armbridge_sim::servo_kind::ServoKind;

use super::cases::check;
use super::client::ClientHandle;
use super::host::RawHost;
use super::reports;
use crate::{emulated_board, with_encoders};

/// From a stop, or from when the bus can carry a packet again, to motors off, in µs.
pub const STOP_US: u64 = 20_000;
/// Within which an X servo that receives nothing is off, in µs: its watchdog, a control step and
/// the packet before.
pub const WATCHDOG_US: u64 = 22_000;
/// Until the servos are found, in µs: at the last of four speeds.
const FOUND_US: u64 = 2_000_000;
/// Within which the motors are checked, at the longest period.
const CHECKED_US: u64 = 3_000_000;
/// Until the board knows the encoders' noise, in ms: 48 ticks, and blocks that do not count.
const LEARNT_MS: u64 = 500;
/// Counts from off that no motor turns at: the stop sequence steps aside by one.
const STEP_ASIDE: u16 = 1;

/// The world that the board is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum World {
    /// In this process.
    Bench,
    /// The firmware image, in the emulator.
    Emulator,
}

impl World {
    /// Time for which motors that are off are watched, in ms; the emulator is slow.
    pub fn watch_ms(self) -> u64 {
        match self {
            Self::Bench => 10_000,
            Self::Emulator => 2_000,
        }
    }

    fn board(self, channels: &mut Channels) -> AnyBoard<'_> {
        match self {
            Self::Bench => {
                let board = VirtualBoard::new(channels.split());
                AnyBoard::Virtual(Box::new(board.expect("a default set-up")))
            }
            Self::Emulator => AnyBoard::Emulated(Box::new(emulated_board(false))),
        }
    }
}

/// The board of either world.
pub enum AnyBoard<'a> {
    /// In this process.
    Virtual(Box<VirtualBoard<'a>>),
    /// The firmware image.
    Emulated(Box<EmulatedBoard>),
}

impl Board for AnyBoard<'_> {
    type Error = QemuError;

    fn run(
        &mut self,
        now_us: u64,
        input: Input<'_>,
        output: &mut Output,
    ) -> Result<Wake, QemuError> {
        match self {
            Self::Virtual(board) => {
                let Ok(wake) = board.run(now_us, input, output);
                Ok(wake)
            }
            Self::Emulated(board) => board.run(now_us, input, output),
        }
    }
}

/// An arm with servos of this firmware at 1 Mbaud.
pub fn bench(arm: &PlantConfig, firmware: Firmware) -> Bench {
    let servos = [1, 2].map(|id| ServoKind::new(firmware, id, 1_000_000).expect("a servo"));
    Bench::with_servos(Plant::new(with_encoders(*arm, firmware), 1), &servos)
}

/// An upright arm between two obstacles, 10 counts away: it can only press against
/// them.
pub fn between_obstacles() -> PlantConfig {
    PlantConfig {
        stops_rad: [[-0.05, 0.05]; JOINTS],
        ..PlantConfig::default()
    }
}

/// Runs a test on a board that has found its servos.
pub fn with_rig<T>(world: World, bench: Bench, test: impl FnOnce(&mut Rig<'_>) -> T) -> T {
    let mut channels = Channels::new();
    let client = ClientHandle::default();
    let mut host = RawHost::default();
    host.begin_session();
    let cosim = Cosim::new(world.board(&mut channels), bench, host);
    let mut rig = Rig {
        cosim: cosim.with_client(client.clone()),
        client,
        reported: 0,
        wrong: Vec::new(),
        off: None,
        modes: Vec::new(),
    };
    rig.until("idle", FOUND_US, |rig| rig.mode() == Some(Mode::Idle));
    test(&mut rig)
}

/// A run under way.
pub struct Rig<'a> {
    /// The board, the bench and the host.
    pub cosim: Cosim<AnyBoard<'a>, RawHost, ClientHandle>,
    /// The client of the transparent port.
    pub client: ClientHandle,
    /// Messages of the board already compared with the motors.
    reported: usize,
    /// Reports that were not true.
    wrong: Vec<String>,
    /// The joints last reported as off.
    off: Option<[bool; JOINTS]>,
    /// Modes, with the time in µs of the first event in each.
    modes: Vec<(u64, Option<Mode>)>,
}

impl Rig<'_> {
    /// The host.
    pub fn host(&mut self) -> &mut RawHost {
        &mut self.cosim.host
    }

    /// Time in µs.
    pub fn now_us(&self) -> u64 {
        self.cosim.now_us()
    }

    /// The board's mode; that of the firmware as its latest record has it.
    pub fn mode(&self) -> Option<Mode> {
        match &self.cosim.board {
            AnyBoard::Virtual(board) => Some(board.mode()),
            AnyBoard::Emulated(_) => self.cosim.host.record.map(|record| record.mode),
        }
    }

    /// The modes from then on.
    pub fn modes_from(&self, from_us: u64) -> Vec<Option<Mode>> {
        let later = self.modes.partition_point(|(at_us, _)| *at_us <= from_us);
        let modes = &self.modes[later.saturating_sub(1)..];
        modes.iter().map(|(_, mode)| *mode).collect()
    }

    fn step(&mut self, latest_us: u64) {
        self.cosim.step_until(latest_us).expect("a board that runs");
        let mode = self.mode();
        if self.modes.last().is_none_or(|(_, last)| *last != mode) {
            self.modes.push((self.now_us(), mode));
        }
        self.compare_reports();
    }

    /// Runs until this time.
    pub fn until_us(&mut self, at_us: u64) {
        while self.now_us() < at_us {
            self.step(at_us);
        }
    }

    /// Runs on for so long.
    pub fn pass_ms(&mut self, ms: u64) {
        self.until_us(self.now_us() + ms * 1_000);
    }

    /// Runs until the condition holds.
    #[track_caller]
    pub fn until(&mut self, condition: &str, most_us: u64, is_so: impl Fn(&Self) -> bool) {
        let latest_us = self.now_us() + most_us;
        while !is_so(self) {
            let (mode, last) = (self.mode(), self.cosim.host.messages.last());
            assert!(
                self.now_us() < latest_us,
                "not {condition} within {most_us} µs: {mode:?}, last message {last:?}"
            );
            self.step(latest_us);
        }
    }

    /// The answer to a command; it is repeated while the board learns the encoders' noise.
    pub fn command(&mut self, command: Command) -> Result<(), Refusal> {
        for _ in 0..LEARNT_MS {
            match self.command_once(command) {
                Err(Refusal::EncoderUnknown { .. }) => self.pass_ms(1),
                answer => return answer,
            }
        }
        panic!("{command:?}: the encoders' noise is not known after {LEARNT_MS} ms")
    }

    /// The answer to a command that is sent once.
    pub fn command_once(&mut self, command: Command) -> Result<(), Refusal> {
        let since = self.host().messages.len();
        let sequence = self.host().command(command);
        let answer = |rig: &Self| rig.cosim.host.answer(since, sequence);
        self.until("answered", 100_000, |rig| answer(rig).is_some());
        answer(self).unwrap_or(Ok(()))
    }

    /// Arms, and waits until the motors have been checked.
    #[track_caller]
    pub fn arm(&mut self) {
        let session = self.host().session();
        assert_eq!(self.command(Command::Arm { session }), Ok(()));
        self.until("armed", CHECKED_US, |rig| rig.mode() == Some(Mode::Armed));
    }

    /// Arms, and drives the motors by this command.
    #[track_caller]
    pub fn drive(&mut self, command: Command) {
        self.arm();
        assert_eq!(self.command(command), Ok(()), "{command:?}");
    }

    /// Makes stock servos ready for torque.
    #[track_caller]
    pub fn prepare(&mut self) {
        let since = self.host().messages.len();
        assert_eq!(self.command(Command::Prepare), Ok(()));
        self.until("prepared", FOUND_US, |rig| {
            let mut messages = rig.cosim.host.messages[since..].iter();
            let is_ready =
                |message: &ToHost| matches!(message, ToHost::Found { is_ready, .. } if *is_ready);
            messages.any(|(_, message)| is_ready(message)) && rig.mode() == Some(Mode::Idle)
        });
    }

    /// PWM that the motors get, 1000 for off.
    pub fn motors(&self) -> [u16; JOINTS] {
        [0, 1].map(|servo| self.cosim.bench.applied_pwm(servo))
    }

    /// Whether each motor is on.
    pub fn is_on(&self) -> [bool; JOINTS] {
        self.motors()
            .map(|pwm| pwm.abs_diff(Pwm::OFF.counts()) > STEP_ASIDE)
    }

    /// The rate of a servo, as its register has it.
    pub fn rate_register(&self, servo: usize) -> Option<u32> {
        match &self.cosim.bench.servos()[servo] {
            Device::Morpheus(servo) => Some(servo.state().baud.into()),
            Device::Stock(servo) => servo.register("baud_rate"),
            Device::X(servo) => {
                let code = servo.register(armbridge_servo::protocol2::register::BAUD_RATE)?;
                u32::try_from(code).ok()
            }
        }
    }

    /// Time in µs that each motor was on so far.
    pub fn on_us(&self) -> [u64; JOINTS] {
        [0, 1].map(|servo| self.cosim.bench.total_on_ns(servo) / 1_000)
    }

    /// Runs on, and checks that the motors are off from this time on, for so long.
    pub fn stays_off(&mut self, from_us: u64, for_ms: u64) -> Result<(), String> {
        self.until_us(from_us);
        let before_us = self.on_us();
        self.pass_ms(for_ms);
        self.was_off(from_us, before_us)
    }

    /// Checks that the motors were off since this time, when their time on was
    /// `before_us`.
    pub fn was_off(&self, from_us: u64, before_us: [u64; JOINTS]) -> Result<(), String> {
        let after_us = self.on_us();
        let on_ms = [0, 1].map(|servo| (after_us[servo] - before_us[servo]) as f64 * 1e-3);
        let watched_ms = (self.now_us() - from_us) as f64 * 1e-3;
        check(after_us == before_us, || {
            format!(
                "motors on for {on_ms:.1?} ms of the {watched_ms} ms in which they must be off, \
                 PWM now {:?}, mode {:?}",
                self.motors(),
                self.mode()
            )
        })
    }

    /// The last fault that the board reported.
    pub fn fault(&self) -> Option<Fault> {
        let messages = self.cosim.host.messages.iter().rev();
        messages
            .map(|(_, message)| message)
            .find_map(reports::fault)
    }

    /// Checks that no motor was reported off while it was on.
    pub fn reports_are_true(&self) -> Result<(), String> {
        check(self.wrong.is_empty(), || self.wrong.join("; "))
    }

    /// Checks that both motors are reported off in the end.
    pub fn is_reported_off(&self) -> Result<(), String> {
        check(self.off == Some([true; JOINTS]), || {
            format!("reported off in the end: {:?}", self.off)
        })
    }

    fn compare_reports(&mut self) {
        let is_on = self.is_on();
        let messages = &self.cosim.host.messages;
        for (at_us, message) in &messages[self.reported..] {
            let Some(off) = reports::off(message) else {
                continue;
            };
            self.off = Some(off);
            for joint in (0..JOINTS).filter(|joint| off[*joint] && is_on[*joint]) {
                let pwm = self.motors()[joint];
                self.wrong.push(format!(
                    "motor {joint} reported off at {at_us} µs, with PWM {pwm}"
                ));
            }
        }
        self.reported = messages.len();
    }
}
