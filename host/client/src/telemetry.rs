//! Telemetry: the records of a board's ticks, in blocks, from the thread that serves the link to
//! another one.
//!
//! Records are kept in blocks of [`BLOCK`], which the reader takes without a copy. Up to
//! [`CAPACITY`] wait; then the oldest block is discarded, and its records count as lost, like
//! those that are missing between two ticks of one connection.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use armbridge_link::message::{Record, ToHost};

use crate::Tap;
use crate::board_clock::ClockOffset;
use crate::event::{Direction, EventKind, LinkDecoder};

/// Records of a block.
pub const BLOCK: usize = 250;
/// Records that wait for a reader: a minute at 1 kHz.
pub const CAPACITY: usize = 60_000;

/// Reader's end.
#[derive(Clone, Debug, Default)]
pub struct Telemetry(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    queue: Mutex<Queue>,
    grown: Condvar,
}

#[derive(Debug, Default)]
struct Queue {
    blocks: VecDeque<Vec<Record>>,
    waiting: usize,
    /// Number of the last tick of this connection.
    last_tick: Option<u32>,
    lost: u64,
    /// Records since [`Telemetry::begin_copy`].
    copy: Option<Vec<Record>>,
    /// The board's clock, against the time since a moment of this process.
    clock: Option<(Instant, ClockOffset)>,
    is_closed: bool,
}

impl Telemetry {
    /// Writer's end; the queue is closed when it is dropped.
    pub fn tap(&self) -> Box<dyn Tap> {
        Box::new(TelemetryTap {
            decoder: LinkDecoder::default(),
            telemetry: self.clone(),
        })
    }

    /// Waits until `count` records are there, and takes them, oldest first. `None` after the
    /// timeout, by which nothing is taken, and if the link has ended before.
    pub fn take(&self, count: usize, timeout: Duration) -> Option<Vec<Vec<Record>>> {
        let lacks = |queue: &mut Queue| queue.waiting < count && !queue.is_closed;
        let waited = self
            .0
            .grown
            .wait_timeout_while(self.lock(), timeout, lacks)
            .unwrap_or_else(PoisonError::into_inner);
        let mut queue = waited.0;
        (queue.waiting >= count).then(|| queue.take(count))
    }

    /// Takes all records that wait.
    pub fn drain(&self) -> Vec<Vec<Record>> {
        let mut queue = self.lock();
        let waiting = queue.waiting;
        queue.take(waiting)
    }

    /// Begins a copy of the records that come, for a reader beside the one that takes them.
    pub fn begin_copy(&self) {
        self.lock().copy = Some(Vec::new());
    }

    /// Ends the copy, and returns it.
    pub fn end_copy(&self) -> Vec<Record> {
        self.lock().copy.take().unwrap_or_default()
    }

    /// Number of records that wait.
    pub fn waiting(&self) -> usize {
        self.lock().waiting
    }

    /// Number of records lost so far, on the link or because the reader was too slow.
    pub fn lost(&self) -> u64 {
        self.lock().lost
    }

    /// Time on the board's clock in µs, as of this moment; 0 before the first record.
    pub fn board_us(&self, at: Instant) -> u64 {
        self.lock().clock.map_or(0, |(begun, clock)| {
            clock.board_us(at.saturating_duration_since(begun).as_micros() as u64)
        })
    }

    /// Whether the link has ended, by which no further record comes.
    pub fn is_closed(&self) -> bool {
        self.lock().is_closed
    }

