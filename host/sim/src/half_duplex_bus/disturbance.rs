//! Corrupted replies at the master's receiver: a poor contact, a spark, a brush.
//!
//! The servos receive each other's bytes unchanged, so each lost reply is exactly one
//! sample.

use rand_distr::{Bernoulli, Distribution, Uniform};
use rand_pcg::Pcg32;

/// Bytes of a position reply in which a bit may be flipped: all but the length.
/// A wrong length would consume the other servo's reply as well, and lose both.
const CORRUPTIBLE_BYTES: [usize; 6] = [0, 1, 2, 4, 5, 6];

/// Flips one bit of randomly selected replies.
#[derive(Clone, Debug)]
pub struct Disturbance {
    is_corrupted: Bernoulli,
    draw: Pcg32,
    reply: Option<Reply>,
}

/// The present reply.
#[derive(Clone, Copy, Debug)]
struct Reply {
    servo: usize,
    /// Bytes so far.
    bytes: usize,
    /// The byte to change, and its flipped bits.
    corruption: Option<(usize, u8)>,
}

impl Disturbance {
    /// Corrupts this share of replies, the same ones for the same seed; `None` if
    /// it is not a probability.
    pub fn new(share: f64, seed: u64) -> Option<Self> {
        /// Stream of the generator; the encoders use 0 and 1.
        const STREAM: u64 = 2;

        Some(Self {
            is_corrupted: Bernoulli::new(share).ok()?,
            draw: Pcg32::new(seed, STREAM),
            reply: None,
        })
    }

    /// A servo's byte as received by the master.
    pub(super) fn byte(&mut self, servo: usize, byte: u8) -> u8 {
        let mut reply = match self.reply {
            Some(reply) if reply.servo == servo => reply,
            _ => self.begin(servo),
        };
        let received = match reply.corruption {
            Some((at, bit)) if at == reply.bytes => byte ^ bit,
            _ => byte,
        };
        reply.bytes += 1;
        self.reply = Some(reply);
        received
    }

    /// Ends the reply of a servo that released the line.
    pub(super) fn released(&mut self, servo: usize) {
        self.reply.take_if(|reply| reply.servo == servo);
    }

    fn begin(&mut self, servo: usize) -> Reply {
        let selected = self.is_corrupted.sample(&mut self.draw);
        let corruption = selected.then(|| {
            let index = self.below(CORRUPTIBLE_BYTES.len());
            (CORRUPTIBLE_BYTES[index], 1 << self.below(8))
        });
        Reply {
            servo,
            bytes: 0,
            corruption,
        }
    }

    fn below(&mut self, end: usize) -> usize {
        Uniform::new(0, end).map_or(0, |range| range.sample(&mut self.draw))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bits flipped in a reply of seven bytes.
    fn flipped_bits(disturbance: &mut Disturbance, servo: usize) -> u32 {
        let bits = (0..7)
            .map(|_| disturbance.byte(servo, 0xA5) ^ 0xA5)
            .map(u8::count_ones)
            .sum();
        disturbance.released(servo);
        bits
    }

    #[test]
    fn one_bit_of_the_configured_share_of_replies_is_flipped() {
        let mut disturbance = Disturbance::new(0.2, 1).unwrap();
        let mut again = disturbance.clone();
        let mut lost = 0;
        for reply in 0..10_000 {
            let bits = flipped_bits(&mut disturbance, reply % 2);
            assert_eq!(bits, flipped_bits(&mut again, reply % 2));
            assert!(bits <= 1);
            lost += bits;
        }
        assert!((1_900..2_100).contains(&lost), "{lost}");
        assert!(Disturbance::new(1.1, 1).is_none());
    }
}
