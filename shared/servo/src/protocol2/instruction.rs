//! Instructions: the requests of a master.

use super::frame::{BROADCAST, Frame};
use heapless::Vec;

/// Codes of the instructions (e-Manual, "Instruction").
mod code {
    pub(super) const PING: u8 = 0x01;
    pub(super) const READ: u8 = 0x02;
    pub(super) const WRITE: u8 = 0x03;
    pub(super) const REG_WRITE: u8 = 0x04;
    pub(super) const ACTION: u8 = 0x05;
    pub(super) const FACTORY_RESET: u8 = 0x06;
    pub(super) const REBOOT: u8 = 0x08;
    pub(super) const CLEAR: u8 = 0x10;
    pub(super) const SYNC_READ: u8 = 0x82;
    pub(super) const SYNC_WRITE: u8 = 0x83;
    pub(super) const FAST_SYNC_READ: u8 = 0x8A;
    pub(super) const BULK_READ: u8 = 0x92;
    pub(super) const BULK_WRITE: u8 = 0x93;
    pub(super) const FAST_BULK_READ: u8 = 0x9A;
}

/// Parameters of CLEAR that reset the turns of a position (e-Manual, "Clear").
const CLEAR_TURNS: [u8; 5] = [0x01, 0x44, 0x58, 0x4C, 0x22];

/// Registers of one servo, in a [`Instruction::BulkRead`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BulkItem {
    /// Id of the servo.
    pub id: u8,
    /// First register.
    pub address: u16,
    /// Number of bytes.
    pub count: u16,
}

