//! `run.mcap`: the complete log, for viewers and for replay.
//!
//! | channel              | schema              | one message per          |
//! |----------------------|---------------------|--------------------------|
//! | `/armbridge/record`  | `armbridge.Tick`    | tick                     |
//! | `/armbridge/command` | `armbridge.Command` | command the host sent    |
//!
//! Messages are JSON with a JSON schema, which Foxglove and `PlotJuggler` open
//! as they are. Log time is the board's (or the simulation's) clock in ns, so
//! its epoch is the board's boot. The metadata record `run` holds the
//! [`RunFacts`], one string per fact.
//!
//! Chunks of 1 MiB, indexed, each with a CRC, not compressed: the compressors
//! the MCAP library offers are C libraries, and a run of 10 s is about 5 MB.

use super::LogError;
use super::message::{COMMAND_SCHEMA, CommandMessage, TICK_SCHEMA, TickMessage};
use crate::facts::RunFacts;
use armbridge_shared::link::message::{Command, Record};
use mcap::records::{MessageHeader, Metadata};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// Topic of the ticks.
pub const RECORD_TOPIC: &str = "/armbridge/record";

/// Topic of the commands.
pub const COMMAND_TOPIC: &str = "/armbridge/command";

/// Name of the metadata record with the run's facts.
pub const FACTS_METADATA: &str = "run";

type Output = mcap::Writer<BufWriter<File>>;

/// Writes `run.mcap`.
///
/// The file is readable only after [`finish`](Self::finish).
pub struct McapWriter {
    path: PathBuf,
    writer: Output,
    records: Topic,
    commands: Topic,
    json: Vec<u8>,
}

/// A channel and the number of its next message.
#[derive(Debug)]
struct Topic {
    channel: u16,
    sequence: u32,
}

impl McapWriter {
    /// Creates the file and writes the run's facts.
    ///
    /// # Errors
    /// When the file cannot be created or written.
    pub fn create(path: &Path, facts: &RunFacts) -> Result<Self, LogError> {
        let file = File::create(path).map_err(|source| LogError::Io {
            path: path.to_path_buf(),
            source,
        })?;
        let failed = |source| LogError::Mcap {
            path: path.to_path_buf(),
            source,
        };
        let mut writer = mcap::WriteOptions::new()
            .compression(None)
            .create(BufWriter::with_capacity(1 << 16, file))
            .map_err(failed)?;
        let metadata = Metadata {
            name: FACTS_METADATA.to_owned(),
            metadata: as_strings(facts),
        };
        writer.write_metadata(&metadata).map_err(failed)?;
        let records = Topic::add(&mut writer, RECORD_TOPIC, "armbridge.Tick", TICK_SCHEMA);
        let commands = Topic::add(
            &mut writer,
            COMMAND_TOPIC,
            "armbridge.Command",
            COMMAND_SCHEMA,
        );
        Ok(Self {
            path: path.to_path_buf(),
            records: records.map_err(failed)?,
            commands: commands.map_err(failed)?,
            writer,
            json: Vec::with_capacity(1024),
        })
    }

    /// Appends a tick.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn record(&mut self, record: &Record) -> Result<(), LogError> {
        encode(&mut self.json, &TickMessage::from(record), &self.path)?;
        self.records
            .append(&mut self.writer, record.start_us, &self.json)
            .map_err(|source| LogError::Mcap {
                path: self.path.clone(),
                source,
            })
    }

    /// Appends a command that was sent at this time on the board's clock.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn command(&mut self, time_us: u64, command: &Command) -> Result<(), LogError> {
        encode(&mut self.json, &CommandMessage::from(command), &self.path)?;
        self.commands
            .append(&mut self.writer, time_us, &self.json)
            .map_err(|source| LogError::Mcap {
                path: self.path.clone(),
                source,
            })
    }

    /// Writes the index and closes the file.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn finish(mut self) -> Result<(), LogError> {
        self.writer.finish().map_err(|source| LogError::Mcap {
            path: self.path.clone(),
            source,
        })?;
        let file = self.writer.into_inner();
        // Dropping the buffer would swallow an error of its last write.
        file.into_inner().map(drop).map_err(|e| LogError::Io {
            path: self.path,
            source: e.into_error(),
        })
    }
}

impl std::fmt::Debug for McapWriter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("McapWriter")
            .field("path", &self.path)
            .finish_non_exhaustive()
    }
}

impl Topic {
    fn add(
        writer: &mut Output,
        topic: &str,
        schema_name: &str,
        schema: &str,
    ) -> mcap::McapResult<Self> {
        let schema = writer.add_schema(schema_name, "jsonschema", schema.as_bytes())?;
        let channel = writer.add_channel(schema, topic, "json", &BTreeMap::new())?;
        Ok(Self {
            channel,
            sequence: 0,
        })
    }

    fn append(&mut self, writer: &mut Output, time_us: u64, json: &[u8]) -> mcap::McapResult<()> {
        let time_ns = time_us.saturating_mul(1000);
        let header = MessageHeader {
            channel_id: self.channel,
            sequence: self.sequence,
            log_time: time_ns,
            publish_time: time_ns,
        };
        self.sequence = self.sequence.wrapping_add(1);
        writer.write_to_known_channel(&header, json)
    }
}

/// Puts one message into the buffer, in place of what was there.
fn encode(buffer: &mut Vec<u8>, message: &impl Serialize, path: &Path) -> Result<(), LogError> {
    buffer.clear();
    serde_json::to_writer(buffer, message).map_err(|source| LogError::Json {
        path: path.to_path_buf(),
        source,
    })
}

/// Facts as MCAP metadata wants them: plain strings, the rest as JSON.
fn as_strings(facts: &RunFacts) -> BTreeMap<String, String> {
    // By way of text, so that an f32 is written as short as it is.
    let json = serde_json::to_string(facts).and_then(|text| serde_json::from_str(&text));
    let Ok(serde_json::Value::Object(facts)) = json else {
        return BTreeMap::new();
    };
    let text = |value| match value {
        serde_json::Value::String(text) => text,
        other => other.to_string(),
    };
    facts
        .into_iter()
        .map(|(key, value)| (key, text(value)))
        .collect()
}
