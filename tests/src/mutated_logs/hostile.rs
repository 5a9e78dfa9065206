//! Logs that are made to fill the memory of their reader.

use std::fs::File;
use std::io::{Result, Write};
use std::path::Path;

use armbridge_log::raw_link_bytes::MEDIA_TYPE;
use mcap::records::op;

/// Size of what is repeated: large enough that a reader which keeps it all fails.
const BYTES: usize = 12 << 20;

/// Identifier of the channel with the settings, in logs of the recorder.
const PARAMETERS: u16 = 4;

fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
    let mut record = vec![opcode];
    record.extend_from_slice(&(body.len() as u64).to_le_bytes());
    record.extend_from_slice(body);
    record
}

fn string(text: &str) -> Vec<u8> {
    let mut string = (text.len() as u32).to_le_bytes().to_vec();
    string.extend_from_slice(text.as_bytes());
    string
}

/// A chunk without a checksum.
fn chunk(records: &[u8]) -> Vec<u8> {
    let mut body = vec![0; 28];
    body.extend(string(""));
    body.extend_from_slice(&(records.len() as u64).to_le_bytes());
    body.extend_from_slice(records);
    record(op::CHUNK, &body)
}

/// A message of the settings in which two bytes are a parameter.
fn settings() -> Vec<u8> {
    let mut message = vec![0; 22];
    message[..2].copy_from_slice(&PARAMETERS.to_le_bytes());
    message.extend([0x1a, 0].repeat(BYTES / 2));
    chunk(&record(op::MESSAGE, &message))
}

/// An attachment of the link's bytes in which two bytes are a frame.
fn frames() -> Vec<u8> {
    let mut piece = vec![0; 9];
    piece.extend_from_slice(&(BYTES as u32).to_le_bytes());
    piece.extend([1, 0].repeat(BYTES / 2));
    let mut body = vec![0; 16];
    body.extend(string("link-000001.bin"));
    body.extend(string(MEDIA_TYPE));
    body.extend_from_slice(&(piece.len() as u64).to_le_bytes());
    body.extend(piece);
    body.extend([0; 4]);
    record(op::ATTACHMENT, &body)
}

/// Metadata of many names, each with many short entries.
fn metadata() -> Vec<u8> {
    let entries: Vec<u8> = (0..5_000)
        .flat_map(|key| [string(&key.to_string()), string("")].concat())
        .collect();
    let one = |name: usize| {
        let mut body = string(&name.to_string());
        body.extend_from_slice(&(entries.len() as u32).to_le_bytes());
        body.extend_from_slice(&entries);
        record(op::METADATA, &body)
    };
    (0..BYTES / entries.len()).flat_map(one).collect()
}

/// Writes such logs into a folder, each behind all of `log`; returns their names.
pub(super) fn write(folder: &Path, log: &[u8]) -> Result<Vec<&'static str>> {
    // In an attachment, all but its data and its checksum, for which there is no room.
    let mut no_room = vec![0; 16];
    no_room.extend(string("link-000001.bin"));
    no_room.extend(string(MEDIA_TYPE));
    no_room.extend([0; 8]);
    let parts = [
        ("settings", settings()),
        ("frames", frames()),
        ("metadata", metadata()),
        ("empty-chunks", record(op::CHUNK, &[]).repeat(BYTES / 9)),
        ("no-room", record(op::ATTACHMENT, &no_room)),
    ];
    // Before the end of the data, where readers stop.
    let end = super::mcap_bytes::data_end(log);
    for (name, part) in &parts {
        let mut file = File::create(folder.join(name).with_extension("mcap"))?;
        file.write_all(&log[..end])?;
        file.write_all(part)?;
        file.write_all(&log[end..])?;
    }
    // A chunk of a gigabyte, which takes no space on the disk.
    let mut file = File::create(folder.join("gigabyte.mcap"))?;
    file.write_all(&log[..end])?;
    let body = 1_u64 << 30;
    file.write_all(&[op::CHUNK])?;
    file.write_all(&body.to_le_bytes())?;
    file.set_len(end as u64 + 9 + body)?;
    let names = parts.iter().map(|(name, _)| *name);
    Ok(names.chain(["gigabyte"]).collect())
}
