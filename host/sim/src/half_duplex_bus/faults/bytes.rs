//! Damage to bytes between the master and its bus: a worn plug, an
//! adapter with a buffer overflow, a line driver that is switched too late.
//!
//! Damage occurs at the master's plug. Bytes of the master reach all servos alike, and
//! a servo's reply reaches the other servos undamaged.

use rand_distr::{Bernoulli, Distribution, Uniform};
use rand_pcg::Pcg32;

use super::super::line::BITS;

/// Silence that ends a packet: twice the longest between two bytes of a servo's reply,
/// and less than any between packets of the master.
const PAUSE_NS: u64 = 20_000;

/// Most bytes that wait for those before them that arrive twice.
const BACKLOG_BYTES: u64 = 256;

/// Direction of a byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BusDirection {
    /// From the master to the servos.
    ToServos,
    /// From a servo to the master.
    ToMaster,
}

/// Kinds of damage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ByteDamage {
    /// It never arrives; later bytes arrive in time.
    Lost,
    /// It arrives later, and so does the rest of its packet. At most one byte of a
    /// packet is delayed, and the order of bytes is kept.
    Late {
        /// Its delay.
        ns: u64,
    },
    /// It arrives twice, which delays the rest of its packet. Once [`BACKLOG_BYTES`] wait,
    /// later ones arrive once: a buffer has an end.
    Doubled,
    /// One of its bits is flipped.
    Flipped,
    /// It never arrives, nor does the rest of its packet.
    CutOff,
}

/// Damage to bytes of one direction, each with the same probability.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ByteFault {
    /// Direction of the bytes.
    pub direction: BusDirection,
    /// Kind of damage.
    pub damage: ByteDamage,
    /// Probability for each byte, 0 to 1.
    pub share: f64,
    /// Start, in ns.
    pub from_ns: u64,
    /// End, in ns.
    pub until_ns: u64,
    /// Seed of the random selection.
    pub seed: u64,
}

/// One direction of the bus, with its faults.
#[derive(Clone, Debug, Default)]
pub(super) struct FaultyChannel {
    faults: Vec<(ByteFault, Bernoulli, Pcg32)>,
    /// Time of the last byte, without damage.
    last_ns: u64,
    /// Delay of the present packet.
    late_ns: u64,
    /// Earliest arrival of the next byte.
    free_ns: u64,
    /// The rest of the present packet is lost.
    is_cut: bool,
}

/// A byte, and its arrival in ns.
pub(super) type DeliveredByte = (u8, u64);

impl FaultyChannel {
    /// Adds a fault; one whose share is not a probability has no effect.
    pub(super) fn add(&mut self, fault: ByteFault) {
        /// Stream of the generator; the encoders and
        /// [`Disturbance`](super::super::Disturbance) use 0 to 2.
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
    pub(super) fn has_no_faults(&self) -> bool {
        self.faults.is_empty()
    }

    /// Applies the faults to a byte that is due at `at_ns`; it arrives not at all, once or
    /// twice.
    pub(super) fn pass(&mut self, byte: u8, at_ns: u64, bit_ns: u64) -> [Option<DeliveredByte>; 2] {
        let byte_ns = BITS * bit_ns;
        if at_ns > self.last_ns + byte_ns + PAUSE_NS {
            self.late_ns = 0;
            self.is_cut = false;
        }
        self.last_ns = at_ns;
        let (mut byte, mut count, mut added_ns) = (byte, usize::from(!self.is_cut), 0);
        for (fault, hits, draw) in &mut self.faults {
            let is_now = (fault.from_ns..fault.until_ns).contains(&at_ns);
            if !is_now || !hits.sample(draw) {
                continue;
            }
            match fault.damage {
                ByteDamage::Lost => count = 0,
                ByteDamage::Late { ns } => self.late_ns = self.late_ns.max(ns),
                ByteDamage::Doubled => {
                    if self.free_ns < at_ns + BACKLOG_BYTES * byte_ns {
                        count *= 2;
                        added_ns = byte_ns;
                    }
                }
                ByteDamage::Flipped => {
                    let bit = Uniform::new(0, 8).map_or(0, |bits| bits.sample(draw));
                    byte ^= 1 << bit;
                }
                ByteDamage::CutOff => {
                    self.is_cut = true;
                    count = 0;
                }
            }
        }
        let first_ns = self.free_ns.max(at_ns + self.late_ns);
        self.late_ns += added_ns;
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

    /// Two packets of four bytes with a pause between them, with damage to only the second
    /// byte of the first.
    fn passed(damage: ByteDamage) -> Vec<DeliveredByte> {
        let mut channel = FaultyChannel::default();
        channel.add(ByteFault {
            direction: BusDirection::ToMaster,
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
    fn damage_stays_within_the_packet() {
        let second = [(4, 10), (5, 11), (6, 12), (7, 13)];
        let cases: [(_, &[DeliveredByte]); 4] = [
            (ByteDamage::Lost, &[(0, 0), (2, 2), (3, 3)]),
            (ByteDamage::CutOff, &[(0, 0)]),
            (
                ByteDamage::Doubled,
                &[(0, 0), (1, 1), (1, 2), (2, 3), (3, 4)],
            ),
            (
                ByteDamage::Late { ns: 3 * BYTE_NS },
                &[(0, 0), (1, 4), (2, 5), (3, 6)],
            ),
        ];
        for (damage, first) in cases {
            assert_eq!(passed(damage), [first, &second].concat(), "{damage:?}");
        }
        let flipped = passed(ByteDamage::Flipped);
        assert_eq!((flipped[1].0 ^ 1).count_ones(), 1);
        assert_eq!((flipped.len(), flipped[2]), (8, (2, 2)));
    }

    #[test]
    fn the_share_of_damaged_bytes_is_the_configured_one() {
        let mut channel = FaultyChannel::default();
        channel.add(ByteFault {
            direction: BusDirection::ToServos,
            damage: ByteDamage::Lost,
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
