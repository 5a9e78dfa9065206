//! Reader of a log, event by event, up to its first damage, in memory that the file cannot
//! extend: see [`limits`](super::limits).

mod channels;
mod damage;
mod messages;
mod rows;

pub use rows::{Row, Rows};

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

use armbridge_client::event::{Event, EventKind};
use armbridge_link::message::{Record, Settings, ToHost};
use mcap::records::op;

use super::error::ReadError;
use super::limits::{DAMAGE_SENTENCES, RECORD_BYTES, quote};
use super::log_path::find;
use super::mcap_records::{Next, Records, TooLong, parse, split};
use super::recorded_metadata::{self, MetadataByName, RecordedMetadata};
use super::simulation::{Push, TrueState};
use super::snapshots::{self, Snapshot};
use super::topics::Topic;
use super::{metadata, raw_link_bytes};
use crate::run_info::RunFacts;

use damage::is_closed;

/// Header of a chunk that is not compressed: times, size, checksum, an empty name, size.
const CHUNK_HEADER: usize = 8 + 8 + 8 + 4 + 4 + 8;

/// Content of a message.
#[expect(
    clippy::large_enum_variant,
    reason = "one at a time is on the stack, and a box for each would be allocated"
)]
enum Item {
    Event(Event),
    /// True state of a simulated arm at the start of this tick.
    State(u32, TrueState),
}

/// Reader of a log, for files that do not fit in memory.
#[derive(Debug)]
pub struct Reader {
    path: PathBuf,
    records: Records,
    /// Records of the present chunk, from `at` on.
    chunk: Vec<u8>,
    at: usize,
    channels: BTreeMap<u16, Topic>,
    metadata: MetadataByName,
    settings: Option<Settings>,
    facts: RunFacts,
    is_same_schema: bool,
    chunks: u64,
    unreadable: u64,
    /// Chunks that were left out, beyond those in `damage`.
    unlisted: u64,
    last_tick: Option<u32>,
    pushes: Vec<Push>,
    /// Number of them that have begun by the latest tick.
    pushes_begun: usize,
    /// States of a simulation are decoded, not skipped.
    reads_states: bool,
    is_over: bool,
    damage: Vec<String>,
}

