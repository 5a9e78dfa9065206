//! Fault injection into the bytes between host and board.
//!
//! [`FaultyHost`] wraps a host and works on bytes only. Faults that need
//! well-formed frames, another schema for instance, are
//! those of the host itself.

use std::collections::VecDeque;
use std::ops::Range;

use armbridge_client::Host;
use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg32;

/// Capacity of full-speed USB per millisecond: 19 packets of 64
/// bytes.
const FLOOD_BYTES: usize = 19 * 64;
/// Period of a flood, in µs.
const FLOOD_US: u64 = 1_000;
/// Largest number of garbage bytes between two frames.
const GARBAGE_BYTES: usize = 40;
/// Number of frames that are kept for repetition.
const MEMORY: usize = 64;

/// Fault of a host's bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinkFault {
    /// No bytes arrive, in either direction.
    Vanish,
    /// Nothing is transferred, in either direction; at the end all of it arrives at once.
    Stall,
    /// Random bytes arrive in addition, up to the capacity.
    Flood,
    /// Random bytes precede each message, some of which end where a frame
    /// begins and some do not.
    Garbage,
    /// Earlier messages are repeated beside the present ones, oldest first.
    Repeat,
    /// Earlier messages are repeated, and the present ones are lost.
    RepeatOnly,
}

#[derive(Clone, Debug)]
struct ActiveFault {
    kind: LinkFault,
    during_us: Range<u64>,
    draw: Pcg32,
    next_us: u64,
}

/// A host with injected faults.
#[derive(Debug)]
pub struct FaultyHost<H> {
    /// The host.
    pub host: H,
    faults: Vec<ActiveFault>,
    history: VecDeque<Vec<u8>>,
    bytes: Vec<u8>,
    /// Bytes that wait for the end of a stall, to the board and to the host.
    stalled: [Vec<u8>; 2],
}

impl<H> FaultyHost<H> {
    /// A host without faults.
    pub fn new(host: H) -> Self {
        Self {
            host,
            faults: Vec::new(),
            history: VecDeque::new(),
            bytes: Vec::new(),
            stalled: Default::default(),
        }
    }

    /// Injects a fault during this time, in µs, reproducible by its seed.
    pub fn inject(&mut self, kind: LinkFault, during_us: Range<u64>, seed: u64) {
        /// Stream of the generator; bus and sensors use 0 to 4.
        const STREAM: u64 = 5;

        self.faults.push(ActiveFault {
            kind,
            next_us: during_us.start,
            during_us,
            draw: Pcg32::new(seed, STREAM),
        });
    }

    /// Removes all faults.
    pub(crate) fn clear_faults(&mut self) {
        self.faults.clear();
    }

    fn is_active(&self, kind: LinkFault, now_us: u64) -> bool {
        let is_active =
            |fault: &ActiveFault| fault.kind == kind && fault.during_us.contains(&now_us);
        self.faults.iter().any(is_active)
    }
}

impl ActiveFault {
    /// Applies the fault to these bytes. `history` has the earlier messages.
    fn apply(&mut self, now_us: u64, history: &VecDeque<Vec<u8>>, bytes: &mut Vec<u8>) {
        if !self.during_us.contains(&now_us) {
            return;
        }
        let is_time = now_us >= self.next_us;
        match self.kind {
            LinkFault::Vanish => bytes.clear(),
            LinkFault::Flood if is_time => {
                self.next_us = now_us + FLOOD_US;
                let garbage = self.garbage(FLOOD_BYTES);
                bytes.splice(0..0, garbage);
            }
            LinkFault::Garbage if !bytes.is_empty() => {
                let count = self.below(GARBAGE_BYTES) + 1;
                let mut garbage = self.garbage(count);
                if self.below(2) == 0 {
                    garbage.push(0);
                }
                bytes.splice(0..0, garbage);
            }
            LinkFault::Repeat | LinkFault::RepeatOnly => {
                if self.kind == LinkFault::RepeatOnly {
                    bytes.clear();
                }
                if is_time {
                    // At the rate of a host's own messages.
                    self.next_us = now_us + 50_000;
                    if !history.is_empty() {
                        let index = self.below(history.len());
                        bytes.extend(history.get(index).into_iter().flatten());
                    }
                }
            }
            LinkFault::Flood | LinkFault::Garbage | LinkFault::Stall => {}
        }
    }

    fn garbage(&mut self, count: usize) -> Vec<u8> {
        (0..count).map(|_| self.below(256) as u8).collect()
    }

    fn below(&mut self, end: usize) -> usize {
        Uniform::new(0, end).map_or(0, |range| range.sample(&mut self.draw))
    }

    /// Earliest time of its own next bytes.
    fn wake_at_us(&self) -> u64 {
        let sends_bytes = match self.kind {
            LinkFault::Flood | LinkFault::Repeat | LinkFault::RepeatOnly => true,
            LinkFault::Vanish | LinkFault::Garbage | LinkFault::Stall => false,
        };
        if sends_bytes && self.during_us.contains(&self.next_us) {
            self.next_us
        } else {
            u64::MAX
        }
    }
}

