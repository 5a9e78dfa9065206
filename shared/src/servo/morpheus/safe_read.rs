//! Reading registers without deafening the other servos.
//!
//! Servos take each other's replies for requests. One whose first byte is 0x83
//! looks like SYNC_WR, and a servo that receives it is deaf for 200 bytes: a READ must
//! begin at a register that never holds 0x83. There are four:
//!
//! | from | what                  | holds | reaches    |
//! |------|-----------------------|-------|------------|
//! | 0x00 | marker                | 0xAA  | 0x00..0x0A |
//! | 0x0A | baud rate             | 0, 1, 3, 16, 34, 207 | 0x0A |
//! | 0x0C | position, high byte   | 0..=3 | 0x0C..0x11 |
//! | 0x0F | temperature, high byte| 0..=3 | 0x0F..0x11 |
//!
//! So more is read than is wanted, from the nearest of them, and the front is
//! dropped. What begins in the EEPROM never reaches the RAM: the firmware looks
//! at the first address only. The position's low byte at 0x0B thus cannot be
//! read; the position comes from [`Request::Cycle`](super::Request::Cycle).

use super::codes::command::READ;
use super::codes::register::{BEFORE_PWM as TEMPERATURE_HIGH, END, POSITION as POSITION_LOW, PWM};
use super::request::packet;
use crate::servo::{Packet, ServoId};
use core::ops::Range;

const MARKER: u8 = 0x00;
const MARKER_VALID: u8 = 0xAA;
const BAUD: u8 = 0x0A;
/// All that the firmware accepts there.
const BAUDS: [u8; 6] = [0, 1, 3, 16, 34, 207];
const POSITION_HIGH: u8 = POSITION_LOW + 1;
const PWM_HIGH: u8 = PWM + 1;
/// Largest high byte of a converter's 10 bits.
const HIGH_MAX: u8 = 3;

/// How to read some registers safely.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// First register to ask for: 0x00, 0x0A, 0x0C or 0x0F.
    address: u8,
    /// Bytes to ask for.
    count: u8,
    /// Bytes of the reply beside those wanted.
    skip: u8,
}

/// How to read the low byte of the PWM, the only one that a servo returns.
pub const PWM_LOW: Plan = Plan {
    address: TEMPERATURE_HIGH,
    count: 2,
    skip: 1,
};

/// Why registers cannot be read at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Unreadable {
    /// No bytes: the empty reply deafens as 0x83 does.
    Empty,
    /// Beyond the last register; a servo answers NOK.
    Beyond,
    /// From the EEPROM into the RAM: read each on its own.
    Across,
    /// Position first: its low byte may be 0x83. Take CYCLE.
    Position,
}

/// How to read `count` registers from `address` on.
///
/// # Errors
/// [`Unreadable`] if no safe READ has them all.
pub const fn plan(address: u8, count: u8) -> Result<Plan, Unreadable> {
    // An end beyond 255 is beyond the last register, too.
    let end = address.saturating_add(count);
    let from = match address {
        _ if count == 0 => return Err(Unreadable::Empty),
        _ if end > END => return Err(Unreadable::Beyond),
        ..POSITION_LOW if end > POSITION_LOW => return Err(Unreadable::Across),
        BAUD => BAUD,
        ..POSITION_LOW => MARKER,
        POSITION_LOW => return Err(Unreadable::Position),
        POSITION_HIGH..TEMPERATURE_HIGH => POSITION_HIGH,
        TEMPERATURE_HIGH.. => TEMPERATURE_HIGH,
    };
    Ok(Plan {
        address: from,
        count: end - from,
        skip: address - from,
    })
}

impl Plan {
    /// The READ that asks for them.
    pub fn request(&self, servo: ServoId) -> Packet {
        packet(servo.get(), &[READ, self.address, self.count])
    }

    /// Registers that are asked for, the dropped ones included.
    pub const fn asked(&self) -> Range<u8> {
        self.address..self.address + self.count
    }

