//! Status packets: replies of a servo.

use super::frame::{Frame, ID_MAX, STATUS};
use heapless::Vec;

/// Bit of the error byte that says that [`HARDWARE_ERROR`](super::register::HARDWARE_ERROR) is set.
const ALERT: u8 = 0x80;

/// Why a servo did not carry out an instruction (e-Manual, "Error").
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StatusError {
    /// It could not.
    Failed,
    /// It does not know the instruction, or ACTION came without a registered write.
    Instruction,
    /// It received a wrong CRC.
    Crc,
    /// A value is outside of the register's range.
    DataRange,
    /// Fewer bytes than the register has.
    DataLength,
    /// A value is outside of a limit that another register sets.
    DataLimit,
    /// The register cannot be read or written, or is EEPROM, and torque is on.
    Access,
    /// A number without meaning.
    Unknown(u8),
}

/// A status packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Status<'a> {
    /// Id of the servo that answers.
    pub id: u8,
    /// A hardware error is latched: of heat, supply, load.
    pub is_alert: bool,
    /// Why it did not carry out the instruction.
    pub error: Option<StatusError>,
    /// Contents of the registers that were read.
    pub parameters: &'a [u8],
}

/// Alert and error of an error byte.
pub(super) const fn decode_error(byte: u8) -> (bool, Option<StatusError>) {
    let error = match byte & !ALERT {
        0 => None,
        1 => Some(StatusError::Failed),
        2 => Some(StatusError::Instruction),
        3 => Some(StatusError::Crc),
        4 => Some(StatusError::DataRange),
        5 => Some(StatusError::DataLength),
        6 => Some(StatusError::DataLimit),
        7 => Some(StatusError::Access),
        other => Some(StatusError::Unknown(other)),
    };
    (byte & ALERT != 0, error)
}

/// The error byte of an alert and an error.
pub(super) const fn encode_error(is_alert: bool, error: Option<StatusError>) -> u8 {
    let number = match error {
        None => 0,
        Some(StatusError::Failed) => 1,
        Some(StatusError::Instruction) => 2,
        Some(StatusError::Crc) => 3,
        Some(StatusError::DataRange) => 4,
        Some(StatusError::DataLength) => 5,
        Some(StatusError::DataLimit) => 6,
        Some(StatusError::Access) => 7,
        Some(StatusError::Unknown(number)) => number & !ALERT,
    };
    if is_alert { number | ALERT } else { number }
}

impl<'a> Status<'a> {
    /// Decodes an intact packet; `None` if no servo would send it. A fast status packet is a
    /// [`FastStatus`](super::FastStatus) instead.
    pub fn decode(frame: &Frame<'a>) -> Option<Self> {
        let (error, parameters) = frame.parameters.split_first()?;
        let (is_alert, error) = decode_error(*error);
        (frame.code == STATUS && frame.id <= ID_MAX).then_some(Self {
            id: frame.id,
            is_alert,
            error,
            parameters,
        })
    }

    /// Whether the instruction was carried out, and no hardware error is latched.
    pub fn is_sound(&self) -> bool {
        self.error.is_none() && !self.is_alert
    }

    /// The bytes on the wire; `None` if they are more than `N`.
    pub fn encode<const N: usize>(&self) -> Option<Vec<u8, N>> {
        let mut parameters: Vec<u8, N> = Vec::new();
        parameters
            .push(encode_error(self.is_alert, self.error))
            .ok()?;
        parameters.extend_from_slice(self.parameters).ok()?;
        let frame = Frame {
            id: self.id,
            code: STATUS,
            parameters: &parameters,
        };
        frame.encode()
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
            id in 0..=ID_MAX,
            byte in any::<u8>(),
            parameters in proptest::collection::vec(any::<u8>(), 0..40),
        ) {
            let (is_alert, error) = decode_error(byte);
            prop_assert_eq!(encode_error(is_alert, error), byte);
            let sent = Status { id, is_alert, error, parameters: &parameters };
            let bytes = sent.encode::<80>().unwrap();
            let mut parser = Parser::<80>::new();
            let (last, before) = bytes.split_last().unwrap();
            for byte in before {
                prop_assert_eq!(parser.push(*byte), None);
            }
            let frame = parser.push(*last).unwrap().unwrap();
            prop_assert_eq!(Status::decode(&frame), Some(sent));
        }
    }

    #[test]
    fn no_instruction_is_a_status() {
        let frame = |id, code, parameters| Frame {
            id,
            code,
            parameters,
        };
        assert_eq!(Status::decode(&frame(1, 1, &[])), None);
        assert_eq!(Status::decode(&frame(1, STATUS, &[])), None);
        assert_eq!(Status::decode(&frame(254, STATUS, &[0, 1])), None);
        let alert = Status::decode(&frame(1, STATUS, &[0x80])).unwrap();
        assert!(alert.error.is_none() && !alert.is_sound());
    }
}
