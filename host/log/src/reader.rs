//! A log, event by event, in memory that does not grow with it, as far as it goes.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use armbridge_client::event::{Event, EventKind};
use armbridge_shared::link::message::{Settings, ToHost};
use mcap::records::{Record, op};
use prost::Message as _;

use super::log_path::find;
use super::recording::ReadError;
use super::records::{Next, Records, split};
use super::topics::Topic;
use super::{event_messages, metadata, proto, raw_link_bytes, telemetry};
use crate::run_info::RunFacts;

/// A log, event by event: for files that do not fit in memory.
#[derive(Debug)]
pub struct Reader {
    path: PathBuf,
    records: Records,
    /// What is read of: the records of a chunk, from here on.
    chunk: Vec<u8>,
    at: usize,
    channels: BTreeMap<u16, Topic>,
    metadata: BTreeMap<String, BTreeMap<String, String>>,
    facts: RunFacts,
    is_same_schema: bool,
    chunks: u64,
    unreadable: u64,
    last_tick: Option<u32>,
    is_over: bool,
    damage: Vec<String>,
}

impl Reader {
    /// Opens it, and reads what it says about itself, to its end. A folder means the
    /// log in it.
    ///
    /// # Errors
    /// When there is nothing that can be read.
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let path = find(Some(path), Path::new("."))?;
        let failed = |why: String| ReadError {
            path: path.clone(),
            why,
        };
        let failed_io = |error: io::Error| failed(error.to_string());
        let Some(mut records) = Records::open(&path).map_err(failed_io)? else {
            return Err(failed(
                "it is no MCAP file; logs of Armbridge are called run.mcap".into(),
            ));
        };
        let known = read_metadata(&mut records).map_err(failed_io)?;
        records.rewind().map_err(failed_io)?;
        let schema = known
            .get(metadata::BUILD)
            .and_then(|build| build.get("schema"));
        let is_same_schema = schema.is_none_or(|schema| *schema == metadata::schema_hash());
        let mut damage = Vec::new();
        if !is_same_schema {
            damage.push(
                "another version of Armbridge wrote it: commands and settings are read from \
                 their text, and replayed with that version only"
                    .into(),
            );
        }
        let mut reader = Self {
            path: path.clone(),
            records,
            chunk: Vec::new(),
            at: 0,
            channels: BTreeMap::new(),
            facts: facts(&known),
            metadata: known,
            is_same_schema,
            chunks: 0,
            unreadable: 0,
            last_tick: None,
            is_over: false,
            damage,
        };
        reader.find_channels().map_err(failed)?;
        Ok(reader)
    }

    /// Where it is read from.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The facts of the run; made of its settings, if the log has none.
    pub fn facts(&self) -> &RunFacts {
        &self.facts
    }

    /// The settings that the board told last; `None` if it never did.
    pub fn last_settings(&self) -> Option<Settings> {
        settings(&self.metadata)
    }

    /// What the log says about itself, by name and key; see [`metadata`].
    pub fn metadata(&self) -> &BTreeMap<String, BTreeMap<String, String>> {
        &self.metadata
    }

    /// What is missing of the file as far as it has been read, each in one sentence;
    /// empty for an intact one.
    pub fn damage(&self) -> &[String] {
        &self.damage
    }

    /// The events again, from the raw bytes of the link that are kept in the log.
    ///
    /// # Errors
    /// When the file cannot be read any more.
    pub fn raw(&self) -> Result<raw_link_bytes::Again, ReadError> {
        let again = raw_link_bytes::Again::open(&self.path).map_err(|error| error.to_string());
        again
            .and_then(|again| again.ok_or_else(|| "it is no MCAP file any more".into()))
            .map_err(|why| ReadError {
                path: self.path.clone(),
                why,
            })
    }

    /// Reads on until topics are known, which are told first.
    fn find_channels(&mut self) -> Result<(), String> {
        while self.channels.is_empty() {
            if !self.load().map_err(|error| error.to_string())? {
                return Err("it breaks off before anything was recorded".into());
            }
            let chunk = std::mem::take(&mut self.chunk);
            let mut rest = chunk.get(self.at..).unwrap_or_default();
            while let Some((opcode, body, after)) = split(rest) {
                rest = after;
                if opcode == op::CHANNEL {
                    self.learn(body)?;
                }
            }
            self.chunk = chunk;
        }
        Ok(())
    }

    fn learn(&mut self, body: &[u8]) -> Result<(), String> {
        let Ok(Record::Channel(channel)) = mcap::parse_record(op::CHANNEL, body) else {
            return Ok(());
        };
        if channel.topic.starts_with("/armbridge/") {
            return Err(
                "it is a log of an early version, in JSON; record again, or read it with the \
                 version that wrote it"
                    .into(),
            );
        }
        let is_ours = |topic: &Topic| topic.name() == channel.topic;
        match Topic::ALL.into_iter().find(is_ours) {
            Some(topic) if channel.message_encoding == "protobuf" => {
                self.channels.insert(channel.id, topic);
                Ok(())
            }
            // Somebody added a topic: no matter, if ours are there too.
            Some(_) | None if !self.channels.is_empty() => Ok(()),
            Some(_) | None => Err(format!(
                "it is an MCAP file, but no log of Armbridge: it has the topic {}",
                channel.topic
            )),
        }
    }

    /// Loads the next chunk that is intact; `false` at the end.
    fn load(&mut self) -> io::Result<bool> {
        while !self.is_over {
            match self.records.next()? {
                Next::Record(op::CHUNK) => {
                    self.chunks += 1;
                    self.records.read(&mut self.chunk)?;
                    if self.unpack() {
                        return Ok(true);
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
                Next::End => self.ends("was not closed: its program was killed, or power failed"),
                Next::Cut(Some(op::CHUNK)) => {
                    let at = self.chunks + 1;
                    self.ends(&format!("breaks off in the middle of chunk {at}"));
                }
                Next::Cut(_) => self.ends("breaks off"),
                Next::Garbage(byte) => {
                    self.ends(&format!("is damaged from byte {byte} on"));
                }
            }
        }
        Ok(false)
    }

    fn ends(&mut self, how: &str) {
        self.is_over = true;
        let after = self.after_tick();
        self.damage
            .push(format!("the log {how}; what came {after} is missing"));
    }

    fn after_tick(&self) -> String {
        self.last_tick.map_or_else(
            || "after its beginning".into(),
            |tick| format!("after tick {tick}"),
        )
    }

    /// Takes the records out of the chunk that was read; `false` if it is damaged.
    fn unpack(&mut self) -> bool {
        self.at = 0;
        let why = match mcap::parse_record(op::CHUNK, &self.chunk) {
            Ok(Record::Chunk { header, data }) => {
                if !header.compression.is_empty() {
                    format!(
                        "is packed by {}, which is not read here",
                        header.compression
                    )
                } else if header.uncompressed_crc != 0
                    && crc32fast::hash(&data) != header.uncompressed_crc
                {
                    "is damaged".into()
                } else {
                    // What stands before the records is gone over.
                    self.at = self.chunk.len() - data.len();
                    return true;
                }
            }
            Ok(_) | Err(_) => "is damaged".into(),
        };
        self.chunk.clear();
        let after = self.after_tick();
        self.damage.push(format!(
            "chunk {} {why} and left out: ticks {after} are missing",
            self.chunks
        ));
        false
    }

    fn message(
        &mut self,
        topic: Topic,
        bytes: &[u8],
    ) -> Result<Option<Event>, event_messages::Unreadable> {
        let same = self.is_same_schema;
        let unreadable = |_| event_messages::Unreadable;
        let (host_ns, kind) = match topic {
            Topic::Telemetry => {
                let message = proto::Telemetry::decode(bytes).map_err(unreadable)?;
                let (sequence, record) =
                    telemetry::record(&message).ok_or(event_messages::Unreadable)?;
                self.last_tick = Some(record.tick);
                (
                    message.host_ns,
                    EventKind::Received(sequence, ToHost::Record(record)),
                )
            }
            Topic::Commands => {
                let message = proto::Command::decode(bytes).map_err(unreadable)?;
                let what =
                    event_messages::asked(&message, same).ok_or(event_messages::Unreadable)?;
                (message.host_ns, what)
            }
            Topic::Events => {
                let message = proto::Event::decode(bytes).map_err(unreadable)?;
                match event_messages::event(&message, same)? {
                    Some(what) => (message.host_ns, what),
                    None => return Ok(None),
                }
            }
            Topic::Parameters => {
                let message = proto::Parameters::decode(bytes).map_err(unreadable)?;
                let what =
                    event_messages::settings(&message, same).ok_or(event_messages::Unreadable)?;
                (message.host_ns, what)
            }
            // Made of the others.
            Topic::Statistics
            | Topic::Log
            | Topic::JointStates
            | Topic::Transforms
            | Topic::Scene => return Ok(None),
        };
        Ok(Some(Event { host_ns, kind }))
    }

    /// The next record of the chunk, as its opcode and where its body is.
    fn record(&mut self) -> Option<(u8, std::ops::Range<usize>)> {
        let (opcode, body, _) = split(self.chunk.get(self.at..)?)?;
        let start = self.at + 1 + 8;
        self.at = start + body.len();
        Some((opcode, start..self.at))
    }

    fn receive(&mut self, opcode: u8, body: &[u8]) -> Option<Event> {
        match mcap::parse_record(opcode, body) {
            Ok(Record::Message { header, data }) => {
                let topic = *self.channels.get(&header.channel_id)?;
                self.message(topic, &data).unwrap_or_else(|_| {
                    self.unreadable += 1;
                    None
                })
            }
            // Our topics are all known by now; other records are of no interest.
            Ok(_) | Err(_) => None,
        }
    }

    fn close(&mut self) {
        if self.unreadable > 0 {
            self.damage.push(format!(
                "{} messages are of another version and were left out",
                self.unreadable
            ));
            self.unreadable = 0;
        }
    }
}

impl Iterator for Reader {
    type Item = Event;

    fn next(&mut self) -> Option<Event> {
        loop {
            let Some((opcode, body)) = self.record() else {
                match self.load() {
                    Ok(true) => continue,
                    Ok(false) => {}
                    Err(error) => self.ends(&format!("cannot be read further ({error})")),
                }
                self.close();
                return None;
            };
            // Lent for a moment, so that it can be read while the reader learns.
            let chunk = std::mem::take(&mut self.chunk);
            let heard = self.receive(opcode, chunk.get(body).unwrap_or_default());
            self.chunk = chunk;
            if heard.is_some() {
                return heard;
            }
        }
    }
}

/// Whether a file ends as MCAP does: nothing of its index is missing.
fn is_closed(path: &Path) -> io::Result<bool> {
    let mut file = File::open(path)?;
    let mut end = [0; mcap::MAGIC.len()];
    file.seek(SeekFrom::End(-(end.len() as i64)))?;
    file.read_exact(&mut end)?;
    Ok(end == mcap::MAGIC)
}

/// Metadata by name and key.
type Known = BTreeMap<String, BTreeMap<String, String>>;

fn settings(known: &Known) -> Option<Settings> {
    serde_json::from_str(known.get(metadata::PARAMETERS)?.get("json")?).ok()
}

fn facts(known: &Known) -> RunFacts {
    let told = known.get(metadata::RUN).and_then(metadata::facts);
    told.unwrap_or_else(|| RunFacts::of("unknown", "unknown", &settings(known).unwrap_or_default()))
}

/// All metadata of a file; of one name, the last.
fn read_metadata(records: &mut Records) -> io::Result<Known> {
    let (mut all, mut body) = (BTreeMap::new(), Vec::new());
    while let Next::Record(opcode) = records.next()? {
        if opcode == op::METADATA {
            records.read(&mut body)?;
            if let Ok(Record::Metadata(record)) = mcap::parse_record(op::METADATA, &body) {
                all.insert(record.name, record.metadata);
            }
        }
    }
    Ok(all)
}