impl Reader {
    /// Opens a log, and reads its metadata to its end. A folder means the
    /// log in it.
    ///
    /// # Errors
    /// When nothing can be read.
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let path = find(Some(path), Path::new("."))?;
        let (mut reader, recorded) = Self::begin(&path)?;
        reader.settings = match recorded.settings() {
            Some(settings) => Some(settings),
            // Its program ended before the motors were driven.
            None => Self::begin(&path)?.0.find_settings(),
        };
        reader.facts = recorded.facts(reader.settings.as_ref());
        reader.metadata = recorded.by_name;
        Ok(reader)
    }

    /// Opens the log at this path.
    fn begin(path: &Path) -> Result<(Self, RecordedMetadata), ReadError> {
        let failed = |why: String| ReadError {
            path: path.to_path_buf(),
            why,
        };
        let failed_io = |error: io::Error| failed(error.to_string());
        let Some(mut records) = Records::open(path).map_err(failed_io)? else {
            return Err(failed(
                "it is no MCAP file; logs of Armbridge are called run.mcap".into(),
            ));
        };
        let recorded = recorded_metadata::read(&mut records).map_err(failed_io)?;
        records.rewind().map_err(failed_io)?;
        let build = recorded.by_name.get(metadata::BUILD);
        let schema = build.and_then(|build| build.get("schema"));
        let is_same_schema = schema.is_none_or(|schema| *schema == metadata::schema_hash());
        let mut damage = Vec::new();
        if !is_same_schema {
            damage.push(
                "another version of Armbridge wrote it: commands and settings are read from \
                 their text, and replayed with that version only"
                    .into(),
            );
        }
        if recorded.is_left_out {
            damage
                .push("it has more metadata than a recorder writes: part of it is left out".into());
        }
        let mut reader = Self {
            path: path.to_path_buf(),
            records,
            chunk: Vec::new(),
            at: 0,
            channels: BTreeMap::new(),
            settings: None,
            facts: recorded.facts(None),
            metadata: MetadataByName::new(),
            is_same_schema,
            chunks: 0,
            unreadable: 0,
            unlisted: 0,
            last_tick: None,
            pushes: Vec::new(),
            pushes_begun: 0,
            reads_states: false,
            is_over: false,
            damage,
        };
        reader.find_channels().map_err(failed)?;
        Ok((reader, recorded))
    }

    /// The last settings that the board reported before its motors were first driven, else
    /// the last ones.
    fn find_settings(self) -> Option<Settings> {
        let mut found = None;
        for event in self {
            match event.kind {
                EventKind::Received(_, ToHost::Settings(settings)) => found = Some(settings),
                EventKind::Received(_, ToHost::Record(record))
                    if found.is_some() && record.mode.drive().is_some() =>
                {
                    break;
                }
                _ => {}
            }
        }
        found
    }

    /// Path of the log.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The facts of the run, with the [`settings`](Self::settings).
    pub fn facts(&self) -> &RunFacts {
        &self.facts
    }

    /// Settings in force when the motors were first driven, or the last ones if they never
    /// were; `None` if the log has none.
    pub fn settings(&self) -> Option<&Settings> {
        self.settings.as_ref()
    }

    /// Pushes on a simulated arm, as far as the file has been read, in the order of their
    /// start.
    pub fn pushes(&self) -> &[Push] {
        &self.pushes
    }

    /// Pushes that have begun by the start of this tick, each once. In the file a push may be
    /// before ticks of earlier time.
    pub fn pushes_begun(&mut self, record: &Record) -> &[Push] {
        let start_ns = record.input.start_us.saturating_mul(1_000);
        let waiting = self.pushes.get(self.pushes_begun..).unwrap_or_default();
        let begun = waiting.iter().take_while(|push| push.start_ns <= start_ns);
        let from = self.pushes_begun;
        self.pushes_begun += begun.count();
        self.pushes.get(from..self.pushes_begun).unwrap_or_default()
    }

    /// Whether the part that has been read has true states of a simulated arm.
    pub fn has_true_states(&self) -> bool {
        let mut topics = self.channels.values();
        topics.any(|topic| *topic == Topic::SimulationState)
    }

    /// Metadata by name and key; see [`metadata`].
    pub fn metadata(&self) -> &BTreeMap<String, BTreeMap<String, String>> {
        &self.metadata
    }

    /// Damage of the file as far as it has been read, each in one sentence;
    /// empty for an intact one.
    pub fn damage(&self) -> &[String] {
        &self.damage
    }

    /// Goes to the last snapshot of a tick that began by this time on the board's clock, in µs, so
    /// that the events after it follow, and returns the state. `None` if there is none; the reader
    /// stays where it is.
    ///
    /// # Errors
    /// When the file can no longer be read.
    pub fn go_to_snapshot(&mut self, until_us: u64) -> Result<Option<Vec<u8>>, ReadError> {
        let found = snapshots::find(&self.path, until_us).and_then(|found| {
            found.map_or(Ok(None), |Snapshot { state, end }| {
                self.records.go_to(end).map(|()| Some(state))
            })
        });
        let state = found.map_err(|error| ReadError {
            path: self.path.clone(),
            why: error.to_string(),
        })?;
        if state.is_some() {
            self.chunk.clear();
            self.at = 0;
        }
        Ok(state)
    }

    /// The build that wrote the log, if its link has another schema than this build's.
    pub fn other_build(&self) -> Option<String> {
        let build = self.metadata.get(metadata::BUILD);
        let build = build.filter(|_| !self.is_same_schema)?;
        let known = |key: &str| build.get(key).map_or("unknown", String::as_str);
        Some(format!("{}, commit {}", known("version"), known("git")))
    }

    /// Events decoded from the raw bytes in the log.
    ///
    /// # Errors
    /// When the file can no longer be read.
    pub fn raw(&self) -> Result<raw_link_bytes::RawEvents, ReadError> {
        let events = raw_link_bytes::RawEvents::open(&self.path).map_err(|error| error.to_string());
        events
            .and_then(|events| events.ok_or_else(|| "it is no MCAP file any more".into()))
            .map_err(|why| ReadError {
                path: self.path.clone(),
                why,
            })
    }

    /// Loads the next intact chunk; `false` at the end.
    fn load_chunk(&mut self) -> io::Result<bool> {
        while !self.is_over {
            match self.records.next()? {
                Next::Record(op::CHUNK) => {
                    self.chunks += 1;
                    match self.records.read(RECORD_BYTES, &mut self.chunk)? {
                        Ok(()) if self.unpack() => return Ok(true),
                        Ok(()) => {}
                        Err(TooLong { at, len }) => {
                            let limit_mib = RECORD_BYTES >> 20;
                            self.end_with(&format!(
                                "is read up to its chunk {}: at byte {at}, this has {len} bytes, \
                                 more than the {limit_mib} MiB that are read at once",
                                self.chunks
                            ));
                        }
                    }
                }
                Next::Record(op::DATA_END) => {
                    self.is_over = true;
                    if !is_closed(&self.path)? {
                        self.damage.push(
                            "the index at its end is missing: nothing that was recorded is, but \
                             viewers may ask for it"
                                .into(),
                        );
                    }
                }
                Next::Record(_) => {}
                Next::End => {
                    self.end_with("was not closed: its program was killed, or power failed");
                }
                Next::Cut(Some(op::CHUNK)) => {
                    let at = self.chunks + 1;
                    self.end_with(&format!("breaks off in the middle of chunk {at}"));
                }
                Next::Cut(_) => self.end_with("breaks off"),
                Next::Garbage(byte) => {
                    self.end_with(&format!("is damaged from byte {byte} on"));
                }
            }
        }
        Ok(false)
    }

    /// Extracts the records of the chunk; `false` if it is damaged.
    fn unpack(&mut self) -> bool {
        self.at = 0;
        let why = match parse(op::CHUNK, &self.chunk) {
            Some(mcap::records::Record::Chunk { header, data }) => {
                if !header.compression.is_empty() {
                    // Nor could it be larger than its file says once it is unpacked.
                    format!(
                        "is packed by {}, which is not read here",
                        quote(&header.compression)
                    )
                } else if header.uncompressed_crc != 0
                    && crc32fast::hash(&data) != header.uncompressed_crc
                {
                    "is damaged".into()
                } else {
                    let records = data.len();
                    self.at = CHUNK_HEADER;
                    self.chunk.truncate(CHUNK_HEADER + records);
                    return true;
                }
            }
            _ => "is damaged".into(),
        };
        self.chunk.clear();
        if self.damage.len() < DAMAGE_SENTENCES {
            let after = self.after_tick();
            self.damage.push(format!(
                "chunk {} {why} and left out: ticks {after} are missing",
                self.chunks
            ));
        } else {
            self.unlisted += 1;
        }
        false
    }

    /// The next record of the chunk: opcode, and range of its body.
    fn record(&mut self) -> Option<(u8, std::ops::Range<usize>)> {
        let (opcode, body, _) = split(self.chunk.get(self.at..)?)?;
        let start = self.at + 1 + 8;
        self.at = start + body.len();
        Some((opcode, start..self.at))
    }

    /// The next item; states only where [`rows`](Self::rows) wants them.
    fn next_item(&mut self) -> Option<Item> {
        loop {
            let Some((opcode, body)) = self.record() else {
                match self.load_chunk() {
                    Ok(true) => continue,
                    Ok(false) => {}
                    Err(error) => self.end_with(&format!("cannot be read further ({error})")),
                }
                self.report_unlisted();
                return None;
            };
            // Moved out temporarily, so that the reader can be borrowed mutably.
            let chunk = std::mem::take(&mut self.chunk);
            let item = self.item_of_record(opcode, chunk.get(body).unwrap_or_default());
            self.chunk = chunk;
            if item.is_some() {
                return item;
            }
        }
    }
}

impl Iterator for Reader {
    type Item = Event;

    fn next(&mut self) -> Option<Event> {
        loop {
            match self.next_item()? {
                Item::Event(event) => return Some(event),
                Item::State(..) => {}
            }
        }
    }
}
