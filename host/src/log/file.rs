//! The MCAP file of a log: a writer that leaves, at any instant, a file that can be
//! read up to what was flushed last.
//!
//! Chunks are written whole, with their index behind them, and nothing that was
//! written is touched again: whoever is killed leaves a file without its last half
//! second and without a summary, which every reader can do without.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};

use mcap::records::{AttachmentHeader, MessageHeader, Metadata};
use mcap::{McapError, McapResult};

use super::raw;
use super::topics::{Message, Topic};

/// A chunk that is not flushed before is closed at this size.
const CHUNK: u64 = 1 << 20;

/// Where a log is written to.
pub(super) trait Disk: Write + Send {
    /// Does not return before what was written survives a power cut.
    fn sync(&mut self) -> io::Result<()>;
}

impl Disk for File {
    fn sync(&mut self) -> io::Result<()> {
        match self.sync_data() {
            // What is no file, such as a pipe, cannot.
            Err(error) if error.kind() == io::ErrorKind::InvalidInput => Ok(()),
            done => done,
        }
    }
}

/// A disk, written from its beginning to its end; knows how far it has come.
struct Sink {
    disk: BufWriter<Box<dyn Disk>>,
    /// Shared with the file's owner, who cannot look into the library's writer.
    control: Arc<Control>,
}

/// What goes between a file and its sink.
#[derive(Debug, Default)]
struct Control {
    position: AtomicU64,
    shall_sync: AtomicBool,
}

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.disk.write(bytes)?;
        self.control.position.fetch_add(written as u64, Relaxed);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.disk.flush()?;
        if self.control.shall_sync.swap(false, Relaxed) {
            self.disk.get_mut().sync()?;
        }
        Ok(())
    }
}

impl Seek for Sink {
    /// The library asks where it is; it does not go anywhere.
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match to {
            SeekFrom::Current(0) => Ok(self.control.position.load(Relaxed)),
            SeekFrom::Current(_) | SeekFrom::Start(_) | SeekFrom::End(_) => {
                Err(io::ErrorKind::Unsupported.into())
            }
        }
    }
}

/// A log's file.
pub(super) struct LogFile {
    writer: mcap::Writer<Sink>,
    channels: BTreeMap<u16, Channel>,
    control: Arc<Control>,
    attachments: u32,
}

struct Channel {
    id: u16,
    sequence: u32,
}

impl LogFile {
    /// Begins the file: all topics are in it from the first byte on.
    pub(super) fn begin(disk: Box<dyn Disk>) -> McapResult<Self> {
        let control = Arc::new(Control::default());
        let sink = Sink {
            disk: BufWriter::with_capacity(1 << 16, disk),
            control: control.clone(),
        };
        let mut writer = mcap::WriteOptions::new()
            .compression(None)
            .chunk_size(Some(CHUNK))
            // Chunks are put together in memory: a chunk in the making is no chunk.
            .disable_seeking(true)
            .library(concat!("armbridge ", env!("CARGO_PKG_VERSION")))
            .create(sink)?;
        let mut channels = BTreeMap::new();
        for topic in Topic::ALL {
            let schema = writer.add_schema(topic.schema_name(), "protobuf", &topic.schema())?;
            let id = writer.add_channel(schema, topic.name(), "protobuf", &BTreeMap::new())?;
            channels.insert(topic as u16, Channel { id, sequence: 0 });
        }
        writer.flush()?;
        Ok(Self {
            writer,
            channels,
            control,
            attachments: 0,
        })
    }

    /// Appends a message.
    pub(super) fn message(&mut self, message: Message<'_>) -> McapResult<()> {
        let Some(channel) = self.channels.get_mut(&(message.topic as u16)) else {
            return Ok(());
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
    pub(super) fn attach(&mut self, at_ns: u64, framed: &[u8]) -> McapResult<()> {
        self.attachments += 1;
        let header = AttachmentHeader {
            log_time: at_ns,
            create_time: at_ns,
            name: format!("link-{:06}.bin", self.attachments),
            media_type: raw::MEDIA_TYPE.into(),
        };
        self.writer.start_attachment(framed.len() as u64, header)?;
        self.writer.put_attachment_bytes(framed)?;
        self.writer.finish_attachment()
    }

    /// Closes the chunk; it survives whatever happens to this program, and, if asked
    /// for, a power cut.
    pub(super) fn flush(&mut self, shall_sync: bool) -> McapResult<()> {
        self.control.shall_sync.store(shall_sync, Relaxed);
        self.writer.flush()
    }

    /// Bytes so far.
    pub(super) fn size(&self) -> u64 {
        self.control.position.load(Relaxed)
    }

    /// Writes the summary, and all to the disk; how long the file is.
    pub(super) fn finish(mut self) -> McapResult<u64> {
        self.writer.finish()?;
        let mut sink = self.writer.into_inner();
        self.control.shall_sync.store(true, Relaxed);
        sink.flush().map_err(McapError::Io)?;
        Ok(self.control.position.load(Relaxed))
    }
}
