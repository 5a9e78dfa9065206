//! Mutations of an MCAP file that know where its lengths are.

use std::ops::Range;

use mcap::records::op;

use crate::random::Random;

/// Opcode and length of a record.
const HEADER: usize = 1 + 8;
/// A chunk's header before the name of its compression, and the checksum in it.
const CHUNK_FIXED: usize = 28;
const CHUNK_CRC: Range<usize> = 24..28;

/// Values for a length: too long for the record, the file, the memory, and the type.
const LENGTHS: [u64; 12] = [
    0,
    1,
    0x7f,
    0xffff,
    50_000_000,
    0x0fff_ffff,
    0x7fff_ffff,
    0xffff_fff0,
    0xffff_ffff,
    1 << 33,
    i64::MAX as u64,
    u64::MAX,
];

/// A record in a file: its opcode, and where its body is.
#[derive(Clone, Debug)]
struct Record {
    opcode: u8,
    body: Range<usize>,
}

impl Record {
    /// With opcode and length.
    fn whole(&self) -> Range<usize> {
        self.body.start - HEADER..self.body.end
    }
}

/// Records in a part of a file, up to one that does not fit.
fn records(file: &[u8], within: Range<usize>) -> Vec<Record> {
    let (mut at, mut all) = (within.start, Vec::new());
    while let Some((opcode, rest)) = file.get(at..within.end).and_then(<[u8]>::split_first)
        && let Some((len, _)) = rest.split_first_chunk()
    {
        let start = at + HEADER;
        let len = usize::try_from(u64::from_le_bytes(*len)).unwrap_or(usize::MAX);
        at = start.saturating_add(len);
        if at > within.end {
            break;
        }
        all.push(Record {
            opcode: *opcode,
            body: start..at,
        });
    }
    all
}

/// Records of the file, without those in chunks.
fn top(file: &[u8]) -> Vec<Record> {
    records(file, mcap::MAGIC.len()..file.len())
}

/// Where the data end and the index begins.
pub(super) fn data_end(file: &[u8]) -> usize {
    let all = top(file).into_iter();
    let mut ends = all.filter(|record| record.opcode == op::DATA_END);
    ends.next()
        .map_or(file.len(), |record| record.whole().start)
}

/// Records in a chunk that is not compressed.
fn inner(file: &[u8], chunk: &Record) -> Vec<Record> {
    records(file, chunk.body.start + CHUNK_FIXED + 4 + 8..chunk.body.end)
}

/// Places of the lengths in a record, with their size: its own, those of its strings and maps,
/// and declared sizes.
fn lengths(file: &[u8], record: &Record) -> Vec<Range<usize>> {
    let body = &record.body;
    let own = body.start - 8..body.start;
    // Up to its first string, its strings, and what follows them.
    let (fixed, strings, rest): (usize, usize, &[usize]) = match record.opcode {
        op::HEADER => (0, 2, &[]),
        op::FOOTER => (0, 0, &[8, 8]),
        op::SCHEMA => (2, 2, &[4]),
        op::CHANNEL => (4, 2, &[4]),
        op::CHUNK => (CHUNK_FIXED, 1, &[8]),
        op::MESSAGE_INDEX => (2, 0, &[4]),
        op::CHUNK_INDEX => (32, 0, &[4]),
        op::ATTACHMENT => (16, 2, &[8]),
        op::ATTACHMENT_INDEX => (40, 2, &[]),
        op::STATISTICS => (42, 0, &[4]),
        op::METADATA => (0, 1, &[4, 4]),
        op::METADATA_INDEX => (16, 1, &[]),
        _ => (0, 0, &[]),
    };
    let mut all = vec![own];
    if record.opcode == op::CHUNK {
        // Its uncompressed size.
        all.push(body.start + 16..body.start + 24);
    }
    let mut at = body.start + fixed;
    for _ in 0..strings {
        all.push(at..at + 4);
        let len = file.get(at..at + 4).map_or(0, |len| {
            u32::from_le_bytes([len[0], len[1], len[2], len[3]]) as usize
        });
        at = at.saturating_add(4 + len);
    }
    for size in rest {
        all.push(at..at + size);
        at += size;
    }
    all.retain(|place| place.end <= body.end);
    all
}

/// A log with the mutations of this seed, out of two.
pub(super) fn mutated(logs: &[Vec<u8>; 2], seed: u64) -> Vec<u8> {
    let mut random = Random::new(0x9E37_79B9_7F4A_7C15 ^ (seed + 1));
    // The first numbers of neighbouring seeds are alike.
    for _ in 0..8 {
        random.byte();
    }
    let mut file = logs[random.below(2) as usize].clone();
    for _ in 0..=random.below(3) {
        if seed.is_multiple_of(2) {
            damage(&mut file, &logs[random.below(2) as usize], &mut random);
        } else {
            aim(&mut file, &mut random);
        }
    }
    file
}

