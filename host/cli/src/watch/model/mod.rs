//! What the dashboard knows: made of what was said on the link, and of nothing else.
//!
//! Memory is bounded, however long it runs: ten seconds of angles, ten thousand
//! timings, and counts.

mod bus;
mod history;
mod link;
mod rate;
mod spread;

pub use bus::Bus;
pub use history::{History, SPAN_S, Seen, Slice};
pub use link::{Line, Link};
pub use spread::Spread;

use armbridge_shared::link::experiment::Conclusion;
use armbridge_shared::link::message::{
    BoardReport, Drive, Mode, OffReport, Record, Settings, ToHost, Trip,
};
use armbridge_shared::link::schema;
use armbridge_shared::servo::Firmware;

use armbridge_client::error::{end_in_words, likely_cause};
use armbridge_client::event::{Event, What};

/// All of it.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// How the link does.
    pub link: Link,
    /// How the bus does.
    pub bus: Bus,
    /// The last ten seconds.
    pub history: History,
    /// The latest tick.
    pub record: Option<Record>,
    /// What is in force.
    pub settings: Option<Settings>,
    /// What the board said of itself.
    pub report: Option<BoardReport>,
    /// What the servos run, the speed of their bus, and whether they are ready.
    pub found: Option<(Firmware, u32, bool)>,
    /// Why there is a fault, while there is one.
    pub trip: Option<Trip>,
    /// What the servos did then.
    pub off: Option<OffReport>,
    /// How the last experiment ended, until something else drives the arm.
    pub concluded: Option<Conclusion>,
    /// What is in the way, in words; not a fault.
    pub trouble: Option<String>,
    /// Events that there was no time to look at.
    pub unseen: u64,
    is_passthrough: bool,
    record_ns: u64,
    now_ns: u64,
}

impl Model {
    /// Takes what happened.
    pub fn take(&mut self, event: &Event) {
        self.advance(event.host_ns);
        match event.what {
            What::Asked(sequence, message) => {
                self.link.asked(event.host_ns, sequence, &message);
            }
            What::Told(_, message) => {
                self.link.heard(event.host_ns);
                self.apply_message(event.host_ns, &message);
            }
            What::Lost(_, frames) => self.link.lost(frames),
            What::Garbled(direction, error) => self.link.garbled(direction, error),
            What::Parted => self.link.parted(event.host_ns),
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

    /// Whether somebody is at the other end.
    pub fn line(&self) -> Line {
        self.link.line(self.now_ns)
    }

    /// What the board is doing, as far as is known.
    pub fn mode(&self) -> Option<Mode> {
        if self.is_passthrough {
            return Some(Mode::Passthrough);
        }
        self.record.map(|record| record.mode)
    }

    /// The board's clock in s, carried on from the latest tick.
    pub fn board_s(&self) -> f64 {
        let start_us = self.record.map_or(0, |record| record.start_us);
        let since_ns = self.now_ns.saturating_sub(self.record_ns);
        start_us as f64 * 1e-6 + since_ns as f64 * 1e-9
    }

    fn apply_message(&mut self, now_ns: u64, message: &ToHost) {
        match *message {
            ToHost::Hello(hello) => {
                self.trouble = (hello.schema != schema::HASH)
                    .then(|| "the board runs another version: flash it with this one".to_owned());
            }
            ToHost::Ack {
                sequence, result, ..
            } => self.link.acknowledged(now_ns, sequence, result),
            ToHost::Settings(settings) => self.settings = Some(settings),
            ToHost::Absent { joint, missing } => {
                let servo = u32::from(joint) + 1;
                let why = likely_cause(missing);
                self.trouble = Some(format!("servo {servo} does not answer: {why}"));
            }
            ToHost::Found {
                firmware,
                baud,
                is_ready,
            } => {
                self.found = Some((firmware, baud, is_ready));
                self.trouble = (!is_ready)
                    .then(|| "the stock servos are not in wheel mode: press a to set them".into());
            }
            ToHost::Mixed([first, second]) => {
                self.trouble = Some(format!(
                    "servo 1 runs {first} and servo 2 {second}: flash both alike"
                ));
            }
            ToHost::Unprepared { joint } => {
                let servo = u32::from(joint) + 1;
                self.trouble = Some(format!(
                    "servo {servo} cannot be set to wheel mode: switch its power off and on"
                ));
            }
            ToHost::Passthrough => self.is_passthrough = true,
            ToHost::Board(report) => self.reported(report),
            ToHost::Tripped(trip) => self.trip = Some(trip),
            ToHost::Off(report) => self.off = Some(report),
            ToHost::Temperature { joint, value } => {
                if let Some(known) = self.bus.temperature.get_mut(usize::from(joint)) {
                    *known = Some(value);
                }
            }
            ToHost::Record(record) => self.recorded(now_ns, record),
            ToHost::Concluded(conclusion) => self.concluded = Some(conclusion),
            ToHost::Departs { .. } | ToHost::Began(_) | ToHost::Port(_) => {}
        }
    }

    fn reported(&mut self, report: BoardReport) {
        let before = self.report.replace(report);
        if before.is_some_and(|before| before.is_before_reset(&report)) {
            let why = end_in_words(&report.last_end);
            self.trouble = Some(format!("the board has been reset: {why}"));
        }
    }

    fn recorded(&mut self, now_ns: u64, record: Record) {
        self.is_passthrough = false;
        self.history.take(&record);
        self.bus.take(&record);
        self.link.dropped = u64::from(record.dropped);
        if !matches!(record.mode.drive(), Some(Drive::Hold | Drive::Experiment)) {
            self.concluded = None;
        }
        let is_fault = matches!(record.mode, Mode::Fault(_));
        let was_fault = self
            .record
            .is_some_and(|last| matches!(last.mode, Mode::Fault(_)));
        if was_fault && !is_fault {
            (self.trip, self.off) = (None, None);
        }
        if record.mode.is_armed() {
            self.trouble = None;
        }
        self.record = Some(record);
        self.record_ns = now_ns;
    }
}
