//! Instructions as Protocol 1.0 packets.

use super::frame::{BROADCAST, FRAME_MAX, Frame};
use crate::{DecodeError, Instruction};
use heapless::Vec;

/// Codes of the instructions (e-Manual, "Instruction").
mod code {
    pub(super) const PING: u8 = 0x01;
    pub(super) const READ: u8 = 0x02;
    pub(super) const WRITE: u8 = 0x03;
    pub(super) const REG_WRITE: u8 = 0x04;
    pub(super) const ACTION: u8 = 0x05;
    pub(super) const FACTORY_RESET: u8 = 0x06;
    pub(super) const SYNC_WRITE: u8 = 0x83;
    pub(super) const BULK_READ: u8 = 0x92;
}

/// Encoding in Protocol 1.0. Morpheus has no encoder for any instruction: see
/// [`morpheus::Request`](crate::morpheus::Request).
/// Addresses and counts as Protocol 1.0 has them: one byte each.
fn short<const N: usize>(numbers: [u16; N]) -> Option<[u8; N]> {
    let short = numbers.map(|number| u8::try_from(number).ok());
    short
        .iter()
        .all(Option::is_some)
        .then(|| short.map(Option::unwrap_or_default))
}

impl<'a> Instruction<'a> {
    /// The bytes on the wire to the servo `id`, or to all; `None` if they are
    /// more than `N`, or if Protocol 1.0 has no such instruction.
    /// [`Instruction::SyncWrite`] goes to all whatever `id` is.
    pub fn encode<const N: usize>(&self, id: u8) -> Option<Vec<u8, N>> {
        let mut parameters: Vec<u8, FRAME_MAX> = Vec::new();
        let (id, code) = match *self {
            Self::Ping => (id, code::PING),
            Self::Read { address, count } => {
                parameters.extend(short([address, count])?);
                (id, code::READ)
            }
            Self::Write { address, data } => {
                parameters.extend(short([address])?);
                parameters.extend_from_slice(data).ok()?;
                (id, code::WRITE)
            }
            Self::RegWrite { address, data } => {
                parameters.extend(short([address])?);
                parameters.extend_from_slice(data).ok()?;
                (id, code::REG_WRITE)
            }
            Self::Action => (id, code::ACTION),
            Self::FactoryReset => (id, code::FACTORY_RESET),
            Self::SyncWrite {
                address,
                count,
                blocks,
            } => {
                parameters.extend(short([address, count])?);
                parameters.extend_from_slice(blocks).ok()?;
                (BROADCAST, code::SYNC_WRITE)
            }
            Self::SyncRead { .. } | Self::FastSyncRead { .. } | Self::Start | Self::Cycle => {
                return None;
            }
        };
        let frame = Frame {
            id,
            code,
            parameters: &parameters,
        };
        frame.encode()
    }

