//! Thread of a recorder: takes bytes from the queue, decodes them, and writes bytes and
//! messages.

use std::io;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use armbridge_client::event::{Event, EventKind, LinkDecoder};
use armbridge_client::simulation::SimulationEvent;
use armbridge_link::message::{BoardReport, Settings, ToHost};
use mcap::{McapError, McapResult};

use super::mcap_file::LogFile;
use super::message_encoder::Encoder;
use super::queue::{Drained, Queue};
use super::replay::LiveReplay;
use super::{metadata, raw_link_bytes};
use crate::run_info::RunFacts;

/// Longest wall time between two chunks: data that is lost when the program is killed.
const FLUSH: Duration = Duration::from_millis(200);

/// Wall time after which a sync to the disk is requested: data that is lost in a power
/// cut, apart from the disk's delay.
const SYNC: Duration = Duration::from_millis(500);

/// Bytes of the link at which a chunk is closed early.
const RAW_CHUNK_MAX: usize = 1 << 20;

/// Report of a recorder.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecorderReport {
    /// Records written.
    pub records: u64,
    /// Ticks without a record, by their numbers; those while the link was
    /// broken are not counted.
    pub lost: u64,
    /// Bytes of the link that were not written, because the disk is too slow or full.
    pub unwritten: u64,
    /// Size of the file in bytes.
    pub size: u64,
    /// First error, in one sentence with its remedy.
    pub trouble: Option<String>,
}

/// State that a recorder shares with its thread.
#[derive(Debug, Default)]
pub(super) struct Shared {
    state: Mutex<State>,
}

/// Progress of the writer.
#[derive(Clone, Debug, Default)]
pub(super) struct State {
    pub(super) report: RecorderReport,
    /// The file ends before the run.
    pub(super) is_truncated: bool,
}

impl Shared {
    /// Locks the state; no code panics with the lock held.
    pub(super) fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Writer of a log.
pub(super) struct LogWriter {
    file: Option<LogFile>,
    /// As last reported, until they are recorded.
    settings: Option<Settings>,
    has_settings: bool,
    board: Option<BoardReport>,
    queue: Arc<Queue>,
    shared: Arc<Shared>,
    decoder: LinkDecoder,
    encoder: Encoder,
    replay: LiveReplay,
    raw: Vec<u8>,
    latest_ns: u64,
    /// Received and missing ticks, in the flushed data.
    flushed_ticks: (u64, u64),
    flushed: Instant,
    synced: Instant,
}

impl LogWriter {
    /// Writes the metadata known at the start.
    pub(super) fn new(
        mut file: LogFile,
        facts: &RunFacts,
        queue: Arc<Queue>,
        shared: Arc<Shared>,
    ) -> McapResult<Self> {
        file.metadata(&metadata::build())?;
        file.metadata(&metadata::run(facts))?;
        file.flush()?;
        file.sync()?;
        Ok(Self {
            file: Some(file),
            settings: None,
            has_settings: false,
            board: None,
            queue,
            shared,
            decoder: LinkDecoder::default(),
            encoder: Encoder::default(),
            replay: LiveReplay::default(),
            raw: Vec::new(),
            latest_ns: 0,
            flushed_ticks: (0, 0),
            flushed: Instant::now(),
            synced: Instant::now(),
        })
    }

    /// Writes until the queue is closed and empty.
    pub(super) fn run(mut self) {
        let (mut framed, mut simulation) = (Vec::new(), Vec::new());
        loop {
            let until = self.flushed + FLUSH;
            let drained = self.queue.take(&mut framed, &mut simulation, until);
            if let Some(mut file) = self.file.take() {
                match self.write(&mut file, &framed, &simulation, drained) {
                    Ok(()) => self.file = Some(file),
                    Err(error) => self.abort(&error, file.size()),
                }
            } else {
                self.shared.lock().report.unwritten += raw_link_bytes::bytes(&framed);
                self.flushed = Instant::now();
            }
            self.update_report(drained);
            if drained.is_last {
                break;
            }
        }
        if let Some(file) = self.file.take() {
            let size = file.size();
            if let Err(error) = self.finish(file) {
                self.abort(&error, size);
            }
        }
    }

