//! Signals of the host to the tick: counters, one writer and one reader, that cannot be full.
//!
//! The writer counts a signal and then, last, in [`SignalCounters::all`]. The reader looks at
//! that word alone while nothing has come, and stores the last observed value of each counter.

use core::sync::atomic::{AtomicU8, AtomicU32, Ordering};

use armbridge_link::message::StopSource;

/// Signals of the host since the tick last read them; none may be refused.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Signals {
    /// Stop at once.
    pub(super) stop: Option<StopSource>,
    /// The host leaves.
    pub(super) goodbye: bool,
    /// A hello was received.
    pub(super) hello: bool,
    /// The host is alive.
    pub(super) heartbeat: bool,
}

/// Counters of signals, modulo 2^32 or 2^8.
#[derive(Debug, Default)]
pub(super) struct SignalCounters {
    /// Number of signals and commands: where it is the same, there is nothing to look for.
    all: AtomicU32,
    epoch: AtomicU32,
    stops: [AtomicU8; StopSource::ALL.len()],
    goodbyes: AtomicU8,
    hellos: AtomicU8,
    heartbeats: AtomicU8,
}

impl SignalCounters {
    /// No signal yet.
    pub(super) const fn new() -> Self {
        Self {
            all: AtomicU32::new(0),
            epoch: AtomicU32::new(0),
            stops: [const { AtomicU8::new(0) }; StopSource::ALL.len()],
            goodbyes: AtomicU8::new(0),
            hellos: AtomicU8::new(0),
            heartbeats: AtomicU8::new(0),
        }
    }

    /// A reader that has seen what there is.
    pub(super) fn reader(&self) -> SignalReader<'_> {
        SignalReader {
            counters: self,
            all: self.all.load(Ordering::Acquire),
            seen: SeenSignals::load(self),
        }
    }

    /// The epoch, for the writer.
    pub(super) fn epoch(&self) -> u32 {
        self.epoch.load(Ordering::Relaxed)
    }

    /// Notes that there is something for the tick, after it is there.
    pub(super) fn note(&self) {
        let all = self.all.load(Ordering::Relaxed).wrapping_add(1);
        self.all.store(all, Ordering::Release);
    }

    /// Begins a new epoch after a signal.
    fn begin_epoch(&self) {
        let epoch = self.epoch().wrapping_add(1);
        self.epoch.store(epoch, Ordering::Release);
        self.note();
    }

    /// Signals a stop.
    pub(super) fn stop(&self, source: StopSource) {
        for (known, counter) in StopSource::ALL.iter().zip(&self.stops) {
            if *known == source {
                count(counter);
            }
        }
        self.begin_epoch();
    }

    /// Signals a hello.
    pub(super) fn hello(&self) {
        count(&self.hellos);
        self.begin_epoch();
    }

    /// Signals that the host leaves.
    pub(super) fn goodbye(&self) {
        count(&self.goodbyes);
        self.note();
    }

    /// Signals that the host is alive.
    pub(super) fn heartbeat(&self) {
        count(&self.heartbeats);
        self.note();
    }
}

/// Increments a counter, which has one writer.
fn count(counter: &AtomicU8) {
    let counted = counter.load(Ordering::Relaxed).wrapping_add(1);
    counter.store(counted, Ordering::Release);
}

/// Values of the counters that the tick has read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct SeenSignals {
    epoch: u32,
    stops: [u8; StopSource::ALL.len()],
    goodbyes: u8,
    hellos: u8,
    heartbeats: u8,
}

impl SeenSignals {
    /// Reads the counters.
    fn load(counters: &SignalCounters) -> Self {
        let byte = |counter: &AtomicU8| counter.load(Ordering::Acquire);
        Self {
            // Read first, so that signals that came with it are seen.
            epoch: counters.epoch.load(Ordering::Acquire),
            stops: counters.stops.each_ref().map(byte),
            goodbyes: byte(&counters.goodbyes),
            hellos: byte(&counters.hellos),
            heartbeats: byte(&counters.heartbeats),
        }
    }
}

/// The tick's end.
pub(super) struct SignalReader<'a> {
    counters: &'a SignalCounters,
    /// [`SignalCounters::all`] when it was last looked at.
    all: u32,
    seen: SeenSignals,
}

impl SignalReader<'_> {
    /// Whether there is a new signal or command since the last call; most polls have none.
    pub(super) fn has_news(&mut self) -> bool {
        // Acquire: what was counted before is seen.
        let all = self.counters.all.load(Ordering::Acquire);
        core::mem::replace(&mut self.all, all) != all
    }

    /// Takes the signals since the last call.
    pub(super) fn take(&mut self) -> Signals {
        let current = SeenSignals::load(self.counters);
        let before = core::mem::replace(&mut self.seen, current);
        let mut stops = StopSource::ALL
            .into_iter()
            .zip(current.stops.iter().zip(before.stops));
        Signals {
            stop: stops.find_map(|(source, (count, before))| (*count != before).then_some(source)),
            goodbye: current.goodbyes != before.goodbyes,
            hello: current.hellos != before.hellos,
            heartbeat: current.heartbeats != before.heartbeats,
        }
    }

    /// The epoch of the last signals.
    pub(super) fn epoch(&self) -> u32 {
        self.seen.epoch
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_signal_is_news_once() {
        let counters = SignalCounters::new();
        let mut reader = counters.reader();
        assert!(!reader.has_news());
        counters.heartbeat();
        counters.stop(StopSource::Flood);
        assert!(reader.has_news() && !reader.has_news());
        let expected = Signals {
            stop: Some(StopSource::Flood),
            heartbeat: true,
            ..Signals::default()
        };
        assert_eq!((reader.take(), reader.epoch()), (expected, 1));
        assert_eq!(reader.take(), Signals::default());
        for signal in [SignalCounters::goodbye, SignalCounters::hello] {
            signal(&counters);
            assert!(reader.has_news() && reader.take() != Signals::default());
        }
    }
}
