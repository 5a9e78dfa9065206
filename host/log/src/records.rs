//! Records of an MCAP file, one by one, up to the first damage.
//!
//! The library's readers refuse a damaged file. The log of a killed program
//! ends in the middle of a record, and is intact before it.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use mcap::MAGIC;

/// Size of opcode and length.
const HEADER: usize = 1 + 8;

/// Longest record that is read into memory. The recorder's have some MiB; a length
/// beyond this is damage.
const LENGTH_MAX: u64 = 1 << 30;

/// Reader of the records.
#[derive(Debug)]
pub(super) struct Records {
    file: BufReader<File>,
    len: u64,
    at: u64,
    /// Unread bytes of the present record.
    left: u64,
}

/// Next item of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Next {
    /// A record with this opcode.
    Record(u8),
    /// The file ends, between two records.
    End,
    /// The file ends in the middle of a record with this opcode.
    Cut(Option<u8>),
    /// No record begins at this byte.
    Garbage(u64),
}

impl Records {
    /// Opens a file; `None` if it is not MCAP.
    pub(super) fn open(path: &Path) -> io::Result<Option<Self>> {
        let file = File::open(path)?;
        let len = file.metadata()?.len();
        let mut file = BufReader::with_capacity(1 << 16, file);
        let mut magic = [0; MAGIC.len()];
        match file.read_exact(&mut magic) {
            Ok(()) if magic == MAGIC => Ok(Some(Self {
                file,
                len,
                at: MAGIC.len() as u64,
                left: 0,
            })),
            Ok(()) => Ok(None),
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Advances to the next record, skipping the rest of the present one.
    pub(super) fn next(&mut self) -> io::Result<Next> {
        if self.left > 0 {
            self.file.seek_relative(self.left as i64)?;
            self.at += self.left;
            self.left = 0;
        }
        let rest = self.len.saturating_sub(self.at);
        if rest == 0 {
            return Ok(Next::End);
        }
        // The magic at the end is not a record.
        if rest == MAGIC.len() as u64 {
            return Ok(Next::End);
        }
        if rest < HEADER as u64 {
            return Ok(Next::Cut(None));
        }
        let mut header = [0; HEADER];
        self.file.read_exact(&mut header)?;
        let [opcode, len @ ..] = header;
        let len = u64::from_le_bytes(len);
        let start = self.at;
        self.at += HEADER as u64;
        if opcode == 0 || len > LENGTH_MAX {
            return Ok(Next::Garbage(start));
        }
        if len > rest - HEADER as u64 {
            return Ok(Next::Cut(Some(opcode)));
        }
        self.left = len;
        Ok(Next::Record(opcode))
    }

    /// Reads the present record.
    pub(super) fn read(&mut self, into: &mut Vec<u8>) -> io::Result<()> {
        into.clear();
        into.resize(self.left as usize, 0);
        self.file.read_exact(into)?;
        self.at += self.left;
        self.left = 0;
        Ok(())
    }

    /// Returns to the first record.
    pub(super) fn rewind(&mut self) -> io::Result<()> {
        self.at = MAGIC.len() as u64;
        self.left = 0;
        self.file.seek(SeekFrom::Start(self.at))?;
        Ok(())
    }
}

/// The first record in memory: opcode, body, and remaining bytes.
pub(super) fn split(bytes: &[u8]) -> Option<(u8, &[u8], &[u8])> {
    let (opcode, rest) = bytes.split_first()?;
    let (len, rest) = rest.split_first_chunk()?;
    let (body, rest) = rest.split_at_checked(usize::try_from(u64::from_le_bytes(*len)).ok()?)?;
    Some((*opcode, body, rest))
}
