//! Replies that reach the master spoiled: a poor contact, a spark, a brush.
//!
//! The servos receive one another undisturbed, so each lost reply is one sample
//! and no more.

use rand_distr::{Bernoulli, Distribution, Uniform};
use rand_pcg::Pcg32;

/// Bytes of a position reply in which a bit may be turned: all but the length.
/// A wrong length would swallow the other servo's reply, and be two lost.
const SPOILED: [usize; 6] = [0, 1, 2, 4, 5, 6];

/// Turns one bit of some replies, drawn at random.
#[derive(Clone, Debug)]
pub struct Disturbance {
    spoils: Bernoulli,
    draw: Pcg32,
    reply: Option<Reply>,
}

/// The reply under way.
#[derive(Clone, Copy, Debug)]
struct Reply {
    servo: usize,
    /// Bytes of it so far.
    bytes: usize,
    /// The byte to change, and its flipped bits.
    spoil: Option<(usize, u8)>,
}

impl Disturbance {
    /// Spoils this share of replies, the same ones for the same seed; `None` if
    /// it is no share.
    pub fn new(share: f64, seed: u64) -> Option<Self> {
        /// Apart from the encoders' streams, which are 0 and 1.
        const STREAM: u64 = 2;

        Some(Self {
            spoils: Bernoulli::new(share).ok()?,
            draw: Pcg32::new(seed, STREAM),
            reply: None,
        })
    }

    /// A servo's byte as the master receives it.
    pub(super) fn byte(&mut self, servo: usize, byte: u8) -> u8 {
        let mut reply = match self.reply {
            Some(reply) if reply.servo == servo => reply,
            _ => self.begin(servo),
        };
        let received = match reply.spoil {
            Some((at, bit)) if at == reply.bytes => byte ^ bit,
            _ => byte,
        };
        reply.bytes += 1;
        self.reply = Some(reply);
        received
    }

    /// A servo has left the wire: its reply is over.
    pub(super) fn released(&mut self, servo: usize) {
        self.reply.take_if(|reply| reply.servo == servo);
    }

    fn begin(&mut self, servo: usize) -> Reply {
        let spoiled = self.spoils.sample(&mut self.draw);
        let spoil = spoiled.then(|| {
            let index = self.below(SPOILED.len());
            (SPOILED[index], 1 << self.below(8))
        });
        Reply {
            servo,
            bytes: 0,
            spoil,
        }
    }

    fn below(&mut self, end: usize) -> usize {
        Uniform::new(0, end).map_or(0, |range| range.sample(&mut self.draw))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bits turned in a reply of seven bytes.
    fn turned(disturbance: &mut Disturbance, servo: usize) -> u32 {
        let bits = (0..7)
            .map(|_| disturbance.byte(servo, 0xA5) ^ 0xA5)
            .map(u8::count_ones)
            .sum();
        disturbance.released(servo);
        bits
    }

    #[test]
    fn one_bit_of_the_share_that_was_asked_for() {
        let mut disturbance = Disturbance::new(0.2, 1).unwrap();
        let mut again = disturbance.clone();
        let mut lost = 0;
        for reply in 0..10_000 {
            let bits = turned(&mut disturbance, reply % 2);
            assert_eq!(bits, turned(&mut again, reply % 2));
            assert!(bits <= 1);
            lost += bits;
        }
        assert!((1_900..2_100).contains(&lost), "{lost}");
        assert!(Disturbance::new(1.1, 1).is_none());
    }
}