    fn write(
        &mut self,
        file: &mut LogFile,
        framed: &[u8],
        simulation: &[SimulationEvent],
        drained: Drained,
    ) -> McapResult<()> {
        for event in simulation {
            self.encoder
                .simulated(event, &mut |message| file.message(message))?;
        }
        self.raw.extend_from_slice(framed);
        for piece in raw_link_bytes::pieces(framed).flatten() {
            self.latest_ns = self.latest_ns.max(piece.host_ns);
            if let raw_link_bytes::PieceKind::Bytes(direction) = piece.kind {
                self.encoder.count_bytes(direction, piece.bytes.len());
            }
            let mut decoder = std::mem::take(&mut self.decoder);
            let mut done = Ok(());
            raw_link_bytes::decode(&mut decoder, piece, |event| {
                if done.is_ok() {
                    done = self.write_event(file, &event);
                }
            });
            self.decoder = decoder;
            done?;
        }
        let queue = [
            framed.len() as u64,
            drained.peak_bytes as u64,
            drained.unwritten,
        ];
        self.encoder
            .queue(self.latest_ns, queue, &mut |message| file.message(message))?;
        let is_due = self.flushed.elapsed() >= FLUSH;
        if is_due || self.raw.len() >= RAW_CHUNK_MAX {
            self.flush(file)?;
        }
        if self.synced.elapsed() >= SYNC {
            file.sync()?;
            self.synced = Instant::now();
        }
        Ok(())
    }

    fn write_event(&mut self, file: &mut LogFile, event: &Event) -> McapResult<()> {
        self.encoder
            .event(event, &mut |message| file.message(message))?;
        if let Some(state) = self.replay.take(event) {
            self.flush(file)?;
            file.attach_snapshot(event.host_ns, &state)?;
        }
        match event.kind {
            EventKind::Received(_, ToHost::Board(report)) if self.board != Some(report) => {
                self.board = Some(report);
                file.metadata(&metadata::board(&report))
            }
            EventKind::Received(_, ToHost::Settings(settings)) if !self.has_settings => {
                self.settings = Some(settings);
                Ok(())
            }
            EventKind::Received(_, ToHost::Record(record)) if record.mode.drive().is_some() => {
                self.record_settings(file)
            }
            EventKind::Sent(..)
            | EventKind::Received(..)
            | EventKind::Lost(..)
            | EventKind::Damaged(..)
            | EventKind::Disconnected => Ok(()),
        }
    }

    /// Records the settings in force, once.
    fn record_settings(&mut self, file: &mut LogFile) -> McapResult<()> {
        let Some(settings) = self.settings.take() else {
            return Ok(());
        };
        self.has_settings = true;
        file.metadata(&metadata::parameters(&settings))
    }

    /// Closes the chunk, and writes the raw bytes of its contents.
    fn flush(&mut self, file: &mut LogFile) -> McapResult<()> {
        if !self.raw.is_empty() {
            file.attach_raw(self.latest_ns, &self.raw)?;
            self.raw.clear();
        }
        file.flush()?;
        self.flushed_ticks = self.encoder.ticks();
        self.flushed = Instant::now();
        Ok(())
    }

    fn finish(&mut self, mut file: LogFile) -> McapResult<()> {
        self.encoder
            .statistics(self.latest_ns, &mut |message| file.message(message))?;
        self.flush(&mut file)?;
        self.record_settings(&mut file)?;
        if let Some(line) = self.encoder.clock() {
            file.metadata(&metadata::clock(&line))?;
        }
        file.metadata(&metadata::end(self.encoder.ticks(), self.queue.unwritten()))?;
        let size = file.finish()?;
        self.shared.lock().report.size = size;
        Ok(())
    }

    /// Ends the file after an error; the queue is still emptied, so that the link is not
    /// blocked.
    fn abort(&mut self, error: &McapError, size: u64) {
        let mut shared = self.shared.lock();
        shared.is_truncated = true;
        (shared.report.records, shared.report.lost) = self.flushed_ticks;
        shared.report.size = size;
        shared.report.unwritten += raw_link_bytes::bytes(&self.raw);
        let last = match self.flushed_ticks.0 {
            0 => "before its first tick".into(),
            count => format!("after {count} ticks"),
        };
        shared.report.trouble = Some(match error {
            McapError::Io(error) => format!("{}; the log ends {last}", io_error_text(error)),
            other => format!("cannot write the log: {other}; it ends {last}"),
        });
    }

    fn update_report(&self, drained: Drained) {
        let mut shared = self.shared.lock();
        let report = &mut shared.report;
        if let Some(file) = &self.file {
            (report.records, report.lost) = self.encoder.ticks();
            report.size = file.size();
        }
        if drained.unwritten > 0 && report.trouble.is_none() {
            report.trouble = Some(
                "the disk is too slow: not all of the link is in the log; \
                 write it to a faster disk"
                    .into(),
            );
        }
    }
}

/// Error of a file, and its remedy.
fn io_error_text(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::StorageFull => "the disk is full: make room, or log to another".into(),
        io::ErrorKind::QuotaExceeded => {
            "your share of the disk is used up: make room, or log to another".into()
        }
        io::ErrorKind::FileTooLarge => {
            "the file may not grow further (ulimit -f): raise the limit, or log to another disk"
                .into()
        }
        _ => format!("cannot write the log: {error}: is its disk still there?"),
    }
}
