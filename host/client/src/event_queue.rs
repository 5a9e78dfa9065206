//! Queue of a link's events, from the thread that serves the link to another one.
//!
//! The queue is bounded: when the reader is too slow, the oldest events are dropped and
//! counted. The link's thread waits at most for a swap of two queues.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use crate::Tap;
use crate::event::{Direction, Event, EventKind, LinkDecoder};

/// Capacity: more than 4 s at 1 kHz.
const CAPACITY: usize = 8192;

/// Reader's end.
#[derive(Clone, Debug, Default)]
pub struct EventQueue(Arc<Mutex<Queue>>);

#[derive(Debug, Default)]
struct Queue {
    events: VecDeque<Event>,
    dropped: u64,
    /// Link time and wall-clock time of the latest event.
    latest: Option<(u64, Instant)>,
}

impl EventQueue {
    /// Writer's end.
    pub fn tap(&self) -> Box<dyn Tap> {
        Box::new(QueueTap {
            decoder: LinkDecoder::default(),
            queue: self.clone(),
        })
    }

    /// Swaps the queued events with `events`, which is emptied; returns how many were
    /// dropped since the last call.
    pub fn take(&self, events: &mut VecDeque<Event>) -> u64 {
        events.clear();
        self.with(|queue| {
            std::mem::swap(&mut queue.events, events);
            std::mem::take(&mut queue.dropped)
        })
    }

    /// Time on the link's clock, in ns; `None` before the first event.
    pub fn now_ns(&self) -> Option<u64> {
        let (host_ns, at) = self.with(|queue| queue.latest)?;
        Some(host_ns + at.elapsed().as_nanos() as u64)
    }

    fn with<T>(&self, access: impl FnOnce(&mut Queue) -> T) -> T {
        // The queue is consistent even if a thread panicked.
        access(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

struct QueueTap {
    decoder: LinkDecoder,
    queue: EventQueue,
}

impl Tap for QueueTap {
    fn bytes(&mut self, direction: Direction, host_ns: u64, bytes: &[u8]) {
        let Self { decoder, queue } = self;
        queue.with(|queue| {
            decoder.take(direction, host_ns, bytes, |event| queue.push(event));
        });
    }

    fn disconnected(&mut self, host_ns: u64) {
        // The next connection begins with a new frame.
        self.decoder = LinkDecoder::default();
        let kind = EventKind::Disconnected;
        self.queue.with(|queue| queue.push(Event { host_ns, kind }));
    }
}

impl Queue {
    #[expect(
        clippy::large_types_passed_by_value,
        reason = "it is moved into the queue"
    )]
    fn push(&mut self, event: Event) {
        if self.events.len() == CAPACITY {
            self.events.pop_front();
            self.dropped += 1;
        }
        self.events.push_back(event);
        self.latest = Some((event.host_ns, Instant::now()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_reader_has_the_latest_events_and_the_number_dropped() {
        let shared = EventQueue::default();
        let mut tap = shared.tap();
        for host_ns in 0..CAPACITY as u64 + 10 {
            tap.disconnected(host_ns);
        }
        let mut events = VecDeque::new();
        assert_eq!(shared.take(&mut events), 10);
        assert_eq!(events.len(), CAPACITY);
        assert_eq!(events.front().map(|event| event.host_ns), Some(10));
        assert_eq!(shared.take(&mut events), 0);
        assert!(events.is_empty());
        assert!(
            shared
                .now_ns()
                .is_some_and(|now_ns| now_ns >= CAPACITY as u64)
        );
    }
}