    fn lock(&self) -> MutexGuard<'_, Queue> {
        // The queue is consistent even if a thread panicked.
        self.0.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Queue {
    fn push(&mut self, record: &Record) {
        if let Some(last) = self.last_tick.replace(record.tick) {
            // After a reset the ticks begin again.
            let ahead = record.tick.wrapping_sub(last);
            self.lost += u64::from(ahead.saturating_sub(1)) * u64::from(record.tick > last);
        }
        if self.waiting == CAPACITY {
            let oldest = self.blocks.pop_front().map_or(0, |block| block.len());
            self.waiting -= oldest;
            self.lost += oldest as u64;
        }
        if let Some(block) = self.blocks.back_mut().filter(|block| block.len() < BLOCK) {
            block.push(*record);
        } else {
            let mut block = Vec::with_capacity(BLOCK);
            block.push(*record);
            self.blocks.push_back(block);
        }
        self.waiting += 1;
        self.copy.iter_mut().for_each(|copy| copy.push(*record));
        let now = Instant::now();
        let (begun, clock) = self.clock.get_or_insert((now, ClockOffset::default()));
        let now_us = now.duration_since(*begun).as_micros() as u64;
        clock.update(now_us, record.input.start_us);
    }

    /// The first `count` records, of those that wait.
    fn take(&mut self, count: usize) -> Vec<Vec<Record>> {
        let (mut taken, mut left) = (Vec::new(), count);
        while left > 0
            && let Some(mut block) = self.blocks.pop_front()
        {
            if block.len() > left {
                self.blocks.push_front(block.split_off(left));
            }
            left -= block.len();
            self.waiting -= block.len();
            taken.push(block);
        }
        taken
    }
}

struct TelemetryTap {
    decoder: LinkDecoder,
    telemetry: Telemetry,
}

impl Tap for TelemetryTap {
    fn bytes(&mut self, direction: Direction, host_ns: u64, bytes: &[u8]) {
        if direction == Direction::ToBoard {
            return;
        }
        let Self { decoder, telemetry } = self;
        let mut queue = telemetry.lock();
        let before = queue.waiting;
        decoder.take(direction, host_ns, bytes, |event| {
            if let Some(record) = event.record() {
                queue.push(&record);
            } else if let EventKind::Received(_, ToHost::Hello(_)) = event.kind {
                // The ticks before it belong to another session.
                queue.last_tick = None;
            }
        });
        if queue.waiting != before {
            telemetry.0.grown.notify_all();
        }
    }

    fn disconnected(&mut self, _host_ns: u64) {
        // The next connection begins with a new frame.
        self.decoder = LinkDecoder::default();
        let mut queue = self.telemetry.lock();
        (queue.last_tick, queue.clock) = (None, None);
    }
}

impl Drop for TelemetryTap {
    fn drop(&mut self) {
        self.telemetry.lock().is_closed = true;
        self.telemetry.0.grown.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(tick: u32) -> Record {
        Record {
            tick,
            ..Record::NONE
        }
    }

    fn ticks(blocks: &[Vec<Record>]) -> Vec<u32> {
        blocks.iter().flatten().map(|record| record.tick).collect()
    }

    #[test]
    fn blocks_have_every_record_once_and_gaps_are_counted() {
        let telemetry = Telemetry::default();
        telemetry.begin_copy();
        for tick in (0..1_000).chain(1_003..1_010).chain(0..5) {
            telemetry.lock().push(&record(tick));
        }
        assert_eq!(telemetry.end_copy().len(), 1_012);
        assert_eq!((telemetry.waiting(), telemetry.lost()), (1_012, 3));
        let first = telemetry.take(777, Duration::ZERO).unwrap();
        assert_eq!(ticks(&first), (0..777).collect::<Vec<_>>());
        assert!(telemetry.take(777, Duration::ZERO).is_none());
        let second = ticks(&telemetry.drain());
        assert_eq!(second[..2], [777, 778]);
        assert_eq!((second.len(), telemetry.waiting()), (235, 0));
    }

    #[test]
    fn a_reader_that_does_not_read_loses_the_oldest() {
        let telemetry = Telemetry::default();
        for tick in 0..=(CAPACITY as u32) {
            telemetry.lock().push(&record(tick));
        }
        assert_eq!(telemetry.lost(), BLOCK as u64);
        assert_eq!(
            ticks(&telemetry.take(1, Duration::ZERO).unwrap()),
            [BLOCK as u32]
        );
    }

    #[test]
    fn a_link_that_ends_wakes_its_reader() {
        let telemetry = Telemetry::default();
        let tap = telemetry.tap();
        let reader = telemetry.clone();
        let waiting = std::thread::spawn(move || reader.take(1, Duration::from_secs(60)));
        drop(tap);
        assert!(waiting.join().unwrap().is_none() && telemetry.is_closed());
    }
}
