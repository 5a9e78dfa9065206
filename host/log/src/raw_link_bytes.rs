//! The bytes of a link as they travelled, so that nothing is lost to whoever decoded
//! them.
//!
//! In the log they are attachments `link-000001.bin`, `link-000002.bin`..., one each
//! half second, of media type [`MEDIA_TYPE`]. Each is pieces, one after the other:
//!
//! ```text
//! kind u8 | host_ns u64 | length u32 | bytes
//! ```
//!
//! little endian. Kind 0 is from the board, 1 is to the board, 2 says that the
//! connection broke and has no bytes. A frame may begin in one piece, or in one
//! attachment, and end in another. [`Again`] hears them once more.

use std::collections::VecDeque;
use std::io;
use std::path::Path;

use armbridge_client::event::{Direction, Event, EventKind, LinkDecoder};
use mcap::records::{Record, op};

use super::records::{Next, Records};

/// What the attachments are.
pub const MEDIA_TYPE: &str = "application/x-armbridge-link";

const HEADER: usize = 1 + 8 + 4;

/// What a piece is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Bytes that went this way.
    Bytes(Direction),
    /// The connection broke.
    Parted,
}

impl From<Direction> for Kind {
    fn from(direction: Direction) -> Self {
        Self::Bytes(direction)
    }
}

/// Bytes that were read or written at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Piece<'a> {
    /// On the host's clock in ns.
    pub host_ns: u64,
    /// What it is.
    pub kind: Kind,
    /// What travelled.
    pub bytes: &'a [u8],
}

impl Piece<'_> {
    /// How long it will be.
    pub(super) fn framed_len(&self) -> usize {
        HEADER + self.bytes.len()
    }

    /// Appends it.
    pub(super) fn write(&self, to: &mut Vec<u8>) {
        to.push(match self.kind {
            Kind::Bytes(Direction::ToHost) => 0,
            Kind::Bytes(Direction::ToBoard) => 1,
            Kind::Parted => 2,
        });
        to.extend_from_slice(&self.host_ns.to_le_bytes());
        to.extend_from_slice(&(self.bytes.len() as u32).to_le_bytes());
        to.extend_from_slice(self.bytes);
    }
}

/// Pieces that cannot be told apart any more.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("what was kept of the link's bytes is damaged")]
pub struct Damaged;

/// The pieces of an attachment; a damaged one ends them.
pub fn pieces(mut framed: &[u8]) -> impl Iterator<Item = Result<Piece<'_>, Damaged>> {
    std::iter::from_fn(move || {
        if framed.is_empty() {
            return None;
        }
        let piece = split(framed);
        framed = piece.map_or(&[], |(_, rest)| rest);
        Some(piece.map(|(piece, _)| piece).ok_or(Damaged))
    })
}

/// Bytes of the link in an attachment.
pub(super) fn bytes(framed: &[u8]) -> u64 {
    let lens = pieces(framed).flatten().map(|piece| piece.bytes.len());
    lens.sum::<usize>() as u64
}

fn split(framed: &[u8]) -> Option<(Piece<'_>, &[u8])> {
    let (kind, rest) = framed.split_first()?;
    let (host_ns, rest) = rest.split_first_chunk()?;
    let (len, rest) = rest.split_first_chunk()?;
    let (bytes, rest) = rest.split_at_checked(u32::from_le_bytes(*len) as usize)?;
    let kind = match kind {
        0 => Kind::Bytes(Direction::ToHost),
        1 => Kind::Bytes(Direction::ToBoard),
        2 => Kind::Parted,
        _ => return None,
    };
    let host_ns = u64::from_le_bytes(*host_ns);
    Some((
        Piece {
            host_ns,
            kind,
            bytes,
        },
        rest,
    ))
}

/// Tells the events of one piece.
pub(super) fn hear(decoder: &mut LinkDecoder, piece: Piece<'_>, mut hear: impl FnMut(Event)) {
    match piece.kind {
        Kind::Bytes(direction) => decoder.take(direction, piece.host_ns, piece.bytes, hear),
        Kind::Parted => {
            // What began on one connection does not end on the next.
            *decoder = LinkDecoder::default();
            hear(Event {
                host_ns: piece.host_ns,
                kind: EventKind::Disconnected,
            });
        }
    }
}

/// The events of a log, heard once more from the bytes that are kept in it.
#[derive(Debug)]
pub struct Again {
    records: Records,
    body: Vec<u8>,
    decoder: LinkDecoder,
    heard: VecDeque<Event>,
}

impl Again {
    pub(super) fn open(path: &Path) -> io::Result<Option<Self>> {
        Ok(Records::open(path)?.map(|records| Self {
            records,
            body: Vec::new(),
            decoder: LinkDecoder::default(),
            heard: VecDeque::new(),
        }))
    }

    /// Hears the next attachment; `false` at the end.
    fn listen(&mut self) -> Result<bool, Damaged> {
        loop {
            let Ok(next) = self.records.next() else {
                return Ok(false);
            };
            match next {
                Next::Record(op::ATTACHMENT) => {}
                // What cannot be told apart any more ends it too.
                Next::Record(op::DATA_END) | Next::End | Next::Cut(_) | Next::Garbage(_) => {
                    return Ok(false);
                }
                Next::Record(_) => continue,
            }
            if self.records.read(&mut self.body).is_err() {
                return Ok(false);
            }
            let parsed = mcap::parse_record(op::ATTACHMENT, &self.body);
            // It checks the sum.
            let Ok(Record::Attachment { header, data, .. }) = parsed else {
                return Err(Damaged);
            };
            if header.media_type != MEDIA_TYPE {
                continue;
            }
            for piece in pieces(&data) {
                hear(&mut self.decoder, piece?, |event| {
                    self.heard.push_back(event);
                });
            }
            return Ok(true);
        }
    }
}

impl Iterator for Again {
    type Item = Result<Event, Damaged>;

    /// After damage, what follows is heard again from the next attachment on.
    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(event) = self.heard.pop_front() {
                return Some(Ok(event));
            }
            match self.listen() {
                Ok(true) => {}
                Ok(false) => return None,
                Err(damaged) => return Some(Err(damaged)),
            }
        }
    }
}
