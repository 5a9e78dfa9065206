//! What is counted of a link, and told each second.

use armbridge_client::event::{Direction, EventKind};
use armbridge_shared::link::message::Record;

use super::clock_sync::Line;
use super::proto;

/// Counters since the log began, and spreads since they were told last.
#[derive(Clone, Debug, Default)]
pub(super) struct Counters {
    told: proto::Statistics,
    start_error_us: Spread,
    bus_us: Spread,
    compute_us: Spread,
    delay_us: Spread,
}

impl Counters {
    pub(super) fn count(&mut self, what: &EventKind) {
        let told = &mut self.told;
        match what {
            EventKind::Sent(..) => told.frames_to_board += 1,
            EventKind::Received(..) => told.frames_to_host += 1,
            EventKind::Lost(Direction::ToBoard, lost) => told.lost_to_board += u64::from(*lost),
            EventKind::Lost(Direction::ToHost, lost) => told.lost_to_host += u64::from(*lost),
            EventKind::Damaged(Direction::ToBoard, _) => told.garbled_to_board += 1,
            EventKind::Damaged(Direction::ToHost, _) => told.garbled_to_host += 1,
            EventKind::Disconnected => {}
        }
    }

    pub(super) fn travelled(&mut self, direction: Direction, bytes: usize) {
        match direction {
            Direction::ToBoard => self.told.bytes_to_board += bytes as u64,
            Direction::ToHost => self.told.bytes_to_host += bytes as u64,
        }
    }

    /// Takes the state of the queue; how much more found no room in it.
    pub(super) fn queue(&mut self, [waiting, most, unwritten]: [u64; 3]) -> u64 {
        let more = unwritten.saturating_sub(self.told.unwritten_bytes);
        self.told.queue_bytes = waiting;
        self.told.queue_most_bytes = most;
        self.told.unwritten_bytes = unwritten;
        more
    }

    pub(super) fn tick(&mut self, record: &Record, delay_ns: u64) {
        self.told.ticks += 1;
        self.start_error_us.add(record.timing.start_error_us.into());
        self.bus_us.add(record.timing.bus_us.into());
        self.compute_us
            .add(f64::from(record.timing.compute_ns) / 1e3);
        self.delay_us.add(delay_ns as f64 / 1e3);
    }

    pub(super) fn missing(&mut self, ticks: u32) {
        self.told.missing_ticks += u64::from(ticks);
    }

    /// Ticks that came, and ticks between them that did not.
    pub(super) fn ticks(&self) -> (u64, u64) {
        (self.told.ticks, self.told.missing_ticks)
    }

    /// All of it; spreads begin anew.
    pub(super) fn message(&mut self, host_ns: u64, clock: Option<Line>) -> proto::Statistics {
        proto::Statistics {
            host_ns,
            start_error_us: std::mem::take(&mut self.start_error_us).message(),
            bus_us: std::mem::take(&mut self.bus_us).message(),
            compute_us: std::mem::take(&mut self.compute_us).message(),
            delay_us: std::mem::take(&mut self.delay_us).message(),
            clock_offset_ns: clock.map(|line| line.offset_ns),
            clock_drift_ppm: clock.map(|line| line.drift_ppm),
            ..self.told
        }
    }
}

/// Least, mean and most of some values.
#[derive(Clone, Copy, Debug, Default)]
struct Spread {
    count: u32,
    least: f64,
    sum: f64,
    most: f64,
}

impl Spread {
    fn add(&mut self, value: f64) {
        if self.count == 0 {
            (self.least, self.most) = (value, value);
        }
        self.count += 1;
        self.sum += value;
        self.least = self.least.min(value);
        self.most = self.most.max(value);
    }

    fn message(self) -> Option<proto::Spread> {
        (self.count > 0).then(|| proto::Spread {
            least: self.least,
            mean: self.sum / f64::from(self.count),
            most: self.most,
        })
    }
}
