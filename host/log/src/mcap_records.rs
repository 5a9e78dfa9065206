//! Records of an MCAP file, one by one, up to the first damage.
//!
//! The library's readers refuse a damaged file. The log of a killed program
//! ends in the middle of a record, and is intact before it. No length in the file is believed
//! before it is compared with the bytes that are there and with [`limits`](super::limits).

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use mcap::MAGIC;
use mcap::records::{Record, op};

use super::limits::RECORD_BYTES;

/// Size of opcode and length.
const HEADER: usize = 1 + 8;

/// Reader of the records.
#[derive(Debug)]
pub(super) struct Records {
    file: BufReader<File>,
    len: u64,
    at: u64,
    /// Unread bytes of the present record.
    left: u64,
}

/// Reason for which a record is not read into memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TooLong {
    /// The byte of the file at which its contents begin.
    pub(super) at: u64,
    /// Length of its contents.
    pub(super) len: u64,
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
        Self::open_for_scan(path, 1 << 16)
    }

    /// The same, with so many bytes read at once: few, where most records are skipped.
    pub(super) fn open_for_scan(path: &Path, at_once: usize) -> io::Result<Option<Self>> {
        let file = File::open(path)?;
        let len = file.metadata()?.len();
        let mut file = BufReader::with_capacity(at_once, file);
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
        let is_whole = len <= rest - HEADER as u64;
        if opcode == 0 || (!is_whole && len > RECORD_BYTES) {
            return Ok(Next::Garbage(start));
        }
        if !is_whole {
            return Ok(Next::Cut(Some(opcode)));
        }
        self.left = len;
        Ok(Next::Record(opcode))
    }

    /// Reads the present record, unless it is longer than `most` bytes.
    pub(super) fn read(
        &mut self,
        most: u64,
        into: &mut Vec<u8>,
    ) -> io::Result<Result<(), TooLong>> {
        into.clear();
        if self.left > most {
            let (at, len) = (self.at, self.left);
            return Ok(Err(TooLong { at, len }));
        }
        into.resize(self.left as usize, 0);
        self.file.read_exact(into)?;
        self.at += self.left;
        self.left = 0;
        Ok(Ok(()))
    }

    /// Appends at most the first `most` unread bytes of the present record.
    pub(super) fn read_begin(&mut self, most: usize, into: &mut Vec<u8>) -> io::Result<()> {
        let count = self.left.min(most as u64);
        let from = into.len();
        into.resize(from + count as usize, 0);
        self.file
            .read_exact(into.get_mut(from..).unwrap_or_default())?;
        self.at += count;
        self.left -= count;
        Ok(())
    }

    /// Appends the unread bytes of the present record; `false` if they are more than `most`.
    pub(super) fn read_rest(&mut self, most: u64, into: &mut Vec<u8>) -> io::Result<bool> {
        let is_read = self.left <= most;
        if is_read {
            self.read_begin(self.left as usize, into)?;
        }
        Ok(is_read)
    }

    /// The byte of the file that is read next.
    pub(super) fn at(&self) -> u64 {
        self.at
    }

    /// Returns to the first record.
    pub(super) fn rewind(&mut self) -> io::Result<()> {
        self.go_to(MAGIC.len() as u64)
    }

    /// Goes to this byte of the file, at which a record begins.
    pub(super) fn go_to(&mut self, at: u64) -> io::Result<()> {
        self.at = at;
        self.left = 0;
        self.file.seek(SeekFrom::Start(at))?;
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

/// Parses a record; `None` if it is damaged.
///
/// The library reserves memory for a string of any length, up to 4 GiB, before it reads it, and
/// panics on an attachment without room for its checksum. So both are checked before.
pub(super) fn parse(opcode: u8, body: &[u8]) -> Option<Record<'_>> {
    check_strings(opcode, body)?;
    mcap::parse_record(opcode, body).ok()
}

/// `Some` if the strings of a record end within it.
fn check_strings(opcode: u8, body: &[u8]) -> Option<()> {
    match opcode {
        op::CHUNK => after_string(body.get(8 + 8 + 8 + 4..)?).map(drop),
        op::CHANNEL => check_map(after_string(after_string(body.get(2 + 2..)?)?)?),
        op::METADATA => check_map(after_string(body)?),
        op::ATTACHMENT => {
            let rest = after_string(after_string(body.get(8 + 8..)?)?)?;
            rest.get(..8 + 4).map(drop)
        }
        op::MESSAGE | op::STATISTICS => Some(()),
        // Not read here.
        _ => None,
    }
}

fn check_map(bytes: &[u8]) -> Option<()> {
    let (len, rest) = bytes.split_first_chunk()?;
    let mut pairs = rest.get(..u32::from_le_bytes(*len) as usize)?;
    while !pairs.is_empty() {
        pairs = after_string(after_string(pairs)?)?;
    }
    Some(())
}

fn after_string(bytes: &[u8]) -> Option<&[u8]> {
    let (len, rest) = bytes.split_first_chunk()?;
    rest.get(u32::from_le_bytes(*len) as usize..)
}

/// The string that a record begins with, such as the name of metadata.
pub(super) fn first_string(body: &[u8]) -> Option<&str> {
    let (len, rest) = body.split_first_chunk()?;
    std::str::from_utf8(rest.get(..u32::from_le_bytes(*len) as usize)?).ok()
}
