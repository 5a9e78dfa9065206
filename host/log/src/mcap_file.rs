//! MCAP file of a log, which is readable up to the last flush at any time.
//!
//! Chunks are written as a whole, followed by their index, and written data is never
//! changed: a killed program leaves a file without its last chunk and without a summary,
//! which readers do not need.

use std::collections::BTreeMap;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::sync::Arc;
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering::Relaxed;

use mcap::McapResult;
use mcap::records::{AttachmentHeader, MessageHeader, Metadata};

use super::fsync_thread::{SyncFn, Syncer};
use super::message_encoder::Message;
use super::topics::Topic;
use super::{raw_link_bytes, snapshots};

/// Size at which a chunk is closed, unless it was flushed before.
const CHUNK: u64 = 1 << 20;

/// Sequential writer of a file, which counts its bytes.
struct Sink {
    disk: BufWriter<Box<dyn Write + Send>>,
    /// Shared with the file's owner, who has no access to the library's writer.
    position: Arc<AtomicU64>,
}

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.disk.write(bytes)?;
        self.position.fetch_add(written as u64, Relaxed);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.disk.flush()
    }
}

impl Seek for Sink {
    /// The library only queries the position.
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match to {
            SeekFrom::Current(0) => Ok(self.position.load(Relaxed)),
            SeekFrom::Current(_) | SeekFrom::Start(_) | SeekFrom::End(_) => {
                Err(io::ErrorKind::Unsupported.into())
            }
        }
    }
}

/// File of a log.
pub(super) struct LogFile {
    writer: mcap::Writer<Sink>,
    channels: [Option<Channel>; Topic::ALL.len()],
    position: Arc<AtomicU64>,
    syncer: Syncer,
    attachments: u32,
}

#[derive(Clone, Copy)]
struct Channel {
    id: u16,
    sequence: u32,
}

fn add_channel(writer: &mut mcap::Writer<Sink>, topic: Topic) -> McapResult<Channel> {
    let schema = writer.add_schema(topic.schema_name(), "protobuf", topic.schema())?;
    let id = writer.add_channel(schema, topic.name(), "protobuf", &BTreeMap::new())?;
    Ok(Channel { id, sequence: 0 })
}

impl LogFile {
    /// Begins the file, with all topics of a link at its start; those of a simulation begin
    /// with their first message.
    pub(super) fn begin(disk: Box<dyn Write + Send>, sync: SyncFn) -> McapResult<Self> {
        let position = Arc::default();
        let sink = Sink {
            disk: BufWriter::with_capacity(1 << 16, disk),
            position: Arc::clone(&position),
        };
        let mut writer = mcap::WriteOptions::new()
            .compression(None)
            .chunk_size(Some(CHUNK))
            // Chunks are assembled in memory: a partial chunk is not readable.
            .disable_seeking(true)
            .library(concat!("armbridge ", env!("CARGO_PKG_VERSION")))
            .create(sink)?;
        let mut channels = [None; Topic::ALL.len()];
        for topic in Topic::ALL
            .into_iter()
            .filter(|topic| !topic.is_simulation())
        {
            channels[topic as usize] = Some(add_channel(&mut writer, topic)?);
        }
        writer.flush()?;
        Ok(Self {
            writer,
            channels,
            position,
            syncer: Syncer::start(sync)?,
            attachments: 0,
        })
    }

    /// Appends a message.
    pub(super) fn message(&mut self, message: Message<'_>) -> McapResult<()> {
        let channel = match &mut self.channels[message.topic as usize] {
            Some(channel) => channel,
            absent => absent.insert(add_channel(&mut self.writer, message.topic)?),
        };
        let header = MessageHeader {
            channel_id: channel.id,
            sequence: channel.sequence,
            log_time: message.log_time_ns,
            publish_time: message.log_time_ns,
        };
        channel.sequence = channel.sequence.wrapping_add(1);
        self.writer.write_to_known_channel(&header, message.bytes)
    }

    pub(super) fn metadata(&mut self, metadata: &Metadata) -> McapResult<()> {
        self.writer.write_metadata(metadata)
    }

    /// Appends bytes of the link, as an attachment.
    pub(super) fn attach_raw(&mut self, at_ns: u64, framed: &[u8]) -> McapResult<()> {
        self.attachments += 1;
        let name = format!("link-{:06}.bin", self.attachments);
        self.attach(at_ns, name, raw_link_bytes::MEDIA_TYPE, framed)
    }

    /// Appends the state of a replay up to here, as an attachment.
    pub(super) fn attach_snapshot(&mut self, at_ns: u64, state: &[u8]) -> McapResult<()> {
        let (name, media_type) = (snapshots::NAME, snapshots::MEDIA_TYPE);
        self.attach(at_ns, name.into(), media_type, state)
    }

    fn attach(
        &mut self,
        at_ns: u64,
        name: String,
        media_type: &str,
        bytes: &[u8],
    ) -> McapResult<()> {
        let header = AttachmentHeader {
            log_time: at_ns,
            create_time: at_ns,
            name,
            media_type: media_type.into(),
        };
        self.writer.start_attachment(bytes.len() as u64, header)?;
        self.writer.put_attachment_bytes(bytes)?;
        self.writer.finish_attachment()
    }

    /// Closes the chunk: it survives the end of this program.
    pub(super) fn flush(&mut self) -> McapResult<()> {
        self.writer.flush()
    }

    /// Requests that the flushed data is synced, so that it survives a power cut.
    pub(super) fn sync(&mut self) -> McapResult<()> {
        Ok(self.syncer.request()?)
    }

    /// Bytes written so far.
    pub(super) fn size(&self) -> u64 {
        self.position.load(Relaxed)
    }

    /// Writes the summary, and syncs the file; returns its length.
    pub(super) fn finish(mut self) -> McapResult<u64> {
        self.writer.finish()?;
        self.writer.into_inner().flush()?;
        self.syncer.finish()?;
        Ok(self.position.load(Relaxed))
    }
}
