//! Queue of a link's bytes to the thread that writes them.
//!
//! The link's thread copies the bytes into bounded memory and continues: for a real board
//! it never waits for a disk. Bytes and events that do not fit are counted. For a virtual board it
//! waits, and nothing is lost at any speed of the disk.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use armbridge_client::Tap;
use armbridge_client::event::Direction;
use armbridge_client::simulation::SimulationEvent;

use super::raw_link_bytes;

/// Capacity in bytes; as many again may be being written. At 1 kHz this is four minutes.
pub(super) const CAPACITY: usize = 32 << 20;

/// Queued bytes at which the recorder is woken before its deadline, rather than at each
/// write.
const WAKE_BYTES: usize = 256 << 10;

/// Queue between a link and its recorder.
#[derive(Debug)]
pub(super) struct Queue {
    contents: Mutex<Contents>,
    /// Signalled when enough bytes are queued, or the queue is closed.
    filled: Condvar,
    /// Signalled when there is room.
    emptied: Condvar,
    /// Whether a full queue blocks the link.
    blocks_when_full: bool,
    capacity: usize,
}

/// Contents of the queue.
#[derive(Debug, Default)]
struct Contents {
    framed: Vec<u8>,
    simulation: Vec<SimulationEvent>,
    peak_bytes: usize,
    unwritten: u64,
    is_closed: bool,
}

/// Bytes taken out of the queue.
#[derive(Clone, Copy, Debug)]
pub(super) struct Drained {
    /// Bytes of the link and of the simulation that did not fit so far.
    pub(super) unwritten: u64,
    /// Largest number of queued bytes so far.
    pub(super) peak_bytes: usize,
    /// The queue is closed: these are the last bytes.
    pub(super) is_last: bool,
}

impl Queue {
    pub(super) fn new(blocks_when_full: bool, capacity: usize) -> Arc<Self> {
        Arc::new(Self {
            contents: Mutex::default(),
            filled: Condvar::new(),
            emptied: Condvar::new(),
            blocks_when_full,
            capacity,
        })
    }

    /// Locks the contents, for a copy or a swap only, which cannot panic.
    fn lock(&self) -> MutexGuard<'_, Contents> {
        self.contents.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wake_bytes(&self) -> usize {
        WAKE_BYTES.min(self.capacity / 2)
    }

    fn put(&self, piece: raw_link_bytes::Piece<'_>) {
        let len = piece.framed_len();
        let mut contents = self.lock();
        while self.blocks_when_full
            && !contents.is_closed
            && !contents.framed.is_empty()
            && contents.framed.len() + len > self.capacity
        {
            contents = self.wait_for_room(contents);
        }
        let fits = contents.framed.len() + len <= self.capacity;
        // A piece longer than the queue is accepted when it is alone.
        let is_alone = self.blocks_when_full && contents.framed.is_empty();
        if contents.is_closed || !(fits || is_alone) {
            contents.unwritten += piece.bytes.len() as u64;
            return;
        }
        let was_below = contents.framed.len() < self.wake_bytes();
        piece.write(&mut contents.framed);
        contents.peak_bytes = contents.peak_bytes.max(contents.framed.len());
        let is_reached = contents.framed.len() >= self.wake_bytes();
        drop(contents);
        if was_below && is_reached {
            self.filled.notify_one();
        }
    }

    fn wait_for_room<'a>(&self, contents: MutexGuard<'a, Contents>) -> MutexGuard<'a, Contents> {
        self.emptied
            .wait(contents)
            .unwrap_or_else(PoisonError::into_inner)
    }

    /// Queues an event of the simulation; one that does not fit is counted by its size.
    fn put_simulated(&self, event: SimulationEvent) {
        let events_max = self.capacity / size_of::<SimulationEvent>();
        let mut contents = self.lock();
        while self.blocks_when_full
            && !contents.is_closed
            && contents.simulation.len() >= events_max
        {
            contents = self.wait_for_room(contents);
        }
        if contents.is_closed || contents.simulation.len() >= events_max {
            contents.unwritten += size_of::<SimulationEvent>() as u64;
            return;
        }
        contents.simulation.push(event);
    }

    /// Takes all queued bytes and events in exchange for empty buffers; waits until there
    /// are enough bytes, or until this instant. Events precede the bytes of their time.
    pub(super) fn take(
        &self,
        into: &mut Vec<u8>,
        simulation: &mut Vec<SimulationEvent>,
        until: Instant,
    ) -> Drained {
        into.clear();
        simulation.clear();
        let mut contents = self.lock();
        while contents.framed.len() < self.wake_bytes() && !contents.is_closed {
            let left = until.saturating_duration_since(Instant::now());
            if left == Duration::ZERO {
                break;
            }
            (contents, _) = self
                .filled
                .wait_timeout(contents, left)
                .unwrap_or_else(PoisonError::into_inner);
        }
        std::mem::swap(&mut contents.framed, into);
        std::mem::swap(&mut contents.simulation, simulation);
        let drained = Drained {
            unwritten: contents.unwritten,
            peak_bytes: contents.peak_bytes,
            is_last: contents.is_closed,
        };
        drop(contents);
        self.emptied.notify_all();
        drained
    }

    /// Closes the queue; later bytes are counted as not written.
    pub(super) fn close(&self) {
        self.lock().is_closed = true;
        self.filled.notify_all();
        self.emptied.notify_all();
    }

    /// Bytes of the link and of the simulation that did not fit.
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
            kind: raw_link_bytes::PieceKind::Disconnected,
            bytes: &[],
        });
    }

    fn takes_simulation(&self) -> bool {
        true
    }

    fn simulated(&mut self, event: &SimulationEvent) {
        self.0.put_simulated(*event);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_without_room_are_counted_without_blocking() {
        let queue = Queue::new(false, 100);
        let mut tap = QueueTap(Arc::clone(&queue));
        tap.bytes(Direction::ToHost, 1, &[1; 60]);
        tap.bytes(Direction::ToHost, 2, &[2; 60]);
        tap.bytes(Direction::ToHost, 3, &[3; 10]);
        let mut framed = Vec::new();
        let drained = queue.take(&mut framed, &mut Vec::new(), Instant::now());
        assert_eq!(drained.unwritten, 60);
        let times: Vec<_> = raw_link_bytes::pieces(&framed)
            .map(|piece| piece.unwrap().host_ns)
            .collect();
        assert_eq!(times, [1, 3]);
        assert!(drained.peak_bytes <= 100 && !drained.is_last);
    }

    #[test]
    fn events_without_room_are_counted_too() {
        let size = size_of::<SimulationEvent>();
        let queue = Queue::new(false, 2 * size);
        let mut tap = QueueTap(Arc::clone(&queue));
        let push = SimulationEvent::Push(armbridge_client::simulation::Push {
            joint: 0,
            torque_nm: 0.1,
            start_ns: 0,
            duration_ns: 1,
        });
        for _ in 0..5 {
            tap.simulated(&push);
        }
        let mut events = Vec::new();
        let drained = queue.take(&mut Vec::new(), &mut events, Instant::now());
        assert_eq!((events.len(), drained.unwritten), (2, 3 * size as u64));
    }

    #[test]
    fn a_blocking_queue_waits_for_room() {
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
            let until = Instant::now() + Duration::from_secs(10);
            let drained = queue.take(&mut framed, &mut Vec::new(), until);
            count += raw_link_bytes::pieces(&framed).count();
            if drained.is_last {
                assert_eq!(drained.unwritten, 0);
                break;
            }
        }
        sender.join().unwrap();
        assert_eq!(count, 1_000);
    }
}
