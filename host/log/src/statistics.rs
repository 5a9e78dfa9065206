//! Statistics of a link, for a message each second.

use armbridge_client::event::{Direction, EventKind};
use armbridge_link::message::Record;

use super::clock_sync::Line;
use super::proto;

/// Counters since the start of the log, and spreads since the last message.
#[derive(Clone, Debug, Default)]
pub(super) struct Counters {
    totals: proto::Statistics,
    start_error_us: Spread,
    bus_us: Spread,
    compute_us: Spread,
    delay_us: Spread,
}

impl Counters {
    pub(super) fn count(&mut self, event: &EventKind) {
        let totals = &mut self.totals;
        match event {
            EventKind::Sent(..) => totals.frames_to_board += 1,
            EventKind::Received(..) => totals.frames_to_host += 1,
            EventKind::Lost(Direction::ToBoard, lost) => totals.lost_to_board += u64::from(*lost),
            EventKind::Lost(Direction::ToHost, lost) => totals.lost_to_host += u64::from(*lost),
            EventKind::Damaged(Direction::ToBoard, _) => totals.garbled_to_board += 1,
            EventKind::Damaged(Direction::ToHost, _) => totals.garbled_to_host += 1,
            EventKind::Disconnected => {}
        }
    }

    pub(super) fn count_bytes(&mut self, direction: Direction, bytes: usize) {
        match direction {
            Direction::ToBoard => self.totals.bytes_to_board += bytes as u64,
            Direction::ToHost => self.totals.bytes_to_host += bytes as u64,
        }
    }

    /// Adds the state of the queue; returns how many more bytes did not fit.
    pub(super) fn queue(&mut self, [waiting, most, unwritten]: [u64; 3]) -> u64 {
        let more = unwritten.saturating_sub(self.totals.unwritten_bytes);
        self.totals.queue_bytes = waiting;
        self.totals.queue_most_bytes = most;
        self.totals.unwritten_bytes = unwritten;
        more
    }

    pub(super) fn tick(&mut self, record: &Record, delay_ns: u64) {
        self.totals.ticks += 1;
        self.start_error_us.add(record.timing.start_error_us.into());
        self.bus_us.add(record.timing.bus_us.into());
        self.compute_us
            .add(f64::from(record.timing.compute_ns) / 1e3);
        self.delay_us.add(delay_ns as f64 / 1e3);
    }

    pub(super) fn missing(&mut self, ticks: u32) {
        self.totals.missing_ticks += u64::from(ticks);
    }

    /// Received ticks, and missing ticks between them.
    pub(super) fn ticks(&self) -> (u64, u64) {
        (self.totals.ticks, self.totals.missing_ticks)
    }

    /// The message; spreads restart.
    pub(super) fn message(&mut self, host_ns: u64, clock: Option<Line>) -> proto::Statistics {
        proto::Statistics {
            host_ns,
            start_error_us: std::mem::take(&mut self.start_error_us).message(),
            bus_us: std::mem::take(&mut self.bus_us).message(),
            compute_us: std::mem::take(&mut self.compute_us).message(),
            delay_us: std::mem::take(&mut self.delay_us).message(),
            clock_offset_ns: clock.map(|line| line.offset_ns),
            clock_drift_ppm: clock.map(|line| line.drift_ppm),
            ..self.totals
        }
    }
}

/// Minimum, mean and maximum of values.
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