fn place(file: &[u8], random: &mut Random) -> usize {
    random.below(file.len().max(1) as u64) as usize
}

/// A part of up to this many bytes.
fn part(file: &[u8], most: u64, random: &mut Random) -> Range<usize> {
    let start = place(file, random);
    start..file.len().min(start + 1 + random.below(most) as usize)
}

/// Damages bytes anywhere.
fn damage(file: &mut Vec<u8>, other: &[u8], random: &mut Random) {
    match random.below(8) {
        0 => {
            for _ in 0..=random.below(64) {
                let at = place(file, random);
                if let Some(byte) = file.get_mut(at) {
                    *byte ^= 1 << random.below(8);
                }
            }
        }
        1 => file.truncate(place(file, random)),
        2 => {
            let zeros = part(file, 100_000, random);
            file[zeros].fill(0);
        }
        // The beginning of one, and the end of the other.
        3 => {
            file.truncate(place(file, random));
            file.extend_from_slice(&other[place(other, random)..]);
        }
        // The same between two records.
        4 => {
            let (ours, theirs) = (top(file), top(other));
            if let ([_, ..], [_, ..]) = (ours.as_slice(), theirs.as_slice()) {
                file.truncate(ours[place_of(&ours, random)].body.end);
                let from = theirs[place_of(&theirs, random)].whole().start;
                file.extend_from_slice(&other[from..]);
            }
        }
        5 => {
            let bytes = file[part(file, 50_000, random)].to_vec();
            let at = place(file, random);
            file.splice(at..at, bytes);
        }
        6 => drop(file.drain(part(file, 50_000, random))),
        // A record in another place, or in two.
        _ => {
            let all = top(file);
            if all.is_empty() {
                return;
            }
            let (one, at) = (&all[place_of(&all, random)], &all[place_of(&all, random)]);
            let (one, at) = (one.whole(), at.whole().start);
            let bytes = file[one.clone()].to_vec();
            if at <= one.start && random.once_in(2) {
                file.drain(one);
            }
            file.splice(at..at, bytes);
        }
    }
}

fn place_of<T>(all: &[T], random: &mut Random) -> usize {
    random.below(all.len() as u64) as usize
}

/// Puts a number where a length, a size or a number of a message is.
fn aim(file: &mut [u8], random: &mut Random) {
    let mut all = top(file);
    let chunks: Vec<Record> = all
        .iter()
        .filter(|record| record.opcode == op::CHUNK)
        .cloned()
        .collect();
    // What is in a chunk is read only if its checksum is right, or zero.
    if let [_, ..] = chunks.as_slice()
        && random.once_in(2)
    {
        let chunk = &chunks[place_of(&chunks, random)];
        file[chunk.body.clone()][CHUNK_CRC].fill(0);
        all = inner(file, chunk);
        if random.once_in(2) {
            spoil_messages(file, &all, random);
            return;
        }
    }
    // Messages are many: half of the time a record that is none.
    if random.once_in(2) {
        let is_other = |record: &Record| {
            !matches!(
                record.opcode,
                op::MESSAGE | op::MESSAGE_INDEX | op::CHUNK_INDEX | op::ATTACHMENT_INDEX
            )
        };
        all.retain(is_other);
    }
    if all.is_empty() {
        return;
    }
    let lengths = lengths(file, &all[place_of(&all, random)]);
    let place = lengths[place_of(&lengths, random)].clone();
    let size = place.len();
    let bytes = &mut file[place];
    let before = bytes.iter().rev().fold(0, |n, b| n << 8 | u64::from(*b));
    let value = match random.below(4) {
        0 => before.wrapping_add(random.below(20)).wrapping_sub(10),
        1 => before.wrapping_mul(1 + random.below(1 << 20)),
        _ => random.one_of(&LENGTHS),
    };
    bytes.copy_from_slice(&value.to_le_bytes()[..size]);
}

/// Changes bytes of messages.
fn spoil_messages(file: &mut [u8], all: &[Record], random: &mut Random) {
    if all.is_empty() {
        return;
    }
    for _ in 0..=random.below(200) {
        let body = all[place_of(all, random)].body.clone();
        if let Some(byte) =
            file[body.clone()].get_mut(random.below(body.len().max(1) as u64) as usize)
        {
            *byte = match random.below(4) {
                0 => 0xff,
                1 => 0,
                2 => *byte ^ (1 << random.below(8)),
                _ => random.byte(),
            };
        }
    }
}
