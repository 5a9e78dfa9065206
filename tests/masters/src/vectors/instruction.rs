//! The instructions, and their words.

use std::fmt;

/// An instruction; `id` is the servo's.
#[derive(Debug)]
pub(super) enum Instruction {
    Ping(u8),
    Reboot(u8),
    Action(u8),
    ClearTurns(u8),
    /// Of all but the id.
    FactoryReset(u8),
    Read(u8, u8, u8),
    Write(u8, u8, Vec<u8>),
    RegWrite(u8, u8, Vec<u8>),
    SyncRead(u8, u8, Vec<u8>),
    FastSyncRead(u8, u8, Vec<u8>),
    /// Id and bytes of each.
    SyncWrite(u8, Vec<(u8, Vec<u8>)>),
    /// Of one servo: id, address, count.
    BulkRead(u8, u8, u8),
    /// Id, address and bytes of each.
    BulkWrite(Vec<(u8, u8, Vec<u8>)>),
}

/// Bytes in hexadecimal.
pub(super) fn hex(bytes: &[u8]) -> String {
    let bytes: Vec<String> = bytes.iter().map(|byte| format!("{byte:02X}")).collect();
    bytes.join(" ")
}

impl fmt::Display for Instruction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ping(id) => write!(f, "ping {id}"),
            Self::Reboot(id) => write!(f, "reboot {id}"),
            Self::Action(id) => write!(f, "action {id}"),
            Self::ClearTurns(id) => write!(f, "clear_turns {id}"),
            Self::FactoryReset(id) => write!(f, "factory_reset {id} 1"),
            Self::Read(id, address, count) => write!(f, "read {id} {address} {count}"),
            Self::Write(id, address, data) => write!(f, "write {id} {address} {}", hex(data)),
            Self::RegWrite(id, address, data) => {
                write!(f, "reg_write {id} {address} {}", hex(data))
            }
            Self::SyncRead(address, count, ids) => {
                write!(f, "sync_read {address} {count} {}", hex(ids))
            }
            Self::FastSyncRead(address, count, ids) => {
                write!(f, "fast_sync_read {address} {count} {}", hex(ids))
            }
            Self::SyncWrite(address, blocks) => {
                let count = blocks.first().map_or(0, |(_, data)| data.len());
                let blocks = blocks.iter().map(|(id, data)| [&[*id], &data[..]].concat());
                let blocks: Vec<u8> = blocks.flatten().collect();
                write!(f, "sync_write {address} {count} {}", hex(&blocks))
            }
            Self::BulkRead(id, address, count) => {
                write!(f, "bulk_read {}", hex(&[*id, *address, 0, *count, 0]))
            }
            Self::BulkWrite(blocks) => {
                let blocks = blocks.iter().map(|(id, address, data)| {
                    let count = u8::try_from(data.len()).unwrap_or(u8::MAX);
                    [&[*id, *address, 0, count, 0], &data[..]].concat()
                });
                write!(
                    f,
                    "bulk_write {}",
                    hex(&blocks.flatten().collect::<Vec<_>>())
                )
            }
        }
    }
}

/// Bytes that are rich in the mark FF FF FD, the same in each run.
struct Marks(u32);

impl Marks {
    fn number(&mut self, below: u32) -> u8 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        u8::try_from((self.0 >> 16) % below).unwrap_or(0)
    }

    fn byte(&mut self) -> u8 {
        match self.number(5) {
            0 | 1 => 0xFF,
            2 => 0xFD,
            3 => 0,
            _ => self.number(256),
        }
    }

    fn bytes(&mut self, count: u8) -> Vec<u8> {
        (0..count).map(|_| self.byte()).collect()
    }
}

/// Of each kind some.
pub(super) fn instructions() -> Vec<Instruction> {
    use Instruction as I;
    let marks = &mut Marks(1);
    let mut all = vec![
        I::Ping(1),
        I::Ping(252),
        I::Reboot(7),
        I::Action(3),
        I::ClearTurns(5),
        I::FactoryReset(4),
        I::Read(1, 132, 4),
        I::Read(252, 0, 147),
        I::Write(1, 100, vec![0x75, 0x03]),
        I::Write(2, 20, vec![0xFF, 0xFF, 0xFD, 0xFF]),
        I::Write(3, 20, vec![0xFF, 0xFF, 0xFF, 0xFD, 0xFD]),
        I::RegWrite(4, 65, vec![1]),
    ];
    for ids in [vec![1, 2], vec![5], (1..=12).collect()] {
        all.push(I::SyncRead(124, 10, ids.clone()));
        all.push(I::FastSyncRead(124, 10, ids));
    }
    for _ in 0..12 {
        let (id, address, count) = (marks.number(253), marks.number(255), 1 + marks.number(23));
        all.push(I::Write(id, address, marks.bytes(count)));
        all.push(I::RegWrite(id, address, marks.bytes(count)));
    }
    for _ in 0..6 {
        let blocks = [1, 2].map(|id| (id, marks.bytes(4)));
        all.push(I::SyncWrite(100, blocks.to_vec()));
        let blocks = [(1, 100), (2, 20)].map(|(id, address)| (id, address, marks.bytes(4)));
        all.push(I::BulkWrite(blocks.to_vec()));
    }
    all.extend([I::BulkRead(1, 144, 2), I::BulkRead(2, 146, 1)]);
    all
}
