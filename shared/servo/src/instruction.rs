//! Instructions that a master can give, in any of the protocols.

/// A request to one servo or to all, without header and checksum.
///
/// The write instructions carry the bytes of consecutive registers. Only Morpheus has
/// [`Start`](Self::Start) and [`Cycle`](Self::Cycle), and only Protocol 2.0 the reads of several
/// servos; Morpheus has no [`RegWrite`](Self::RegWrite) and [`Action`](Self::Action).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Instruction<'a> {
    /// Presence test. Answered by a stock servo whatever its status return level.
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
    /// Executes the registered writes.
    Action,
    /// Restores the factory EEPROM: id 1, 1 Mbaud.
    FactoryReset,
    /// Writes the same registers of several servos. Always to all, never answered.
    SyncWrite {
        /// First register, in every servo.
        address: u16,
        /// Bytes per servo.
        count: u16,
        /// Id and bytes, servo by servo: see [`SyncBlocks`].
        blocks: &'a [u8],
    },
    /// Protocol 2.0: reads the same registers of several servos, which answer one after the
    /// other.
    SyncRead {
        /// Bytes per servo.
        count: u16,
        /// The servos.
        ids: &'a [u8],
    },
    /// Protocol 2.0: the same, with one packet for an answer.
    FastSyncRead {
        /// Bytes per servo.
        count: u16,
        /// The servos.
        ids: &'a [u8],
    },
    /// Morpheus: every servo announces itself in turn, which forms the position
    /// chain.
    Start,
    /// Morpheus: every servo of the chain sends its position.
    Cycle,
}

/// Reason why an intact packet is no instruction to a servo of its protocol.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DecodeError {
    /// An instruction of the MX series, which no AX-12A knows.
    BulkRead,
    /// A code without meaning.
    Unknown(u8),
    /// Parameters that do not fit the instruction.
    Length,
    /// Parameters with stuffed bytes, which are not decoded in place.
    Stuffing,
}

/// Blocks of an [`Instruction::SyncWrite`], one for each servo.
#[derive(Clone, Debug)]
pub struct SyncBlocks<'a>(core::slice::ChunksExact<'a, u8>);

impl<'a> SyncBlocks<'a> {
    /// Splits `blocks` into those of the servos, `count` bytes each.
    pub fn new(count: u16, blocks: &'a [u8]) -> Self {
        Self(blocks.chunks_exact(usize::from(count) + 1))
    }
}

impl<'a> Iterator for SyncBlocks<'a> {
    /// Id and bytes.
    type Item = (u8, &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        let (id, data) = self.0.next()?.split_first()?;
        Some((*id, data))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_taken_apart() {
        let mut blocks = SyncBlocks::new(2, &[1, 0, 2, 9, 0, 6]);
        assert_eq!(blocks.next(), Some((1, &[0, 2][..])));
        assert_eq!(blocks.next(), Some((9, &[0, 6][..])));
        assert_eq!(blocks.next(), None);
    }
}
