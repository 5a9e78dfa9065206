//! The one who works with the arm: connects, sets up, arms, regulates about one
//! setpoint after the other, switches off, and keeps every record.
//!
//! Clockless: told what the time is, it says what to send and when to be asked
//! again. So the same operator works in virtual time and over a socket.

mod error;
mod news;

pub use error::OperatorError;

use armbridge_shared::JOINTS;
use armbridge_shared::link::message::{
    BoardReport, Command, Halt, Mode, PortCounters, Record, Refusal, Setup, ToHost, Trip,
};
use armbridge_shared::servo::Firmware;

use crate::bench::cosim::Host;
use crate::link::{Client, Said};
use crate::log::names;
use crate::summary::LinkStats;
use news::News;

/// How long a board may take to answer the first hello.
const HELLO_TIMEOUT_US: u64 = 3_000_000;
/// How long the servos may take to be found: bring-up takes 30 ms.
const SERVO_TIMEOUT_US: u64 = 3_000_000;
/// How long a command may take to be acknowledged.
const ACK_TIMEOUT_US: u64 = 2_000_000;

/// What is to be done.
#[derive(Clone, Debug)]
pub struct Script {
    /// How the board shall work.
    pub setup: Setup,
    /// What to command when, in µs since the first, which is at 0.
    pub commands: Vec<(u64, Command)>,
    /// Length of the run in µs since the first command.
    pub duration_us: u64,
}

impl Script {
    /// To stand upright.
    pub fn upright(setup: Setup, duration_us: u64) -> Self {
        Self {
            setup,
            commands: vec![(0, Command::Regulate([0.0; JOINTS]))],
            duration_us,
        }
    }

    /// Upright, then two setpoints nearby: at 40 % and at 70 % of the run.
    pub fn demo(setup: Setup, duration_us: u64) -> Self {
        let setpoints = [
            (0, [0.0, 0.0]),
            (duration_us * 4 / 10, [0.15, 0.10]),
            (duration_us * 7 / 10, [-0.10, -0.15]),
        ];
        Self {
            setup,
            commands: setpoints
                .map(|(at_us, q)| (at_us, Command::Regulate(q)))
                .into(),
            duration_us,
        }
    }
}

#[derive(Debug)]
enum Phase {
    Connecting,
    SettingUp,
    WaitingForServos,
    Arming,
    Running { since_us: u64, next: usize },
    SwitchingOff,
    Over,
}

/// Somebody who works through a [`Script`].
#[derive(Debug)]
pub struct Operator {
    client: Client,
    script: Script,
    phase: Phase,
    entered_us: u64,
    news: News,
    /// Servos are still to be given back.
    is_releasing: bool,
    records: Vec<Record>,
    commands: Vec<(u64, Command)>,
}

impl Operator {
    /// An operator who has not begun.
    pub fn new(script: Script) -> Self {
        Self {
            client: Client::default(),
            script,
            phase: Phase::Connecting,
            entered_us: 0,
            news: News::default(),
            is_releasing: false,
            records: Vec::new(),
            commands: Vec::new(),
        }
    }

    /// The same, who in the end gives stock servos back the mode and return delay
    /// they were found with, and leaves the bus to the transparent port.
    #[must_use]
    pub fn releasing(self) -> Self {
        Self {
            is_releasing: true,
            ..self
        }
    }

    /// How much of the run is over, 0 to 1.
    pub fn fraction(&self, now_us: u64) -> f64 {
        match self.phase {
            Phase::Connecting | Phase::SettingUp | Phase::WaitingForServos | Phase::Arming => 0.0,
            Phase::Running { since_us, .. } => {
                let elapsed_us = now_us.saturating_sub(since_us);
                (elapsed_us as f64 / self.script.duration_us as f64).min(1.0)
            }
            Phase::SwitchingOff | Phase::Over => 1.0,
        }
    }

    /// When the first command was due, in µs; `None` before and after the run.
    pub fn running_since_us(&self) -> Option<u64> {
        match self.phase {
            Phase::Running { since_us, .. } => Some(since_us),
            _ => None,
        }
    }

    /// What the servos run, and the speed of their bus, once they are found.
    pub fn found(&self) -> Option<(Firmware, u32)> {
        self.news.found
    }

    /// What became of the transparent port's packets, as last reported.
    pub fn port(&self) -> PortCounters {
        self.news.port
    }

    /// What the board said of itself, once it has.
    pub fn report(&self) -> Option<BoardReport> {
        self.news.report
    }

    /// Why the board switched torque off, each time.
    pub fn trips(&self) -> &[Trip] {
        &self.news.trips
    }

    /// What the servos did after each of its stop sequences.
    pub fn halts(&self) -> &[Halt] {
        &self.news.halts
    }

    /// The records so far.
    pub fn records(&self) -> &[Record] {
        &self.records
    }

    /// Records and commands, with the time in µs at which these were given, and
    /// what became of the link's frames.
    pub fn into_parts(self) -> (Vec<Record>, Vec<(u64, Command)>, LinkStats) {
        let stats = self.client.stats();
        (self.records, self.commands, stats)
    }

    fn command(&mut self, now_us: u64, command: Command) {
        self.commands.push((now_us, command));
        self.client.command(command);
    }

