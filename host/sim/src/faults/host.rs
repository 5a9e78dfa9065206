//! A host whose bytes come to harm before the board hears them.
//!
//! [`Meddled`] stands between a host and its board and knows bytes only. What a
//! host would have to say in well-formed frames, another schema for instance,
//! the host says itself.

use std::collections::VecDeque;
use std::ops::Range;

use armbridge_client::Host;
use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg32;

/// What USB at full speed carries at most each millisecond: 19 packets of 64
/// bytes.
const FLOOD_BYTES: usize = 19 * 64;
/// How often more of it comes, in µs.
const FLOOD_US: u64 = 1_000;
/// Most bytes of garbage between two frames.
const GARBAGE_BYTES: usize = 40;
/// Frames that are remembered, to be said again.
const MEMORY: usize = 64;

/// What happens to a host's bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meddling {
    /// None arrive, either way.
    Vanish,
    /// Random bytes arrive beside them, as many as fit.
    Flood,
    /// Random bytes come before each utterance, some of which end where a frame
    /// begins and some do not.
    Garbage,
    /// What was said before arrives again beside what is said, oldest first.
    Repeat,
    /// What was said before arrives again, and nothing else does.
    RepeatOnly,
}

#[derive(Clone, Debug)]
struct Meddler {
    what: Meddling,
    during_us: Range<u64>,
    draw: Pcg32,
    next_us: u64,
}

/// A host with somebody in between.
#[derive(Debug)]
pub struct Meddled<H> {
    /// The host.
    pub host: H,
    meddlers: Vec<Meddler>,
    said: VecDeque<Vec<u8>>,
    bytes: Vec<u8>,
}

impl<H> Meddled<H> {
    /// Nobody in between yet.
    pub fn new(host: H) -> Self {
        Self {
            host,
            meddlers: Vec::new(),
            said: VecDeque::new(),
            bytes: Vec::new(),
        }
    }

    /// Somebody meddles during this time, in µs, the same way for the same seed.
    pub fn meddle(&mut self, what: Meddling, during_us: Range<u64>, seed: u64) {
        /// Apart from those of bus and sensors, which are 0 to 4.
        const STREAM: u64 = 5;

        self.meddlers.push(Meddler {
            what,
            next_us: during_us.start,
            during_us,
            draw: Pcg32::new(seed, STREAM),
        });
    }

    /// Nobody meddles any more.
    pub fn leave_alone(&mut self) {
        self.meddlers.clear();
    }

    fn is_gone(&self, now_us: u64) -> bool {
        let gone = |m: &Meddler| m.what == Meddling::Vanish && m.during_us.contains(&now_us);
        self.meddlers.iter().any(gone)
    }
}

impl Meddler {
    /// Does to these bytes what it does. `said` is what was said earlier.
    fn meddle(&mut self, now_us: u64, said: &VecDeque<Vec<u8>>, bytes: &mut Vec<u8>) {
        if !self.during_us.contains(&now_us) {
            return;
        }
        let is_time = now_us >= self.next_us;
        match self.what {
            Meddling::Vanish => bytes.clear(),
            Meddling::Flood if is_time => {
                self.next_us = now_us + FLOOD_US;
                let garbage = self.garbage(FLOOD_BYTES);
                bytes.splice(0..0, garbage);
            }
            Meddling::Garbage if !bytes.is_empty() => {
                let many = self.below(GARBAGE_BYTES) + 1;
                let mut garbage = self.garbage(many);
                if self.below(2) == 0 {
                    garbage.push(0);
                }
                bytes.splice(0..0, garbage);
            }
            Meddling::Repeat | Meddling::RepeatOnly => {
                if self.what == Meddling::RepeatOnly {
                    bytes.clear();
                }
                if is_time {
                    // As often as a host says something itself.
                    self.next_us = now_us + 50_000;
                    if !said.is_empty() {
                        let which = self.below(said.len());
                        bytes.extend(said.get(which).into_iter().flatten());
                    }
                }
            }
            Meddling::Flood | Meddling::Garbage => {}
        }
    }

    fn garbage(&mut self, many: usize) -> Vec<u8> {
        (0..many).map(|_| self.below(256) as u8).collect()
    }

    fn below(&mut self, end: usize) -> usize {
        Uniform::new(0, end).map_or(0, |range| range.sample(&mut self.draw))
    }