/// A request to one servo or to all, without header, stuffing and CRC.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Instruction<'a> {
    /// Presence test, answered with model number and firmware version; to all, by each in the order
    /// of the ids.
    Ping,
    /// Reads registers.
    Read {
        /// First register.
        address: u16,
        /// Number of bytes.
        count: u16,
    },
    /// Writes registers.
    Write {
        /// First register.
        address: u16,
        /// New contents.
        data: &'a [u8],
    },
    /// Writes registers when [`Instruction::Action`] comes.
    RegWrite {
        /// First register.
        address: u16,
        /// New contents.
        data: &'a [u8],
    },
    /// Executes the registered write.
    Action,
    /// Restores the factory EEPROM: 0xFF all, 0x01 all but the id, 0x02 all but id and baud rate.
    FactoryReset(u8),
    /// Restarts the servo, which clears its hardware errors; torque is off.
    Reboot,
    /// Resets the turns of the position, of a servo at rest.
    ClearTurns,
    /// Reads the same registers of several servos, which answer one after the other.
    SyncRead {
        /// First register.
        address: u16,
        /// Number of bytes.
        count: u16,
        /// The servos.
        ids: &'a [u8],
    },
    /// The same with one joint answer, a [`FastStatus`](super::FastStatus).
    FastSyncRead {
        /// First register.
        address: u16,
        /// Number of bytes.
        count: u16,
        /// The servos.
        ids: &'a [u8],
    },
    /// Writes the same registers of several servos; never answered.
    SyncWrite {
        /// First register.
        address: u16,
        /// Bytes per servo.
        count: u16,
        /// Id and bytes, servo by servo.
        blocks: &'a [u8],
    },
    /// Reads registers of several servos, of each its own: encoded [`BulkItem`]s of five bytes.
    BulkRead(&'a [u8]),
    /// The same with one joint answer, a fast status packet with parts of different lengths.
    FastBulkRead(&'a [u8]),
    /// Writes registers of several servos, of each its own: id, address, count and bytes, servo by
    /// servo; never answered.
    BulkWrite(&'a [u8]),
}

/// Reason why an intact packet is no instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InstructionError {
    /// A code without meaning.
    Unknown(u8),
    /// Parameters that do not fit the instruction.
    Length,
}

impl BulkItem {
    /// Its bytes in the packet.
    pub fn encode(self) -> [u8; 5] {
        let ([a, b], [c, d]) = (self.address.to_le_bytes(), self.count.to_le_bytes());
        [self.id, a, b, c, d]
    }

    /// The items of a [`Instruction::BulkRead`].
    pub fn decode_all(bytes: &[u8]) -> impl Iterator<Item = Self> {
        let items = bytes.chunks_exact(5);
        items.filter_map(|item| {
            let [id, a, b, c, d] = *item else { return None };
            Some(Self {
                id,
                address: u16::from_le_bytes([a, b]),
                count: u16::from_le_bytes([c, d]),
            })
        })
    }
}

/// Two numbers and the bytes after them.
fn two(parameters: &[u8]) -> Result<(u16, u16, &[u8]), InstructionError> {
    match parameters {
        [a, b, c, d, rest @ ..] => {
            let (first, second) = (u16::from_le_bytes([*a, *b]), u16::from_le_bytes([*c, *d]));
            Ok((first, second, rest))
        }
        _ => Err(InstructionError::Length),
    }
}

/// An address and the bytes after it.
fn write(parameters: &[u8]) -> Result<(u16, &[u8]), InstructionError> {
    match parameters {
        [a, b, data @ ..] if !data.is_empty() => Ok((u16::from_le_bytes([*a, *b]), data)),
        _ => Err(InstructionError::Length),
    }
}

impl<'a> Instruction<'a> {
    /// The bytes on the wire to the servo `id`, or to all; `None` if they are more than `N`.
    /// Instructions to several servos go to all whatever `id` is.
    pub fn encode<const N: usize>(&self, id: u8) -> Option<Vec<u8, N>> {
        let (code, numbers, bytes): (u8, &[u16], &[u8]) = match *self {
            Self::Ping => (code::PING, &[], &[]),
            Self::Read { address, count } => (code::READ, &[address, count], &[]),
            Self::Write { address, data } => (code::WRITE, &[address], data),
            Self::RegWrite { address, data } => (code::REG_WRITE, &[address], data),
            Self::Action => (code::ACTION, &[], &[]),
            Self::FactoryReset(what) => (code::FACTORY_RESET, &[], &[what]),
            Self::Reboot => (code::REBOOT, &[], &[]),
            Self::ClearTurns => (code::CLEAR, &[], &CLEAR_TURNS),
            Self::SyncRead {
                address,
                count,
                ids,
            } => (code::SYNC_READ, &[address, count], ids),
            Self::FastSyncRead {
                address,
                count,
                ids,
            } => (code::FAST_SYNC_READ, &[address, count], ids),
            Self::SyncWrite {
                address,
                count,
                blocks,
            } => (code::SYNC_WRITE, &[address, count], blocks),
            Self::BulkRead(items) => (code::BULK_READ, &[], items),
            Self::FastBulkRead(items) => (code::FAST_BULK_READ, &[], items),
            Self::BulkWrite(items) => (code::BULK_WRITE, &[], items),
        };
        let mut parameters: Vec<u8, N> = Vec::new();
        for number in numbers {
            parameters.extend_from_slice(&number.to_le_bytes()).ok()?;
        }
        parameters.extend_from_slice(bytes).ok()?;
        let frame = Frame {
            id: if code >= code::SYNC_READ {
                BROADCAST
            } else {
                id
            },
            code,
            parameters: &parameters,
        };
        frame.encode()
    }

    /// Decodes an intact packet.
    ///
    /// # Errors
    /// [`InstructionError`] if no servo knows it.
    pub fn decode(frame: &Frame<'a>) -> Result<Self, InstructionError> {
        let parameters = frame.parameters;
        let alone = |instruction: Self| match parameters {
            [] => Ok(instruction),
            _ => Err(InstructionError::Length),
        };
        match frame.code {
            code::PING => alone(Self::Ping),
            code::READ => match two(parameters)? {
                (address, count, []) => Ok(Self::Read { address, count }),
                _ => Err(InstructionError::Length),
            },
            code::WRITE => write(parameters).map(|(address, data)| Self::Write { address, data }),
            code::REG_WRITE => {
                write(parameters).map(|(address, data)| Self::RegWrite { address, data })
            }
            code::ACTION => alone(Self::Action),
            code::FACTORY_RESET => match *parameters {
                [what] => Ok(Self::FactoryReset(what)),
                _ => Err(InstructionError::Length),
            },
            code::REBOOT => alone(Self::Reboot),
            code::CLEAR if *parameters == CLEAR_TURNS => Ok(Self::ClearTurns),
            code::SYNC_READ => two(parameters).map(|(address, count, ids)| Self::SyncRead {
                address,
                count,
                ids,
            }),
            code::FAST_SYNC_READ => {
                two(parameters).map(|(address, count, ids)| Self::FastSyncRead {
                    address,
                    count,
                    ids,
                })
            }
            code::SYNC_WRITE => match two(parameters)? {
                (address, count, blocks) if blocks.len() % (usize::from(count) + 1) == 0 => {
                    Ok(Self::SyncWrite {
                        address,
                        count,
                        blocks,
                    })
                }
                _ => Err(InstructionError::Length),
            },
            code::BULK_READ if parameters.len().is_multiple_of(5) => Ok(Self::BulkRead(parameters)),
            code::FAST_BULK_READ if parameters.len().is_multiple_of(5) => {
                Ok(Self::FastBulkRead(parameters))
            }
            code::CLEAR | code::BULK_READ | code::FAST_BULK_READ => Err(InstructionError::Length),
            code::BULK_WRITE => Ok(Self::BulkWrite(parameters)),
            unknown => Err(InstructionError::Unknown(unknown)),
        }
    }
}

#[cfg(test)]
mod tests;
