//! A host that says what it has to say once the board is idle.

use std::collections::VecDeque;
use std::convert::Infallible;

use armbridge_client::Host;
use armbridge_client::session::{BoardMessage, CommandLink};
use armbridge_shared::link::message::{
    Command, Mode, Record, Refusal, SettingsFrom, Setup, ToHost,
};
use armbridge_sim::Bench;
use armbridge_sim::plant::Plant;

use crate::plant;

/// Saves the settings in force.
pub const SAVE: Say = Say::Command(Command::Save);

/// What is said to the board, one after the other.
#[derive(Clone, Copy, Debug)]
pub enum Say {
    /// A command.
    Command(Command),
    /// With the session that the board has told.
    Arm,
}

/// Somebody who says what they have to say once the board is idle, and listens to
/// some ticks after the last answer.
pub struct Caller {
    client: CommandLink,
    to_say: VecDeque<Say>,
    /// What the board said.
    pub heard: Heard,
    is_idle: bool,
    ticks_left: usize,
}

/// What the board said.
#[derive(Default)]
pub struct Heard {
    /// Session that the board told last.
    pub session: u32,
    /// Settings in force.
    pub settings: Option<SettingsFrom>,
    /// Answers to commands, in order.
    pub answers: Vec<Result<(), Refusal>>,
    /// Records, in order.
    pub records: Vec<Record>,
}

impl Caller {
    fn take(&mut self, said: BoardMessage) {
        match said {
            BoardMessage::Other(ToHost::Board(report)) => {
                self.heard.session = report.session;
                self.heard.settings = Some(report.settings);
            }
            BoardMessage::Done => self.heard.answers.push(Ok(())),
            BoardMessage::Refused(refusal) => self.heard.answers.push(Err(refusal)),
            BoardMessage::Other(ToHost::Record(record)) => {
                self.is_idle |= record.mode == Mode::Idle;
                if self.has_said_all() {
                    self.ticks_left = self.ticks_left.saturating_sub(1);
                }
                self.heard.records.push(record);
            }
            _ => {}
        }
    }

    fn has_said_all(&self) -> bool {
        self.to_say.is_empty() && self.client.is_settled() && self.is_idle
    }
}

impl Host for Caller {
    type Error = Infallible;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], Infallible> {
        assert!(now_us < 10_000_000, "no end");
        if self.is_idle
            && self.client.is_settled()
            && let Some(next) = self.to_say.pop_front()
        {
            self.client.command(match next {
                Say::Command(command) => command,
                Say::Arm => Command::Arm {
                    session: self.heard.session,
                },
            });
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
        self.client.wake_at_us()
    }

    fn is_done(&self) -> bool {
        self.ticks_left == 0
    }
}

/// Somebody with this to say.
pub fn caller(to_say: impl IntoIterator<Item = Say>) -> Caller {
    Caller {
        client: CommandLink::default(),
        to_say: to_say.into_iter().collect(),
        heard: Heard::default(),
        is_idle: false,
        ticks_left: 20,
    }
}

/// An arm that leans.
pub fn bench() -> Bench {
    Bench::new(Plant::new(plant([0.1, -0.1], true), 1))
}

/// Period of the last ticks in µs.
pub fn period_us(heard: &Heard) -> u64 {
    let [.., a, b] = &heard.records[..] else {
        panic!("no ticks");
    };
    b.start_us - a.start_us
}

/// Another period.
pub fn configure(period_us: u32) -> Say {
    Say::Command(Command::Configure(Setup {
        period_us,
        ..Setup::default()
    }))
}