impl<H: Host> Host for FaultyHost<H> {
    type Error = H::Error;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], H::Error> {
        self.bytes.clear();
        self.bytes.extend(self.host.transmit(now_us)?);
        let is_new = (!self.bytes.is_empty()).then(|| self.bytes.clone());
        for fault in &mut self.faults {
            fault.apply(now_us, &self.history, &mut self.bytes);
        }
        let [to_board, _] = &mut self.stalled;
        to_board.append(&mut self.bytes);
        if !self.is_active(LinkFault::Stall, now_us) {
            let [to_board, _] = &mut self.stalled;
            self.bytes.append(to_board);
        }
        self.history.extend(is_new);
        if self.history.len() > MEMORY {
            self.history.pop_front();
        }
        Ok(&self.bytes)
    }

    fn receive(&mut self, now_us: u64, bytes: &[u8]) -> Result<(), H::Error> {
        if self.is_active(LinkFault::Vanish, now_us) {
            return Ok(());
        }
        if self.is_active(LinkFault::Stall, now_us) {
            let [_, to_host] = &mut self.stalled;
            to_host.extend_from_slice(bytes);
            return Ok(());
        }
        let [_, to_host] = &mut self.stalled;
        if to_host.is_empty() {
            return self.host.receive(now_us, bytes);
        }
        to_host.extend_from_slice(bytes);
        let bytes = std::mem::take(to_host);
        self.host.receive(now_us, &bytes)
    }

    fn wake_at_us(&self) -> u64 {
        let faults = self.faults.iter().map(ActiveFault::wake_at_us);
        faults.fold(self.host.wake_at_us(), u64::min)
    }

    fn is_done(&self) -> bool {
        self.host.is_done()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sends the number of the millisecond, each millisecond.
    struct Counter {
        next_us: u64,
        bytes: [u8; 1],
        received: usize,
    }

    impl Host for Counter {
        type Error = std::convert::Infallible;

        fn transmit(&mut self, now_us: u64) -> Result<&[u8], Self::Error> {
            if now_us < self.next_us {
                return Ok(&[]);
            }
            self.next_us = now_us + 1_000;
            self.bytes = [(now_us / 1_000) as u8];
            Ok(&self.bytes)
        }

        fn receive(&mut self, _now_us: u64, bytes: &[u8]) -> Result<(), Self::Error> {
            self.received += bytes.len();
            Ok(())
        }

        fn wake_at_us(&self) -> u64 {
            self.next_us
        }

        fn is_done(&self) -> bool {
            false
        }
    }

    /// Bytes that arrive in each of the first ten milliseconds, and bytes received.
    fn arrives(kind: LinkFault) -> (Vec<Vec<u8>>, usize) {
        let mut host = FaultyHost::new(Counter {
            next_us: 0,
            bytes: [0],
            received: 0,
        });
        host.inject(kind, 5_000..8_000, 1);
        let mut arrived = Vec::new();
        while host.wake_at_us() < 10_000 {
            let now_us = host.wake_at_us();
            let Ok(bytes) = host.transmit(now_us);
            arrived.push(bytes.to_vec());
            let Ok(()) = host.receive(now_us, &[0]);
        }
        (arrived, host.host.received)
    }

    #[test]
    fn each_fault_acts_during_its_time_only() {
        let own = |ms: u8| vec![ms];
        let (vanished, received) = arrives(LinkFault::Vanish);
        assert_eq!((vanished.len(), received), (10, 7));
        assert!(vanished[5..8].iter().all(Vec::is_empty));
        assert_eq!((&vanished[4], &vanished[8]), (&own(4), &own(8)));

        let (flooded, _) = arrives(LinkFault::Flood);
        assert!(
            flooded[5..8]
                .iter()
                .all(|bytes| bytes.len() == FLOOD_BYTES + 1)
        );
        let (mixed, _) = arrives(LinkFault::Garbage);
        assert!((5..8).all(|ms| mixed[ms].len() > 1 && mixed[ms].ends_with(&[ms as u8])));
        let (stalled, received) = arrives(LinkFault::Stall);
        assert!(stalled[5..8].iter().all(Vec::is_empty));
        assert_eq!((stalled[8].as_slice(), received), (&[5, 6, 7, 8][..], 10));
        let (repeated, _) = arrives(LinkFault::Repeat);
        assert!(repeated[5][0] == 5 && repeated[5][1] < 5 && repeated[6] == own(6));
        let (repeated, _) = arrives(LinkFault::RepeatOnly);
        assert!(repeated[5][0] < 5 && repeated[6].is_empty());
        for bytes in [flooded, mixed, repeated] {
            assert_eq!((&bytes[4], &bytes[8]), (&own(4), &own(8)));
        }
    }
}
