//! Queue of a link's bytes to the thread that writes them.
//!
//! The link's thread copies the bytes into bounded memory, and goes
//! on: for a real board it never waits for a disk. Bytes that do not fit are counted. A
//! virtual board can wait, so it does, and nothing is lost however slow the disk is.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use armbridge_client::Tap;
use armbridge_client::event::Direction;

use super::raw_link_bytes;

/// Most bytes in the queue; as many again are being written. At 1 kHz
/// they are four minutes.
pub(super) const MOST: usize = 32 << 20;

/// Bytes at which the recorder is woken before its time, rather than for each write.
const HANDFUL: usize = 256 << 10;

/// Queue between a link and its recorder.
#[derive(Debug)]
pub(super) struct Queue {
    waiting: Mutex<Waiting>,
    /// Enough bytes are queued, or no more will come.
    filled: Condvar,
    /// There is room.
    emptied: Condvar,
    /// Whether the link waits for room.
    is_patient: bool,
    most: usize,
}

/// Contents of the queue.
#[derive(Debug, Default)]
struct Waiting {
    framed: Vec<u8>,
    fullest: usize,
    unwritten: u64,
    is_closed: bool,
}

/// Bytes taken out of the queue.
#[derive(Clone, Copy, Debug)]
pub(super) struct Taken {
    /// Bytes of the link that did not fit so far.
    pub(super) unwritten: u64,
    /// Largest number of queued bytes so far.
    pub(super) fullest: usize,
    /// The last bytes.
    pub(super) is_last: bool,
}

impl Queue {
    pub(super) fn new(is_patient: bool, most: usize) -> Arc<Self> {
        Arc::new(Self {
            waiting: Mutex::default(),
            filled: Condvar::new(),
            emptied: Condvar::new(),
            is_patient,
            most,
        })
    }

    /// The lock is held for a copy or a swap only, which cannot panic.
    fn lock(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn handful(&self) -> usize {
        HANDFUL.min(self.most / 2)
    }

    fn put(&self, piece: raw_link_bytes::Piece<'_>) {
        let len = piece.framed_len();
        let mut waiting = self.lock();
        while self.is_patient
            && !waiting.is_closed
            && !waiting.framed.is_empty()
            && waiting.framed.len() + len > self.most
        {
            waiting = self
                .emptied
                .wait(waiting)
                .unwrap_or_else(PoisonError::into_inner);
        }
        let fits = waiting.framed.len() + len <= self.most;
        // A piece longer than the queue is accepted when it is alone.
        let is_alone = self.is_patient && waiting.framed.is_empty();
        if waiting.is_closed || !(fits || is_alone) {
            waiting.unwritten += piece.bytes.len() as u64;
            return;
        }
        let was_less = waiting.framed.len() < self.handful();
        piece.write(&mut waiting.framed);
        waiting.fullest = waiting.fullest.max(waiting.framed.len());
        let is_enough = waiting.framed.len() >= self.handful();
        drop(waiting);
        if was_less && is_enough {
            self.filled.notify_one();
        }
    }

    /// Takes all queued bytes in exchange for an empty buffer; waits until there are
    /// enough, or until this instant.
    pub(super) fn take(&self, into: &mut Vec<u8>, until: Instant) -> Taken {
        into.clear();
        let mut waiting = self.lock();
        while waiting.framed.len() < self.handful() && !waiting.is_closed {
            let left = until.saturating_duration_since(Instant::now());
            if left == Duration::ZERO {
                break;
            }
            (waiting, _) = self
                .filled
                .wait_timeout(waiting, left)
                .unwrap_or_else(PoisonError::into_inner);
        }
        std::mem::swap(&mut waiting.framed, into);
        let taken = Taken {
            unwritten: waiting.unwritten,
            fullest: waiting.fullest,
            is_last: waiting.is_closed,
        };
        drop(waiting);
        self.emptied.notify_all();
        taken
    }

    /// Closes the queue; later bytes are counted as not written.
    pub(super) fn close(&self) {
        self.lock().is_closed = true;
        self.filled.notify_all();
        self.emptied.notify_all();
    }

    /// Bytes of the link that did not fit.
    pub(super) fn unwritten(&self) -> u64 {
        self.lock().unwritten
    }
}

/// A recorder's tap.
#[derive(Debug)]
pub(super) struct QueueTap(pub(super) Arc<Queue>);

impl Tap for QueueTap {
    fn bytes(&mut self, direction: Direction, host_ns: u64, bytes: &[u8]) {
        self.0.put(raw_link_bytes::Piece {
            host_ns,
            kind: direction.into(),
            bytes,
        });
    }

    fn disconnected(&mut self, host_ns: u64) {
        self.0.put(raw_link_bytes::Piece {
            host_ns,
            kind: raw_link_bytes::Kind::Parted,
            bytes: &[],
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_finds_no_room_is_counted_and_nobody_waits() {
        let queue = Queue::new(false, 100);
        let mut tap = QueueTap(Arc::clone(&queue));
        tap.bytes(Direction::ToHost, 1, &[1; 60]);
        tap.bytes(Direction::ToHost, 2, &[2; 60]);
        tap.bytes(Direction::ToHost, 3, &[3; 10]);
        let mut framed = Vec::new();
        let taken = queue.take(&mut framed, Instant::now());
        assert_eq!(taken.unwritten, 60);
        let times: Vec<_> = raw_link_bytes::pieces(&framed)
            .map(|piece| piece.unwrap().host_ns)
            .collect();
        assert_eq!(times, [1, 3]);
        assert!(taken.fullest <= 100 && !taken.is_last);
    }

    #[test]
    fn who_is_patient_waits_for_room() {
        let queue = Queue::new(true, 100);
        let mut tap = QueueTap(Arc::clone(&queue));
        let sender = std::thread::spawn(move || {
            for i in 0..1_000 {
                tap.bytes(Direction::ToHost, i, &[0; 60]);
            }
            tap.0.close();
        });
        let (mut framed, mut count) = (Vec::new(), 0);
        loop {
            let taken = queue.take(&mut framed, Instant::now() + Duration::from_secs(10));
            count += raw_link_bytes::pieces(&framed).count();
            if taken.is_last {
                assert_eq!(taken.unwritten, 0);
                break;
            }
        }
        sender.join().unwrap();
        assert_eq!(count, 1_000);
    }
}
