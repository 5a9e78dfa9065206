//! The dashboard's data, built from the link's events alone.
//!
//! Memory is bounded, however long it runs: ten seconds of angles, ten minutes of a float, ten
//! thousand timings, and counts.

mod bus;
mod histogram;
mod history;
mod lesson;
mod link;
mod rate;

pub use bus::Bus;
pub use histogram::Histogram;
pub use history::{History, SPAN_S, Seen, Slice};
pub use lesson::{Lesson, LessonError};
pub use link::{Line, Link};

use armbridge_client::event::{Event, EventKind};
use armbridge_client::status::BoardStatus;
use armbridge_link::message::ToHost;

/// The dashboard's data.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// State and statistics of the link.
    pub link: Link,
    /// State and statistics of the bus.
    pub bus: Bus,
    /// The last ten seconds.
    pub history: History,
    /// Path of the last float.
    pub lesson: Lesson,
    /// Latest of each of the board's messages.
    pub board: BoardStatus,
    /// Events that the queue dropped.
    pub unseen: u64,
    record_ns: u64,
    now_ns: u64,
}

impl Model {
    /// Applies an event.
    pub fn take(&mut self, event: &Event) {
        self.advance(event.host_ns);
        match event.kind {
            EventKind::Sent(sequence, message) => {
                self.link.sent(event.host_ns, sequence, &message);
            }
            EventKind::Received(_, message) => {
                self.link.received(event.host_ns);
                self.apply_message(event.host_ns, &message);
            }
            EventKind::Lost(_, frames) => self.link.lost(frames),
            EventKind::Damaged(direction, error) => self.link.garbled(direction, error),
            EventKind::Disconnected => self.link.disconnected(event.host_ns),
        }
    }

    /// Time goes on, though nothing happens: to this many ns of the link's clock.
    pub fn advance(&mut self, now_ns: u64) {
        self.now_ns = self.now_ns.max(now_ns);
    }

    /// The link's time in ns.
    pub fn now_ns(&self) -> u64 {
        self.now_ns
    }

    /// State of the connection.
    pub fn line(&self) -> Line {
        self.link.line(self.now_ns)
    }

    /// The board's clock in s, carried on from the latest tick.
    pub fn board_s(&self) -> f64 {
        let start_us = self.board.record.map_or(0, |record| record.input.start_us);
        let since_ns = self.now_ns.saturating_sub(self.record_ns);
        start_us as f64 * 1e-6 + since_ns as f64 * 1e-9
    }

    /// The same in µs.
    pub fn board_us(&self) -> u64 {
        (self.board_s() * 1e6) as u64
    }

    fn apply_message(&mut self, now_ns: u64, message: &ToHost) {
        self.board.take(message);
        match *message {
            ToHost::Ack {
                sequence, result, ..
            } => self.link.acknowledged(now_ns, sequence, result),
            ToHost::Record(record) => {
                self.history.take(&record);
                self.lesson.take(&record);
                self.bus.take(&record);
                self.link.dropped = u64::from(record.dropped);
                self.record_ns = now_ns;
            }
            _ => {}
        }
    }
}