    /// When it has something to say of itself, at the earliest.
    fn wake_at_us(&self) -> u64 {
        let speaks = match self.what {
            Meddling::Flood | Meddling::Repeat | Meddling::RepeatOnly => true,
            Meddling::Vanish | Meddling::Garbage => false,
        };
        if speaks && self.during_us.contains(&self.next_us) {
            self.next_us
        } else {
            u64::MAX
        }
    }
}

impl<H: Host> Host for Meddled<H> {
    type Error = H::Error;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], H::Error> {
        self.bytes.clear();
        self.bytes.extend(self.host.transmit(now_us)?);
        let is_new = (!self.bytes.is_empty()).then(|| self.bytes.clone());
        for meddler in &mut self.meddlers {
            meddler.meddle(now_us, &self.said, &mut self.bytes);
        }
        self.said.extend(is_new);
        if self.said.len() > MEMORY {
            self.said.pop_front();
        }
        Ok(&self.bytes)
    }

    fn receive(&mut self, now_us: u64, bytes: &[u8]) -> Result<(), H::Error> {
        if self.is_gone(now_us) {
            return Ok(());
        }
        self.host.receive(now_us, bytes)
    }

    fn wake_at_us(&self) -> u64 {
        let meddlers = self.meddlers.iter().map(Meddler::wake_at_us);
        meddlers.fold(self.host.wake_at_us(), u64::min)
    }

    fn is_done(&self) -> bool {
        self.host.is_done()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Says the number of the millisecond, each millisecond.
    struct Counter {
        next_us: u64,
        said: [u8; 1],
        heard: usize,
    }

    impl Host for Counter {
        type Error = std::convert::Infallible;

        fn transmit(&mut self, now_us: u64) -> Result<&[u8], Self::Error> {
            if now_us < self.next_us {
                return Ok(&[]);
            }
            self.next_us = now_us + 1_000;
            self.said = [(now_us / 1_000) as u8];
            Ok(&self.said)
        }

        fn receive(&mut self, _now_us: u64, bytes: &[u8]) -> Result<(), Self::Error> {
            self.heard += bytes.len();
            Ok(())
        }

        fn wake_at_us(&self) -> u64 {
            self.next_us
        }

        fn is_done(&self) -> bool {
            false
        }
    }

    /// What arrives in each of the first ten milliseconds, and bytes heard.
    fn arrives(what: Meddling) -> (Vec<Vec<u8>>, usize) {
        let mut host = Meddled::new(Counter {
            next_us: 0,
            said: [0],
            heard: 0,
        });
        host.meddle(what, 5_000..8_000, 1);
        let mut arrived = Vec::new();
        while host.wake_at_us() < 10_000 {
            let now_us = host.wake_at_us();
            let Ok(bytes) = host.transmit(now_us);
            arrived.push(bytes.to_vec());
            let Ok(()) = host.receive(now_us, &[0]);
        }
        (arrived, host.host.heard)
    }

    #[test]
    fn each_meddles_in_its_way_and_in_its_time() {
        let own = |ms: u8| vec![ms];
        let (vanished, heard) = arrives(Meddling::Vanish);
        assert_eq!((vanished.len(), heard), (10, 7));
        assert!(vanished[5..8].iter().all(Vec::is_empty));
        assert_eq!((&vanished[4], &vanished[8]), (&own(4), &own(8)));

        let (flooded, _) = arrives(Meddling::Flood);
        assert!(
            flooded[5..8]
                .iter()
                .all(|said| said.len() == FLOOD_BYTES + 1)
        );
        let (babbled, _) = arrives(Meddling::Garbage);
        assert!((5..8).all(|ms| babbled[ms].len() > 1 && babbled[ms].ends_with(&[ms as u8])));
        let (repeated, _) = arrives(Meddling::Repeat);
        assert!(repeated[5][0] == 5 && repeated[5][1] < 5 && repeated[6] == own(6));
        let (repeated, _) = arrives(Meddling::RepeatOnly);
        assert!(repeated[5][0] < 5 && repeated[6].is_empty());
        for said in [flooded, babbled, repeated] {
            assert_eq!((&said[4], &said[8]), (&own(4), &own(8)));
        }
    }
}
