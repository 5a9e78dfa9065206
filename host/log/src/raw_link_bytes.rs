//! Raw bytes of a link in a log, independent of their decoding.
//!
//! In the log they are attachments `link-000001.bin`, `link-000002.bin`..., one
//! with each chunk of the log, of media type [`MEDIA_TYPE`]. Each is a sequence of pieces:
//!
//! ```text
//! kind u8 | host_ns u64 | length u32 | bytes
//! ```
//!
//! little endian. Kind 0 is from the board, 1 is to the board, 2 is a
//! disconnection and has no bytes. A frame may begin in one piece, or in one
//! attachment, and end in another. [`RawEvents`] decodes them again.

use std::collections::VecDeque;
use std::io;
use std::ops::Range;
use std::path::Path;

use armbridge_client::event::{Direction, Event, EventKind, LinkDecoder};
use mcap::records::{Record, op};

use super::limits::RECORD_BYTES;
use super::mcap_records::{Next, Records, parse};

/// Media type of the attachments.
pub const MEDIA_TYPE: &str = "application/x-armbridge-link";

const HEADER: usize = 1 + 8 + 4;

/// Kind of a piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PieceKind {
    /// Bytes of this direction.
    Bytes(Direction),
    /// The connection broke.
    Disconnected,
}

impl From<Direction> for PieceKind {
    fn from(direction: Direction) -> Self {
        Self::Bytes(direction)
    }
}

/// Bytes of one read or write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Piece<'a> {
    /// On the host's clock in ns.
    pub host_ns: u64,
    /// Its kind.
    pub kind: PieceKind,
    /// The bytes.
    pub bytes: &'a [u8],
}

impl Piece<'_> {
    /// Length in an attachment.
    pub(super) fn framed_len(&self) -> usize {
        HEADER + self.bytes.len()
    }

    /// Appends the piece to an attachment.
    pub(super) fn write(&self, to: &mut Vec<u8>) {
        to.push(match self.kind {
            PieceKind::Bytes(Direction::ToHost) => 0,
            PieceKind::Bytes(Direction::ToBoard) => 1,
            PieceKind::Disconnected => 2,
        });
        to.extend_from_slice(&self.host_ns.to_le_bytes());
        to.extend_from_slice(&(self.bytes.len() as u32).to_le_bytes());
        to.extend_from_slice(self.bytes);
    }
}

/// Error of an attachment whose pieces cannot be separated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("what was kept of the link's bytes is damaged")]
pub struct Damaged;

/// Pieces of an attachment, up to a damaged one.
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
        0 => PieceKind::Bytes(Direction::ToHost),
        1 => PieceKind::Bytes(Direction::ToBoard),
        2 => PieceKind::Disconnected,
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

/// Decodes one piece.
pub(super) fn decode(decoder: &mut LinkDecoder, piece: Piece<'_>, mut on_event: impl FnMut(Event)) {
    match piece.kind {
        PieceKind::Bytes(direction) => {
            decoder.take(direction, piece.host_ns, piece.bytes, on_event);
        }
        PieceKind::Disconnected => {
            // A partial frame does not continue on the next connection.
            *decoder = LinkDecoder::default();
            on_event(Event {
                host_ns: piece.host_ns,
                kind: EventKind::Disconnected,
            });
        }
    }
}

/// Bytes that are decoded at once: two of them may make an event, which is much larger.
const SLICE: usize = 4096;

/// Events of a log, decoded again from its raw bytes.
#[derive(Debug)]
pub struct RawEvents {
    records: Records,
    record: Vec<u8>,
    /// Pieces of the present attachment.
    framed: Range<usize>,
    /// Bytes of the present piece, with its kind and time.
    piece: Option<(PieceKind, u64, Range<usize>)>,
    decoder: LinkDecoder,
    events: VecDeque<Event>,
}

impl RawEvents {
    pub(super) fn open(path: &Path) -> io::Result<Option<Self>> {
        Ok(Records::open(path)?.map(|records| Self {
            records,
            record: Vec::new(),
            framed: 0..0,
            piece: None,
            decoder: LinkDecoder::default(),
            events: VecDeque::new(),
        }))
    }

    /// Decodes the next bytes; `false` at the end.
    fn decode_next(&mut self) -> Result<bool, Damaged> {
        if let Some((kind, host_ns, range)) = self.piece.take() {
            let end = range.end.min(range.start + SLICE);
            let bytes = self.record.get(range.start..end).unwrap_or_default();
            let piece = Piece {
                host_ns,
                kind,
                bytes,
            };
            decode(&mut self.decoder, piece, |event| {
                self.events.push_back(event);
            });
            self.piece = (end < range.end).then_some((kind, host_ns, end..range.end));
            return Ok(true);
        }
        if self.framed.is_empty() {
            return self.load();
        }
        let framed = self.record.get(self.framed.clone()).unwrap_or_default();
        let start = self.framed.start + HEADER;
        // Damage ends the attachment.
        self.framed.start = self.framed.end;
        let (piece, rest) = split(framed).ok_or(Damaged)?;
        self.piece = Some((piece.kind, piece.host_ns, start..start + piece.bytes.len()));
        self.framed.start -= rest.len();
        Ok(true)
    }

    /// Loads the next attachment; `false` at the end.
    fn load(&mut self) -> Result<bool, Damaged> {
        loop {
            let Ok(next) = self.records.next() else {
                return Ok(false);
            };
            match next {
                Next::Record(op::ATTACHMENT) => {}
                // Damage of the file ends it too.
                Next::Record(op::DATA_END) | Next::End | Next::Cut(_) | Next::Garbage(_) => {
                    return Ok(false);
                }
                Next::Record(_) => continue,
            }
            match self.records.read(RECORD_BYTES, &mut self.record) {
                Ok(Ok(())) => {}
                Ok(Err(_)) => return Err(Damaged),
                Err(_) => return Ok(false),
            }
            // The parser checks the checksum.
            let Some(Record::Attachment { header, data, .. }) = parse(op::ATTACHMENT, &self.record)
            else {
                return Err(Damaged);
            };
            if header.media_type == MEDIA_TYPE {
                let strings = header.name.len() + header.media_type.len();
                let start = 8 + 8 + 4 + 4 + strings + 8;
                self.framed = start..start + data.len();
                return Ok(true);
            }
        }
    }
}

impl Iterator for RawEvents {
    type Item = Result<Event, Damaged>;

    /// After damage, decoding continues with the next attachment.
    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(event) = self.events.pop_front() {
                return Some(Ok(event));
            }
            match self.decode_next() {
                Ok(true) => {}
                Ok(false) => return None,
                Err(damaged) => return Some(Err(damaged)),
            }
        }
    }
}
