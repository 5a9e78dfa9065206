//! A host that sends commands, one after the other, once the board is idle.

use std::collections::VecDeque;
use std::convert::Infallible;

use armbridge_client::Host;
use armbridge_client::session::{BoardMessage, CommandLink};
use armbridge_link::message::{Command, Mode, Record, Refusal, SettingsFrom, Setup, ToHost};
use armbridge_sim::Bench;
use armbridge_sim::plant::Plant;

use crate::plant;

/// Saves the settings in force.
pub const SAVE: Request = Request::Command(Command::Save);

/// A command to the board.
#[derive(Clone, Copy, Debug)]
pub enum Request {
    /// A command.
    Command(Command),
    /// Arm, with the session that the board has reported.
    Arm,
}

/// A host that sends its commands once the board is idle, and waits for some ticks after
/// the last answer.
pub struct CommandHost {
    client: CommandLink,
    requests: VecDeque<Request>,
    /// Messages of the board.
    pub received: Received,
    is_idle: bool,
    ticks_left: usize,
}

/// Messages of the board.
#[derive(Default)]
pub struct Received {
    /// Session last reported by the board.
    pub session: u32,
    /// Settings in force.
    pub settings: Option<SettingsFrom>,
    /// Answers to commands, in order.
    pub answers: Vec<Result<(), Refusal>>,
    /// Records, in order.
    pub records: Vec<Record>,
}

impl CommandHost {
    /// Sends these requests in order.
    pub fn new(requests: impl IntoIterator<Item = Request>) -> Self {
        Self {
            client: CommandLink::default(),
            requests: requests.into_iter().collect(),
            received: Received::default(),
            is_idle: false,
            ticks_left: 20,
        }
    }

    fn take(&mut self, message: &BoardMessage) {
        match message {
            BoardMessage::Other(ToHost::Board(report)) => {
                self.received.session = report.session;
                self.received.settings = Some(report.settings);
            }
            BoardMessage::Done => self.received.answers.push(Ok(())),
            BoardMessage::Refused(refusal) => self.received.answers.push(Err(*refusal)),
            BoardMessage::Other(ToHost::Record(record)) => {
                self.is_idle |= record.mode == Mode::Idle;
                if self.has_sent_all() {
                    self.ticks_left = self.ticks_left.saturating_sub(1);
                }
                self.received.records.push(*record);
            }
            _ => {}
        }
    }

    fn has_sent_all(&self) -> bool {
        self.requests.is_empty() && self.client.is_settled() && self.is_idle
    }
}

impl Host for CommandHost {
    type Error = Infallible;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], Infallible> {
        assert!(
            now_us < 10_000_000,
            "no end: {} requests, {:?}, {:?}",
            self.requests.len(),
            self.received.answers,
            self.received.records.last()
        );
        if self.is_idle
            && self.client.is_settled()
            && let Some(next) = self.requests.pop_front()
        {
            self.client.command(match next {
                Request::Command(command) => command,
                Request::Arm => Command::Arm {
                    session: self.received.session,
                },
            });
        }
        Ok(self.client.transmit(now_us))
    }

    fn receive(&mut self, _now_us: u64, mut bytes: &[u8]) -> Result<(), Infallible> {
        while let Some(message) = self.client.receive(&mut bytes) {
            self.take(&message);
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

/// Bench with an arm that leans.
pub fn bench() -> Bench {
    Bench::new(Plant::new(plant([0.1, -0.1], true), 1))
}

/// Period of the last ticks in µs.
pub fn period_us(received: &Received) -> u64 {
    let [.., a, b] = &received.records[..] else {
        panic!("no ticks");
    };
    b.input.start_us - a.input.start_us
}

/// Another period.
pub fn configure(period_us: u32) -> Request {
    Request::Command(Command::Configure(Setup {
        period_us,
        ..Setup::default()
    }))
}