    /// What was wanted of a reply's payload; `None` if it does not answer this
    /// READ, as the one byte of NOK does not.
    pub fn wanted<'a>(&self, payload: &'a [u8]) -> Option<&'a [u8]> {
        let is_expected = match (self.address, payload.first()?) {
            (MARKER, first) => *first == MARKER_VALID,
            (BAUD, first) => BAUDS.contains(first),
            (_, first) => *first <= HIGH_MAX,
        };
        let is_whole = payload.len() == usize::from(self.count);
        payload
            .get(usize::from(self.skip)..)
            .filter(|_| is_expected && is_whole)
    }

    /// Whether the PWM's high byte is among them. It reads 0 whatever the PWM
    /// is, so a PWM above 255 is not what is read.
    pub const fn has_pwm_high(&self) -> bool {
        self.address + self.count > PWM_HIGH
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every READ that the firmware would answer, and some that it would not.
    #[test]
    fn whatever_can_be_read_is_read_from_a_register_that_is_never_0x83() {
        for address in 0..=u8::MAX {
            for count in 0..=u8::MAX {
                let end = u16::from(address) + u16::from(count);
                let planned = plan(address, count);
                let expected_error = match address {
                    _ if count == 0 => Some(Unreadable::Empty),
                    _ if end > END.into() => Some(Unreadable::Beyond),
                    0..=0x0A if end > 0x0B => Some(Unreadable::Across),
                    0x0B => Some(Unreadable::Position),
                    _ => None,
                };
                assert_eq!(planned.err(), expected_error, "{address} {count}");
                let Ok(plan) = planned else { continue };
                let asked = plan.asked();
                assert!([0x00, 0x0A, 0x0C, 0x0F].contains(&asked.start), "{plan:?}");
                assert!(asked.contains(&address), "{plan:?}");
                assert_eq!(u16::from(asked.end), end);
                assert_eq!(plan.has_pwm_high(), end == 0x12);
                // The payload in which each byte but the first is its address.
                let mut payload: heapless::Vec<u8, 18> = asked.collect();
                payload[0] = match plan.address {
                    MARKER => 0xAA,
                    BAUD => 34,
                    _ => 3,
                };
                let wanted = plan.wanted(&payload).unwrap();
                assert_eq!(wanted.len(), usize::from(count));
                assert_eq!(wanted.first() == Some(&address), plan.skip > 0);
            }
        }
    }

    #[test]
    fn requests_are_as_recorded() {
        let servo = ServoId::new(1).unwrap();
        let request = |address, count| plan(address, count).unwrap().request(servo);
        assert_eq!(plan(0x10, 1), Ok(PWM_LOW));
        let whole_rom = [0xAA, 5, 1, 0xFE, 2, 0x00, 0x0B, 0xE9];
        assert_eq!(request(0x00, 11), whole_rom);
        assert_eq!(request(0x0A, 1), [0xAA, 5, 1, 0xFE, 2, 0x0A, 1, 0xE9]);
        assert_eq!(request(0x0E, 2), [0xAA, 5, 1, 0xFE, 2, 0x0C, 4, 0xE4]);
    }

    #[test]
    fn what_is_no_answer_is_not_taken_for_one() {
        let temperature = plan(0x0E, 2).unwrap();
        assert_eq!(
            temperature.wanted(&[1, 0x83, 0x2C, 1]),
            Some(&[0x2C, 1][..])
        );
        assert_eq!(temperature.wanted(&[1, 0x83, 0x2C]), None);
        assert_eq!(temperature.wanted(&[0x83, 0, 0x2C, 1]), None);
        // NOK has the length of the shortest reading.
        assert_eq!(plan(0x0F, 1).unwrap().wanted(&[0x08]), None);
        assert_eq!(plan(0x0A, 1).unwrap().wanted(&[0x08]), None);
        assert_eq!(plan(0x00, 1).unwrap().wanted(&[0x08]), None);
        assert_eq!(plan(0x0F, 1).unwrap().wanted(&[]), None);
    }
}
