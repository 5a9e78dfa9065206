//! A host that greets the board, arms it, drives the arm, and keeps every message.

use std::convert::Infallible;

use armbridge_client::Host;
use armbridge_client::session::{BoardMessage, CommandLink};
use armbridge_link::message::{BoardReport, Command, Mode, Record, Refusal, ToHost, Trip};
use armbridge_tests::random::Random;

/// Bytes of garbage in [`FLOOD_US`]: 12 Mbaud, the full rate of USB.
const FLOOD_BYTES: usize = 120;
/// Period of the commands.
const FLOOD_US: u64 = 100;

/// Progress of the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Waiting,
    Arming,
    Driving,
}

/// The host that drives the arm.
#[derive(Debug)]
pub(crate) struct DrivingHost {
    /// For what else is to be commanded.
    pub(crate) client: CommandLink,
    drive: Command,
    stage: Stage,
    /// The board's messages, in order.
    pub(crate) messages: Vec<BoardMessage>,
    /// Speaks garbage and nothing else from now on.
    pub(crate) is_flooding: bool,
    /// Speaks nothing from now on.
    pub(crate) is_silent: bool,
    random: Random,
    garbage: Vec<u8>,
    flood_due_us: u64,
}

impl DrivingHost {
    /// Will drive the arm so.
    pub(crate) fn new(drive: Command) -> Self {
        Self {
            client: CommandLink::default(),
            drive,
            stage: Stage::Waiting,
            messages: Vec::new(),
            is_flooding: false,
            is_silent: false,
            random: Random::new(1),
            garbage: Vec::new(),
            flood_due_us: 0,
        }
    }

    /// The latest record, if there is one.
    pub(crate) fn last(&self) -> Option<Record> {
        self.records().last()
    }

    /// All records.
    pub(crate) fn records(&self) -> impl Iterator<Item = Record> {
        self.messages.iter().filter_map(|message| match message {
            BoardMessage::Other(ToHost::Record(record)) => Some(*record),
            _ => None,
        })
    }

    /// The board's latest report.
    pub(crate) fn report(&self) -> Option<BoardReport> {
        self.messages
            .iter()
            .rev()
            .find_map(|message| match message {
                BoardMessage::Other(ToHost::Board(report)) => Some(*report),
                _ => None,
            })
    }

    /// Why the board switched torque off.
    pub(crate) fn trip(&self) -> Option<Trip> {
        self.messages.iter().find_map(|message| match message {
            BoardMessage::Other(ToHost::Tripped(trip)) => Some(*trip),
            _ => None,
        })
    }

    fn arm(&mut self) {
        let session = self.report().map_or(0, |report| report.session);
        self.client.command(Command::Arm { session });
        self.stage = Stage::Arming;
    }

    fn take(&mut self, message: &BoardMessage) {
        self.messages.push(*message);
        match (message, self.stage) {
            (BoardMessage::Other(ToHost::Record(record)), Stage::Waiting)
                if record.mode == Mode::Idle =>
            {
                self.arm();
            }
            (BoardMessage::Refused(Refusal::OtherSession), Stage::Arming) => self.arm(),
            (BoardMessage::Done, Stage::Arming) => {
                self.client.command(self.drive);
                self.stage = Stage::Driving;
            }
            _ => {}
        }
    }
}

impl Host for DrivingHost {
    type Error = Infallible;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], Infallible> {
        if self.is_silent {
            return Ok(&[]);
        }
        if !self.is_flooding {
            return Ok(self.client.transmit(now_us));
        }
        self.garbage.clear();
        if now_us >= self.flood_due_us {
            self.flood_due_us = now_us + FLOOD_US;
            let random = &mut self.random;
            self.garbage.extend((0..FLOOD_BYTES).map(|_| random.byte()));
        }
        Ok(&self.garbage)
    }

    fn receive(&mut self, _now_us: u64, mut bytes: &[u8]) -> Result<(), Infallible> {
        while let Some(message) = self.client.receive(&mut bytes) {
            self.take(&message);
        }
        Ok(())
    }

    fn wake_at_us(&self) -> u64 {
        if self.is_silent {
            u64::MAX
        } else if self.is_flooding {
            self.flood_due_us
        } else {
            self.client.wake_at_us()
        }
    }

    fn is_done(&self) -> bool {
        false
    }
}
