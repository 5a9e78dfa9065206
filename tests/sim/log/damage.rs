//! Logs that were cut, damaged, or never were logs.

use std::fs;
use std::io::Write;
use std::path::Path;

use armbridge_link::message::ToHost;
use armbridge_log::recorder::Recorder;
use armbridge_log::recording::{ReadError, Recording};

use super::random_messages::{Random, Talk};
use super::{facts, folder};

/// Ticks of the log that is damaged here: some megabytes, so several chunks.
const TICKS: u32 = 40_000;

/// Writes a log; its bytes.
fn log(path: &Path) -> Vec<u8> {
    let recorder = Recorder::create_waiting(path, &facts()).unwrap();
    let mut tap = recorder.tap();
    let mut talk = Talk::new(&mut *tap);
    let mut random = Random(3);
    for tick in 0..TICKS {
        talk.tell(&ToHost::Record(random.record(tick)));
    }
    recorder.finish().unwrap();
    fs::read(path).unwrap()
}

fn load(path: &Path, bytes: &[u8]) -> Result<Recording, ReadError> {
    fs::write(path, bytes).unwrap();
    Recording::load(path)
}

#[test]
fn a_log_that_is_cut_is_read_as_far_as_it_goes() {
    let path = folder("cut").join("run.mcap");
    let whole = log(&path);
    let mut before = 0;
    let mut random = Random(9);
    let mut cuts: Vec<usize> = (0..30)
        .map(|_| random.bits() as usize % whole.len())
        .collect();
    cuts.extend([whole.len() - 1, whole.len() - 8, whole.len() - 9]);
    cuts.sort_unstable();
    for cut in cuts {
        let Ok(recording) = load(&path, &whole[..cut]) else {
            // Topics are defined in the first few kilobytes.
            assert!(cut < 40_000, "nothing of {cut} bytes");
            continue;
        };
        let records = recording.records();
        let ticks: Vec<u32> = records.iter().map(|record| record.tick).collect();
        assert!(ticks.iter().copied().eq(0..ticks.len() as u32));
        assert!(ticks.len() >= before, "less of more");
        before = ticks.len();
        // Flushed chunks are complete: one is closed each megabyte.
        let least = (cut as f64 / whole.len() as f64 - 0.3) * f64::from(TICKS);
        assert!(ticks.len() as f64 > least, "{} of {cut} bytes", ticks.len());
        let is_whole_data = ticks.len() as u32 == TICKS;
        match recording.damage.as_slice() {
            [] => panic!("{} ticks and no word", ticks.len()),
            [word] if word.contains("index at its end") => assert!(is_whole_data, "{cut} bytes"),
            [word] => {
                let last = ticks.last().map_or_else(
                    || "after its beginning".to_owned(),
                    |tick| format!("after tick {tick}"),
                );
                assert!(word.contains(&format!("{last} is missing")), "{word}");
            }
            more => panic!("{more:?}"),
        }
    }
    assert_eq!(before, TICKS as usize);
}

#[test]
fn a_damaged_chunk_is_left_out_and_named() {
    let path = folder("flipped").join("run.mcap");
    let mut bytes = log(&path);
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let chunks = summary.chunk_indexes;
    let (start, end) = (chunks.len() / 3, chunks.len() / 2);
    assert!(start < end, "{} chunks", chunks.len());
    for chunk in &chunks[start..end] {
        bytes[(chunk.chunk_start_offset + chunk.chunk_length / 2) as usize] ^= 0x10;
    }
    let recording = load(&path, &bytes).unwrap();
    let ticks: Vec<u32> = recording
        .records()
        .iter()
        .map(|record| record.tick)
        .collect();
    let is_damaged = |word: &String| word.contains("is damaged and left out: ticks after tick ");
    assert!(!recording.damage.is_empty(), "{} ticks", ticks.len());
    assert!(
        recording.damage.iter().all(is_damaged),
        "{:?}",
        recording.damage
    );
    assert!((TICKS as usize / 3..TICKS as usize).contains(&ticks.len()));
    assert_eq!(ticks.last(), Some(&(TICKS - 1)), "nothing after the damage");
    assert!(ticks.is_sorted());
}

#[test]
fn what_is_no_log_is_said_to_be_none() {
    let folder = folder("none");
    let word = |bytes: &[u8]| {
        let error = load(&folder.join("run.mcap"), bytes).unwrap_err();
        error.to_string()
    };
    for bytes in [&b""[..], b"time_s,tick\n0.1,1\n", &[0; 4096]] {
        let word = word(bytes);
        assert!(word.contains("run.mcap: it is no MCAP file"), "{word}");
    }
    let written = |topic: &str, encoding: &str| {
        let mut bytes = Vec::new();
        let mut writer = mcap::Writer::new(std::io::Cursor::new(&mut bytes)).unwrap();
        let schema = writer.add_schema("a", "jsonschema", b"{}").unwrap();
        let _ = writer.add_channel(
            schema,
            topic,
            encoding,
            &std::collections::BTreeMap::default(),
        );
        writer.finish().unwrap();
        drop(writer);
        bytes
    };
    let early = word(&written("/armbridge/record", "json"));
    assert!(early.contains("an early version"), "{early}");
    let foreign = word(&written("/odometry", "cdr"));
    assert!(
        foreign.contains("no log of Armbridge: it has the topic /odometry"),
        "{foreign}"
    );
    let error = Recording::load(&folder.join("gone.mcap")).unwrap_err();
    assert!(error.to_string().contains("gone.mcap"), "{error}");
}

/// A chunk of a gigabyte, which takes no space on the disk, and what the recorder wrote before.
#[test]
fn a_chunk_beyond_the_limit_is_named_with_its_place_and_size() {
    let path = folder("large").join("run.mcap");
    let bytes = log(&path);
    // Up to the index.
    let mut all = mcap::MAGIC.len();
    while bytes[all] != mcap::records::op::DATA_END {
        all += 9 + u64::from_le_bytes(bytes[all + 1..all + 9].try_into().unwrap()) as usize;
    }
    fs::write(&path, &bytes[..all]).unwrap();
    let body = 1_u64 << 30;
    let mut file = fs::OpenOptions::new().append(true).open(&path).unwrap();
    file.write_all(&[mcap::records::op::CHUNK]).unwrap();
    file.write_all(&body.to_le_bytes()).unwrap();
    file.set_len(all as u64 + 9 + body).unwrap();
    let recording = Recording::load(&path).unwrap();
    assert_eq!(recording.records().len(), TICKS as usize);
    let [word] = recording.damage.as_slice() else {
        panic!("{:?}", recording.damage)
    };
    let place = format!(
        "at byte {}, this has 1073741824 bytes, more than the 64 MiB",
        all + 9
    );
    assert!(word.contains(&place), "{word}");
    assert!(
        word.contains("what came after tick 39999 is missing"),
        "{word}"
    );
}
