//! A second master on the servo bus, which knows nothing of the board: it drives, asks and
//! sends garbage, one packet at a time.

use armbridge_board::bridge::SERVO_IDS;
use armbridge_servo::Firmware;

use super::draw::Random;
use crate::faults::port_client::Method;

/// Most bytes of garbage.
const GARBAGE_BYTES: u64 = 20;

/// Its packets.
#[derive(Clone, Debug)]
pub(super) struct SecondMaster {
    draw: Random,
    method: Method,
    between_us: f64,
    next_us: u64,
    until_us: u64,
}

impl SecondMaster {
    /// A master of servos of this firmware that sends every `between_ms` on average.
    pub(super) fn new(
        servos: Firmware,
        between_ms: f64,
        during_us: &std::ops::Range<u64>,
        seed: u64,
    ) -> Self {
        Self {
            draw: Random::new(seed),
            method: match servos {
                Firmware::Morpheus => Method::Pwm,
                Firmware::Stock => Method::Speeds,
                Firmware::XSeries => Method::Duties,
            },
            between_us: between_ms * 1e3,
            next_us: during_us.start,
            until_us: during_us.end,
        }
    }

    /// Time of its next packet, in µs.
    pub(super) fn next_us(&self) -> u64 {
        if self.next_us < self.until_us {
            self.next_us
        } else {
            u64::MAX
        }
    }

    /// Its packet, if one is due.
    pub(super) fn take(&mut self, now_us: u64) -> Option<Vec<u8>> {
        if now_us < self.next_us() {
            return None;
        }
        let wait_us = self.draw.uniform(0.1, 2.0) * self.between_us;
        self.next_us = now_us + (wait_us as u64).max(1);
        Some(match self.draw.below(4) {
            0 => self.method.packets(),
            1 => self.method.question(),
            2 => self.method.packets().split_off(SERVO_IDS.len()),
            _ => {
                let count = 1 + self.draw.below(GARBAGE_BYTES);
                (0..count).map(|_| self.draw.below(256) as u8).collect()
            }
        })
    }
}
