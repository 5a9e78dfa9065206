//! Snapshots in a log: states of its replay, from which a replay may begin.
//!
//! The recorder replays what it writes, and attaches the state of the replay each second of the
//! board's clock, as long as it is known: an attachment [`NAME`] of media type [`MEDIA_TYPE`],
//! 1 to 2 kB, after the messages that led to it. Its bytes are the start of the last tick in µs,
//! a little-endian u64, and the state in the encoding of the build that wrote it.

use std::io;
use std::path::Path;

use mcap::records::{Record, op};

use super::limits::SNAPSHOT_BYTES;
use super::mcap_records::{Next, Records, parse};

/// Name of the attachments.
pub(super) const NAME: &str = "snapshot";

/// Media type of the attachments.
pub(super) const MEDIA_TYPE: &str = "application/x-armbridge-snapshot";

/// Offset of an attachment's name: log time, create time, length of the name.
const NAME_AT: usize = 8 + 8 + 4;

/// Bytes that are read at once while records are skipped.
const SCAN_BYTES: usize = 512;

/// A snapshot, and the byte of the file behind it.
pub(super) struct Snapshot {
    pub(super) state: Vec<u8>,
    pub(super) end: u64,
}

/// The last snapshot in the file of a tick that began by this time on the board's clock, in µs;
/// `None` if there is none.
pub(super) fn find(path: &Path, until_us: u64) -> io::Result<Option<Snapshot>> {
    let Some(mut records) = Records::open_for_scan(path, SCAN_BYTES)? else {
        return Ok(None);
    };
    let (mut found, mut body) = (None, Vec::new());
    loop {
        match records.next()? {
            Next::Record(op::ATTACHMENT) => {}
            Next::Record(op::DATA_END) | Next::End | Next::Cut(_) | Next::Garbage(_) => {
                return Ok(found);
            }
            Next::Record(_) => continue,
        }
        body.clear();
        records.read_begin(NAME_AT + NAME.len(), &mut body)?;
        let is_snapshot = body.get(NAME_AT..) == Some(NAME.as_bytes());
        if !is_snapshot || !records.read_rest(SNAPSHOT_BYTES, &mut body)? {
            continue;
        }
        let Some(Record::Attachment { header, data, .. }) = parse(op::ATTACHMENT, &body) else {
            continue;
        };
        let Some((start_us, state)) = data.split_first_chunk() else {
            continue;
        };
        if header.media_type != MEDIA_TYPE {
            continue;
        }
        if u64::from_le_bytes(*start_us) > until_us {
            return Ok(found);
        }
        found = Some(Snapshot {
            state: state.to_vec(),
            end: records.at(),
        });
    }
}
