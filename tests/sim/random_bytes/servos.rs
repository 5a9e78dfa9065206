//! Two servos at the other end of a scripted line.

use armbridge_tests::random::Random;

use super::line::{Heard, back_to_back, position, reply};

/// Two servos that answer requests, with or without errors.
pub(super) struct Servos {
    /// Where they are.
    pub(super) counts: [u64; 2],
    /// Answers are lost or damaged once in this many; there are none at 1.
    pub(super) fail_once_in: u64,
}

impl Servos {
    /// Answers the request that was sent last.
    pub(super) fn answer(&mut self, sent: &[u8], random: &mut Random) -> Vec<(u64, Heard)> {
        if self.fail_once_in == 1 {
            return Vec::new();
        }
        let mut packets = match sent {
            [.., 0xAA, 3, id @ 1..=2, 0xFE, 1, _] => vec![reply(*id, &[1])],
            // Temperature, high byte, and the low byte of PWM 1000.
            [.., 0xAA, 5, id @ 1..=2, 0xFE, 2, 0x0F, 2, _] => vec![reply(*id, &[1, 0xE8])],
            [.., 0xAA, 3, 0xFF, 0xFE, 6, _] => vec![reply(1, &[1]), reply(2, &[1])],
            [.., 0xAA, 3, 0xFF, 0xFE, 7, _] => {
                // At rest about upright mostly, else anywhere: an arm that is shaken.
                for counts in &mut self.counts {
                    *counts = match random.below(2_000) {
                        0 => random.below(1024),
                        1..20 => 512,
                        _ => (*counts + random.below(3) + 1023) % 1024,
                    };
                }
                let [a, b] = self.counts.map(|counts| {
                    let noise = random.below(9) + 1020;
                    let is_glitch = random.once_in(100);
                    let read = if is_glitch {
                        random.below(1024)
                    } else {
                        counts + noise
                    };
                    (read % 1024) as u16
                });
                vec![position(1, a), position(2, b)]
            }
            _ => return Vec::new(),
        };
        if random.once_in(self.fail_once_in) {
            let at = random.below(packets.len() as u64) as usize;
            random.damage(&mut packets[at]);
        }
        back_to_back(60, &packets.concat())
    }
}
