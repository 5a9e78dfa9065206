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
//! So a READ begins at the nearest of them before the requested registers, and the
//! bytes in front are dropped. A READ that begins in the EEPROM never reaches the RAM:
//! the firmware checks the first address only. The position's low byte at 0x0B thus cannot be
//! read; the position comes from [`Request::Cycle`](super::Request::Cycle).
//!
//! # Example
//!
//! The temperature is in the registers 0x0E and 0x0F, so its READ begins two before them:
//!
//! ```
//! use armbridge_servo::ServoId;
//! use armbridge_servo::morpheus::safe_read::{PlanError, plan};
//!
//! let temperature = plan(0x0E, 2).unwrap();
//! assert_eq!(temperature.range(), 0x0C..0x10);
//! let servo = ServoId::new(1).unwrap();
//! assert_eq!(temperature.request(servo), [0xAA, 5, 1, 0xFE, 2, 0x0C, 4, 0xE4]);
//! // Of the reply's four bytes the last two are the temperature.
//! assert_eq!(temperature.extract(&[1, 0xF4, 0x2C, 1]), Some(&[0x2C, 1][..]));
//!
//! assert_eq!(plan(0x0B, 2), Err(PlanError::Position));
//! ```

use super::codes::command::READ;
use super::codes::register::{BEFORE_PWM as TEMPERATURE_HIGH, END, POSITION as POSITION_LOW, PWM};
use super::request::packet;
use crate::{Packet, ServoId};
use core::ops::Range;

const MARKER: u8 = 0x00;
const MARKER_VALID: u8 = 0xAA;
const BAUD: u8 = 0x0A;
/// Values of [`BAUD`] that the firmware accepts.
const BAUDS: [u8; 6] = [0, 1, 3, 16, 34, 207];
const POSITION_HIGH: u8 = POSITION_LOW + 1;
const PWM_HIGH: u8 = PWM + 1;
/// Largest high byte of a converter's 10 bits.
const HIGH_MAX: u8 = 3;

/// READ of some registers that begins at a safe one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// First register of the READ: 0x00, 0x0A, 0x0C or 0x0F.
    address: u8,
    /// Bytes of the READ.
    count: u8,
    /// Leading bytes of the reply that are dropped.
    skip: u8,
}

/// READ of the low byte of the PWM, the only one that a servo returns.
pub const PWM_LOW: Plan = Plan {
    address: TEMPERATURE_HIGH,
    count: 2,
    skip: 1,
};

/// Reason why no single safe READ has all the registers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PlanError {
    /// No bytes: the empty reply deafens as 0x83 does.
    Empty,
    /// Beyond the last register; a servo answers NOK.
    BeyondEnd,
    /// From the EEPROM into the RAM: read each on its own.
    CrossesMemories,
    /// Position first: its low byte may be 0x83. CYCLE returns the position.
    Position,
}

/// Plans the READ of `count` registers from `address` on.
///
/// # Errors
/// [`PlanError`] if no safe READ has them all.
pub const fn plan(address: u8, count: u8) -> Result<Plan, PlanError> {
    // An end beyond 255 is beyond the last register, too.
    let end = address.saturating_add(count);
    let from = match address {
        _ if count == 0 => return Err(PlanError::Empty),
        _ if end > END => return Err(PlanError::BeyondEnd),
        ..POSITION_LOW if end > POSITION_LOW => return Err(PlanError::CrossesMemories),
        BAUD => BAUD,
        ..POSITION_LOW => MARKER,
        POSITION_LOW => return Err(PlanError::Position),
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
    /// The READ packet.
    pub fn request(&self, servo: ServoId) -> Packet {
        packet(servo.get(), &[READ, self.address, self.count])
    }

    /// Registers of the READ, the dropped ones included.
    pub const fn range(&self) -> Range<u8> {
        self.address..self.address + self.count
    }

    /// Extracts the requested registers from a reply's payload; `None` if it does not
    /// answer this READ, as the one byte of NOK does not.
    pub fn extract<'a>(&self, payload: &'a [u8]) -> Option<&'a [u8]> {
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

    /// Whether the READ includes the PWM's high byte. It reads 0 whatever the PWM
    /// is, so a PWM above 255 is read wrong.
    pub const fn has_pwm_high(&self) -> bool {
        self.address + self.count > PWM_HIGH
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Plans every READ, answered by the firmware or not.
    #[test]
    fn every_read_begins_at_a_register_that_is_never_0x83() {
        for address in 0..=u8::MAX {
            for count in 0..=u8::MAX {
                let end = u16::from(address) + u16::from(count);
                let planned = plan(address, count);
                let expected_error = match address {
                    _ if count == 0 => Some(PlanError::Empty),
                    _ if end > END.into() => Some(PlanError::BeyondEnd),
                    0..=0x0A if end > 0x0B => Some(PlanError::CrossesMemories),
                    0x0B => Some(PlanError::Position),
                    _ => None,
                };
                assert_eq!(planned.err(), expected_error, "{address} {count}");
                let Ok(plan) = planned else { continue };
                let range = plan.range();
                assert!([0x00, 0x0A, 0x0C, 0x0F].contains(&range.start), "{plan:?}");
                assert!(range.contains(&address), "{plan:?}");
                assert_eq!(u16::from(range.end), end);
                assert_eq!(plan.has_pwm_high(), end == 0x12);
                // The payload in which each byte but the first is its address.
                let mut payload: heapless::Vec<u8, 18> = range.collect();
                payload[0] = match plan.address {
                    MARKER => 0xAA,
                    BAUD => 34,
                    _ => 3,
                };
                let contents = plan.extract(&payload).unwrap();
                assert_eq!(contents.len(), usize::from(count));
                assert_eq!(contents.first() == Some(&address), plan.skip > 0);
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
    fn payloads_of_other_replies_are_rejected() {
        let temperature = plan(0x0E, 2).unwrap();
        assert_eq!(
            temperature.extract(&[1, 0x83, 0x2C, 1]),
            Some(&[0x2C, 1][..])
        );
        assert_eq!(temperature.extract(&[1, 0x83, 0x2C]), None);
        assert_eq!(temperature.extract(&[0x83, 0, 0x2C, 1]), None);
        // NOK has the length of the shortest reading.
        assert_eq!(plan(0x0F, 1).unwrap().extract(&[0x08]), None);
        assert_eq!(plan(0x0A, 1).unwrap().extract(&[0x08]), None);
        assert_eq!(plan(0x00, 1).unwrap().extract(&[0x08]), None);
        assert_eq!(plan(0x0F, 1).unwrap().extract(&[]), None);
    }
}
