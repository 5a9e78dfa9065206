//! Status packets: replies of a stock servo.

use super::frame::{BROADCAST, Frame};
use crate::Alarms;
use heapless::Vec;

/// A status packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Status<'a> {
    /// Id of the servo that answers.
    pub id: u8,
    /// Its alarms.
    pub alarms: Alarms,
    /// Contents of the registers that were read.
    pub parameters: &'a [u8],
}

impl<'a> Status<'a> {
    /// The bytes on the wire; `None` if they are more than `N`.
    pub fn encode<const N: usize>(&self) -> Option<Vec<u8, N>> {
        let frame = Frame {
            id: self.id,
            code: self.alarms.bits(),
            parameters: self.parameters,
        };
        frame.encode()
    }

    /// Decodes an intact packet; `None` if no servo would send it: from an id that
    /// no servo has, or with an error byte that has no meaning.
    pub fn decode(frame: &Frame<'a>) -> Option<Self> {
        let is_plausible = frame.id < BROADCAST && frame.code < 0x80;
        is_plausible.then_some(Self {
            id: frame.id,
            // Bit 7 has no meaning.
            alarms: Alarms::from_bits(frame.code & 0x7F),
            parameters: frame.parameters,
        })
    }

    /// The parameters as one 16-bit value, if they are two bytes.
    pub fn word(&self) -> Option<u16> {
        let bytes = self.parameters.try_into().ok()?;
        Some(u16::from_le_bytes(bytes))
    }
}

#[cfg(test)]
mod tests {
    use super::super::Parser;
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_status_round_trips(
            id in 0..BROADCAST,
            bits in 0..0x80_u8,
            parameters in proptest::collection::vec(any::<u8>(), 0..=60),
        ) {
            let sent = Status { id, alarms: Alarms::from_bits(bits), parameters: &parameters };
            let bytes = sent.encode::<66>().unwrap();
            let mut parser = Parser::<66>::new();
            let (last, before) = bytes.split_last().unwrap();
            for byte in before {
                prop_assert_eq!(parser.push(*byte), None);
            }
            let frame = parser.push(*last).unwrap().unwrap();
            prop_assert_eq!(Status::decode(&frame), Some(sent));
        }
    }

    #[test]
    fn no_servo_sends_a_broadcast_or_an_eighth_alarm() {
        let frame = |id, code| Frame {
            id,
            code,
            parameters: &[],
        };
        assert_eq!(Status::decode(&frame(BROADCAST, 0)), None);
        assert_eq!(Status::decode(&frame(1, 0x80)), None);
        let position = Frame {
            id: 1,
            code: 0,
            parameters: &[0x02, 0x01],
        };
        assert_eq!(Status::decode(&position).unwrap().word(), Some(0x0102));
    }
}