    fn take(&mut self, now_us: u64, said: Said) -> Result<(), OperatorError> {
        self.news.take(&said)?;
        match (said, &self.phase) {
            (Said::Hello, Phase::Connecting) => {
                self.command(now_us, Command::Configure(self.script.setup));
                self.enter(Phase::SettingUp, now_us);
            }
            (Said::Done, Phase::SettingUp) => {
                self.enter(Phase::WaitingForServos, now_us);
                if let (Some(_), false) = (self.news.found, self.news.is_ready) {
                    self.command(now_us, Command::Prepare);
                }
            }
            (Said::Done, Phase::Arming) => self.enter(
                Phase::Running {
                    since_us: now_us,
                    next: 0,
                },
                now_us,
            ),
            // It has heard a second hello, and says so.
            (Said::Refused(Refusal::OtherSession), Phase::Arming) => self.arm(now_us),
            (Said::Refused(refusal), Phase::Arming) => {
                return Err(OperatorError::Refused {
                    command: "arm",
                    refusal,
                });
            }
            (Said::Done, Phase::SwitchingOff) if self.is_releasing => {
                self.is_releasing = false;
                self.command(now_us, Command::Release);
            }
            (Said::Done, Phase::SwitchingOff) => self.enter(Phase::Over, now_us),
            (Said::Refused(refusal), Phase::SettingUp) => {
                return Err(OperatorError::Refused {
                    command: "configure",
                    refusal,
                });
            }
            // A fault came first: the records show it.
            (Said::Refused(Refusal::Faulted), Phase::Running { .. }) => self.switch_off(now_us),
            (Said::Refused(refusal), Phase::Running { next, .. }) => {
                let given = self.script.commands.get(next.saturating_sub(1));
                let command = given.map_or("idle", |(_, command)| names::command(command));
                return Err(OperatorError::Refused { command, refusal });
            }
            (
                Said::Told(ToHost::Found {
                    is_ready: false, ..
                }),
                Phase::WaitingForServos,
            ) => self.command(now_us, Command::Prepare),
            // Back from whoever has the bus.
            (Said::Told(ToHost::Passthrough), Phase::WaitingForServos) => {
                self.command(now_us, Command::Idle);
            }
            (Said::Told(ToHost::Record(record)), Phase::WaitingForServos)
                if record.mode == Mode::Idle && self.news.is_ready =>
            {
                self.news.absent = None;
                self.enter(Phase::Arming, now_us);
                self.arm(now_us);
            }
            (Said::Told(ToHost::Record(record)), Phase::Running { .. } | Phase::SwitchingOff) => {
                self.records.push(record);
                if matches!(record.mode, Mode::Fault(_)) && !self.is_switching_off() {
                    self.switch_off(now_us);
                }
            }
            // News, or nothing to do now.
            (
                Said::Hello | Said::OtherSchema(_) | Said::Done | Said::Refused(_) | Said::Told(_),
                _,
            ) => {}
        }
        Ok(())
    }

    fn arm(&mut self, now_us: u64) {
        let session = self.news.report.map_or(0, |report| report.session);
        self.command(now_us, Command::Arm { session });
    }

    fn run(&mut self, now_us: u64, since_us: u64, next: usize) {
        let elapsed_us = now_us.saturating_sub(since_us);
        if elapsed_us >= self.script.duration_us {
            self.switch_off(now_us);
        } else if let Some((at_us, command)) = self.script.commands.get(next)
            && elapsed_us >= *at_us
        {
            self.command(now_us, *command);
            self.phase = Phase::Running {
                since_us,
                next: next + 1,
            };
        }
    }

    fn is_switching_off(&self) -> bool {
        matches!(self.phase, Phase::SwitchingOff)
    }

    fn switch_off(&mut self, now_us: u64) {
        self.command(now_us, Command::Idle);
        self.enter(Phase::SwitchingOff, now_us);
    }

    fn enter(&mut self, phase: Phase, now_us: u64) {
        self.phase = phase;
        self.entered_us = now_us;
    }
}

impl Host for Operator {
    type Error = OperatorError;

    fn speak(&mut self, now_us: u64) -> Result<&[u8], OperatorError> {
        let waited_us = now_us.saturating_sub(self.entered_us);
        match self.phase {
            Phase::Connecting if waited_us > HELLO_TIMEOUT_US => {
                let damaged = self.client.stats().damaged;
                return Err(OperatorError::NoBoard { damaged });
            }
            Phase::SettingUp | Phase::Arming | Phase::SwitchingOff
                if waited_us > ACK_TIMEOUT_US =>
            {
                return Err(OperatorError::Silent);
            }
            Phase::WaitingForServos if waited_us > SERVO_TIMEOUT_US => {
                let absent = OperatorError::NoServos {
                    last: self.news.absent,
                };
                return Err(self.news.trouble.take().unwrap_or(absent));
            }
            Phase::Running { since_us, next } => self.run(now_us, since_us, next),
            Phase::Connecting
            | Phase::SettingUp
            | Phase::WaitingForServos
            | Phase::Arming
            | Phase::SwitchingOff
            | Phase::Over => {}
        }
        Ok(self.client.transmit(now_us))
    }

    fn wake_at_us(&self) -> u64 {
        let due_us = match self.phase {
            Phase::Running { since_us, next } => {
                let next = self.script.commands.get(next);
                since_us + next.map_or(self.script.duration_us, |(at_us, _)| *at_us)
            }
            Phase::Connecting
            | Phase::SettingUp
            | Phase::WaitingForServos
            | Phase::Arming
            | Phase::SwitchingOff
            | Phase::Over => u64::MAX,
        };
        due_us.min(self.client.wake_at_us())
    }

    fn hear(&mut self, now_us: u64, bytes: &[u8]) -> Result<(), OperatorError> {
        let mut said = Vec::new();
        self.client.receive(bytes, |what| said.push(what));
        said.into_iter()
            .try_for_each(|what| self.take(now_us, what))
    }

    fn is_done(&self) -> bool {
        matches!(self.phase, Phase::Over)
    }
}