    /// The instruction of a packet.
    ///
    /// # Errors
    /// [`DecodeError`] if no AX-12A knows it.
    pub fn decode(frame: &Frame<'a>) -> Result<Self, DecodeError> {
        match (frame.code, frame.parameters) {
            (code::PING, []) => Ok(Self::Ping),
            (code::READ, &[address, count]) => Ok(Self::Read {
                address: address.into(),
                count: count.into(),
            }),
            (code::WRITE, [address, data @ ..]) if !data.is_empty() => Ok(Self::Write {
                address: (*address).into(),
                data,
            }),
            (code::REG_WRITE, [address, data @ ..]) if !data.is_empty() => Ok(Self::RegWrite {
                address: (*address).into(),
                data,
            }),
            (code::ACTION, []) => Ok(Self::Action),
            (code::FACTORY_RESET, []) => Ok(Self::FactoryReset),
            (code::SYNC_WRITE, [address, count, blocks @ ..])
                if *count > 0 && blocks.len() % (usize::from(*count) + 1) == 0 =>
            {
                Ok(Self::SyncWrite {
                    address: (*address).into(),
                    count: (*count).into(),
                    blocks,
                })
            }
            (code::BULK_READ, _) => Err(DecodeError::BulkRead),
            (
                code::PING
                | code::READ
                | code::WRITE
                | code::REG_WRITE
                | code::ACTION
                | code::FACTORY_RESET
                | code::SYNC_WRITE,
                _,
            ) => Err(DecodeError::Length),
            (unknown, _) => Err(DecodeError::Unknown(unknown)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Parser;
    use super::*;
    use proptest::prelude::*;

    /// From the e-Manual's examples.
    #[test]
    fn instructions_encode_as_documented() {
        let vectors: [(u8, Instruction, &[u8]); 5] = [
            (1, Instruction::Ping, &[0xFF, 0xFF, 1, 2, 1, 0xFB]),
            (
                1,
                Instruction::Read {
                    address: 36,
                    count: 8,
                },
                &[0xFF, 0xFF, 1, 4, 2, 36, 8, 0xCC],
            ),
            // Two servos, half of full duty either way.
            (
                9,
                Instruction::SyncWrite {
                    address: 32,
                    count: 2,
                    blocks: &[1, 0, 2, 2, 0, 6],
                },
                &[
                    0xFF, 0xFF, 0xFE, 0x0A, 0x83, 0x20, 2, 1, 0, 2, 2, 0, 6, 0x47,
                ],
            ),
            (0, Instruction::FactoryReset, &[0xFF, 0xFF, 0, 2, 6, 0xF7]),
            (
                BROADCAST,
                Instruction::Write {
                    address: 24,
                    data: &[0],
                },
                &[0xFF, 0xFF, 0xFE, 4, 3, 24, 0, 0xE2],
            ),
        ];
        for (id, instruction, bytes) in vectors {
            assert_eq!(
                instruction.encode::<32>(id).unwrap(),
                bytes,
                "{instruction:?}"
            );
        }
        assert_eq!(Instruction::Ping.encode::<5>(1), None);
    }

    #[test]
    fn what_is_not_for_an_ax12a_is_named() {
        let decode = |code, parameters| {
            Instruction::decode(&Frame {
                id: 1,
                code,
                parameters,
            })
        };
        assert_eq!(decode(0x92, &[0]), Err(DecodeError::BulkRead));
        assert_eq!(decode(0x42, &[]), Err(DecodeError::Unknown(0x42)));
        assert_eq!(decode(0x02, &[1]), Err(DecodeError::Length));
        assert_eq!(decode(0x83, &[30, 2, 1, 0]), Err(DecodeError::Length));
    }

    proptest! {
        #[test]
        fn every_instruction_round_trips(
            id in 0..BROADCAST,
            kind in 0..7,
            address in 0..=255_u16,
            count in 1..=4_u16,
            data in proptest::collection::vec(any::<u8>(), 1..=200),
        ) {
            let whole = data.len() / (usize::from(count) + 1) * (usize::from(count) + 1);
            let sent = match kind {
                0 => Instruction::Ping,
                1 => Instruction::Read { address, count },
                2 => Instruction::Write { address, data: &data },
                3 => Instruction::RegWrite { address, data: &data },
                4 => Instruction::Action,
                5 => Instruction::FactoryReset,
                _ => Instruction::SyncWrite { address, count, blocks: &data[..whole] },
            };
            let bytes = sent.encode::<FRAME_MAX>(id).unwrap();
            let mut parser = Parser::<FRAME_MAX>::new();
            let (last, before) = bytes.split_last().unwrap();
            for byte in before {
                prop_assert_eq!(parser.push(*byte), None);
            }
            let frame = parser.push(*last).unwrap().unwrap();
            let to = if matches!(sent, Instruction::SyncWrite { .. }) { BROADCAST } else { id };
            prop_assert_eq!(frame.id, to);
            prop_assert_eq!(Instruction::decode(&frame), Ok(sent));
        }
    }
}
