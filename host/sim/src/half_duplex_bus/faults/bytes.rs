//! Damage to bytes between the master and its bus: a worn plug, an
//! adapter whose buffer runs over, a line driver that is switched too late.
//!
//! Damage occurs at the master's plug. Bytes of the master reach all servos alike, and
//! a servo's reply reaches the other servos undamaged.

use rand_distr::{Bernoulli, Distribution, Uniform};
use rand_pcg::Pcg32;

use super::super::line::BITS;

/// A silence of this length ends a packet: twice the longest between two bytes of a
/// servo's answer, and less than any that the master leaves between packets.
const PAUSE_NS: u64 = 20_000;

/// Which way a byte goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Way {
    /// From the master to the servos.
    ToServos,
    /// From a servo to the master.
    ToMaster,
}

/// Kinds of damage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Damage {
    /// It never arrives; those after it arrive when they should.
    Lost,
    /// It arrives later, and with it all of its packet that comes after it. Of a
    /// packet one byte at most is hit, and nothing overtakes it.
    Late {
        /// Its delay.
        ns: u64,
    },
    /// It arrives twice; the rest of its packet has to wait.
    Doubled,
    /// One of its bits is turned.
    Flipped,
    /// It never arrives, nor does the rest of its packet.
    CutOff,
}

/// Damage to bytes of one direction, each with the same probability.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ByteFault {
    /// Which bytes.
    pub way: Way,
    /// Kind of damage.
    pub damage: Damage,
    /// Share of bytes that are hit, 0 to 1.
    pub share: f64,
    /// From then on, in ns,
    pub from_ns: u64,
    /// and until then.
    pub until_ns: u64,
    /// Which ones: the same for the same seed.
    pub seed: u64,
}

/// One direction, and its faults.
#[derive(Clone, Debug, Default)]
pub(super) struct Channel {
    faults: Vec<(ByteFault, Bernoulli, Pcg32)>,
    /// Time of the last byte, without damage.
    last_ns: u64,
    /// How late the packet under way is.
    late_ns: u64,
    /// When the next byte can arrive at the earliest.
    free_ns: u64,
    /// The rest of the packet under way is lost.
    is_cut: bool,
}

/// A byte, and when it arrives.
pub(super) type Passed = (u8, u64);

impl Channel {
    /// A share that is none hits nothing.
    pub(super) fn add(&mut self, fault: ByteFault) {
        /// Apart from the encoders' streams and those of
        /// [`Disturbance`](super::super::Disturbance), which are 0 to 2.
        const STREAM: u64 = 3;

        if let Ok(hits) = Bernoulli::new(fault.share) {
            let draw = Pcg32::new(fault.seed, STREAM);
            self.faults.push((fault, hits, draw));
        }
    }

    /// Removes all faults.
    pub(super) fn clear(&mut self) {
        self.faults.clear();
    }

    /// Whether bytes pass undamaged.
    pub(super) fn is_sound(&self) -> bool {
        self.faults.is_empty()
    }

    /// A byte that should arrive at `at_ns`, as it does: not at all, once or
    /// twice.
    pub(super) fn pass(&mut self, byte: u8, at_ns: u64, bit_ns: u64) -> [Option<Passed>; 2] {
        let byte_ns = BITS * bit_ns;
        if at_ns > self.last_ns + byte_ns + PAUSE_NS {
            self.late_ns = 0;
            self.is_cut = false;
        }
        self.last_ns = at_ns;
        let (mut byte, mut count, mut more_ns) = (byte, usize::from(!self.is_cut), 0);
        for (fault, hits, draw) in &mut self.faults {
            let is_now = (fault.from_ns..fault.until_ns).contains(&at_ns);
            if !is_now || !hits.sample(draw) {
                continue;
            }
            match fault.damage {
                Damage::Lost => count = 0,
                Damage::Late { ns } => self.late_ns = self.late_ns.max(ns),
                Damage::Doubled => {
                    count *= 2;
                    more_ns = byte_ns;
                }
                Damage::Flipped => {
                    let bit = Uniform::new(0, 8).map_or(0, |bits| bits.sample(draw));
                    byte ^= 1 << bit;
                }
                Damage::CutOff => {
                    self.is_cut = true;
                    count = 0;
                }
            }
        }
        let first_ns = self.free_ns.max(at_ns + self.late_ns);
        self.late_ns += more_ns;
        self.free_ns = first_ns + byte_ns * count as u64;
        [
            (count > 0).then_some((byte, first_ns)),
            (count > 1).then_some((byte, first_ns + byte_ns)),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BIT_NS: u64 = 1_000;
    const BYTE_NS: u64 = BITS * BIT_NS;

    /// Two packets of four bytes with a pause between, as they come out when
    /// the second byte of the first, and no other, is hit.
    fn passed(damage: Damage) -> Vec<Passed> {
        let mut channel = Channel::default();
        channel.add(ByteFault {
            way: Way::ToMaster,
            damage,
            share: 1.0,
            from_ns: BYTE_NS,
            until_ns: BYTE_NS + 1,
            seed: 1,
        });
        let starts = (0..4).chain(10..14).map(|byte| byte * BYTE_NS);
        let mut bytes = 0..;
        starts
            .flat_map(|at_ns| channel.pass(bytes.next().unwrap(), at_ns, BIT_NS))
            .flatten()
            .map(|(byte, ns)| (byte, ns / BYTE_NS))
            .collect()
    }

    #[test]
    fn harm_stays_within_the_packet() {
        let second = [(4, 10), (5, 11), (6, 12), (7, 13)];
        let cases: [(_, &[Passed]); 4] = [
            (Damage::Lost, &[(0, 0), (2, 2), (3, 3)]),
            (Damage::CutOff, &[(0, 0)]),
            (Damage::Doubled, &[(0, 0), (1, 1), (1, 2), (2, 3), (3, 4)]),
            (
                Damage::Late { ns: 3 * BYTE_NS },
                &[(0, 0), (1, 4), (2, 5), (3, 6)],
            ),
        ];
        for (damage, first) in cases {
            assert_eq!(passed(damage), [first, &second].concat(), "{damage:?}");
        }
        let flipped = passed(Damage::Flipped);
        assert_eq!((flipped[1].0 ^ 1).count_ones(), 1);
        assert_eq!((flipped.len(), flipped[2]), (8, (2, 2)));
    }

    #[test]
    fn as_many_are_hit_as_were_asked_for() {
        let mut channel = Channel::default();
        channel.add(ByteFault {
            way: Way::ToServos,
            damage: Damage::Lost,
            share: 0.1,
            from_ns: 0,
            until_ns: u64::MAX,
            seed: 7,
        });
        let lost = (0..10_000)
            .map(|byte| channel.pass(0, byte * BYTE_NS, BIT_NS))
            .filter(|[first, _]| first.is_none())
            .count();
        assert!((900..1_100).contains(&lost), "{lost}");
    }
}
