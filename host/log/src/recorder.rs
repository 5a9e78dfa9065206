//! Recorder: writes a log during a run, as MCAP, off the link's thread.
//!
//! ```text
//! link --bytes--> tap --copies--> queue --> thread: decoder, topics --> file
//! ```
//!
//! The recorder takes the raw bytes of both directions. At least
//! every 0.2 s it closes a chunk and writes the raw bytes as an attachment; both survive
//! the end of the program. Each half second it requests a sync to the disk, after which
//! they survive a power cut, and does not wait for it. When the disk is full or fails,
//! the report has the error, and the link continues.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::JoinHandle;

use armbridge_client::Tap;

use super::fsync_thread::SyncFn;
use super::mcap_file::LogFile;
use super::queue::{self, Queue, QueueTap};
pub use super::writer_thread::RecorderReport;
use super::writer_thread::{LogWriter, Shared};
use super::{LogError, output_file};
use crate::run_info::RunFacts;

/// Recorder of a log. Dropping it closes the log like [`finish`](Self::finish),
/// but ignores errors.
#[derive(Debug)]
pub struct Recorder {
    path: PathBuf,
    queue: Arc<Queue>,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl Recorder {
    /// Creates the file, which must not exist, and the thread that writes it. Never blocks the
    /// link: bytes that do not fit into the queue are counted.
    ///
    /// # Errors
    /// When the file cannot be created or written.
    pub fn create(path: &Path, facts: &RunFacts) -> Result<Self, LogError> {
        Self::on_file(path, facts, false)
    }

    /// The same for a board in virtual time, which waits for the disk if necessary:
    /// nothing is lost.
    ///
    /// # Errors
    /// When the file cannot be created or written.
    pub fn create_waiting(path: &Path, facts: &RunFacts) -> Result<Self, LogError> {
        Self::on_file(path, facts, true)
    }

    fn on_file(path: &Path, facts: &RunFacts, blocks_when_full: bool) -> Result<Self, LogError> {
        let failed = |source| LogError::Io {
            path: path.to_path_buf(),
            source,
        };
        let file = output_file::create_log(path).map_err(failed)?;
        // The directory entry must survive a power cut too. Some systems have no folders that
        // can be synced; then this is skipped.
        if let Some(Ok(folder)) = path.parent().map(std::fs::File::open) {
            let _ = folder.sync_all();
        }
        let second = file.try_clone().map_err(failed)?;
        let is_file = file.metadata().is_ok_and(|it| it.is_file());
        let sync = move || match second.sync_data() {
            // A pipe, for example, cannot be synced.
            Err(error) if error.kind() == io::ErrorKind::InvalidInput => Ok(()),
            done => done,
        };
        let queue = Queue::new(blocks_when_full, queue::CAPACITY);
        let begun = Self::on_disk(path, Box::new(file), Box::new(sync), facts, queue);
        if begun.is_err() && is_file {
            // An empty log is not kept.
            let _ = std::fs::remove_file(path);
        }
        begun
    }

    pub(super) fn on_disk(
        path: &Path,
        disk: Box<dyn Write + Send>,
        sync: SyncFn,
        facts: &RunFacts,
        queue: Arc<Queue>,
    ) -> Result<Self, LogError> {
        let failed = |error| {
            let path = path.to_path_buf();
            match error {
                mcap::McapError::Io(source) => LogError::Io { path, source },
                source => LogError::Mcap { path, source },
            }
        };
        let file = LogFile::begin(disk, sync).map_err(failed)?;
        let shared = Arc::default();
        let writer =
            LogWriter::new(file, facts, Arc::clone(&queue), Arc::clone(&shared)).map_err(failed)?;
        let thread = std::thread::Builder::new()
            .name("recorder".into())
            .spawn(move || writer.run())
            .map_err(|source| LogError::Io {
                path: path.to_path_buf(),
                source,
            })?;
        Ok(Self {
            path: path.to_path_buf(),
            queue,
            shared,
            thread: Some(thread),
        })
    }

    /// Path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Tap of the link.
    pub fn tap(&self) -> Box<dyn Tap> {
        Box::new(QueueTap(Arc::clone(&self.queue)))
    }

    /// Report so far.
    pub fn report(&self) -> RecorderReport {
        let report = self.shared.lock().report.clone();
        RecorderReport {
            unwritten: self.queue.unwritten() + report.unwritten,
            trouble: report
                .trouble
                .map(|trouble| format!("{trouble} ({})", self.path.display())),
            ..report
        }
    }

    /// Writes the queued bytes, and closes the file.
    ///
    /// # Errors
    /// When the file could not be written completely.
    pub fn finish(mut self) -> Result<RecorderReport, LogError> {
        self.join();
        let report = self.report();
        let is_truncated = self.shared.lock().is_truncated;
        match &report.trouble {
            Some(trouble) if is_truncated => Err(LogError::Truncated(trouble.clone())),
            Some(_) | None => Ok(report),
        }
    }

    fn join(&mut self) {
        self.queue.close();
        if let Some(thread) = self.thread.take() {
            // It does not panic; if it did, the report would be the latest one.
            let _ = thread.join();
        }
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        self.join();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Recording;
    use armbridge_client::event::Direction;
    use armbridge_link::frame::Encoder;
    use armbridge_link::message::{Settings, ToHost};
    use std::sync::Mutex;

    /// A disk that blocks while it is held, and has this much room.
    struct Poor {
        file: std::fs::File,
        room: usize,
        hold: Arc<Mutex<()>>,
    }

    impl Write for Poor {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            drop(self.hold.lock().unwrap());
            let len = bytes.len().min(self.room);
            if len == 0 {
                return Err(io::ErrorKind::StorageFull.into());
            }
            self.room -= len;
            self.file.write(&bytes[..len])
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    /// Records a minute of frames, as fast as possible, on such a disk, which is held
    /// until all were sent, or not at all.
    fn record(name: &str, room: usize, is_held: bool, queue: Arc<Queue>) -> (PathBuf, Recorder) {
        let path = std::env::temp_dir().join(format!("armbridge-{}-{name}", std::process::id()));
        let file = std::fs::File::create(&path).unwrap();
        let facts = RunFacts::from_settings("test", "simulated: nothing", &Settings::default());
        let hold = Arc::new(Mutex::new(()));
        let disk = Box::new(Poor {
            file,
            room,
            hold: Arc::clone(&hold),
        });
        let held_too = Arc::clone(&hold);
        let sync = Box::new(move || {
            drop(held_too.lock().unwrap());
            Ok(())
        });
        let recorder = Recorder::on_disk(&path, disk, sync, &facts, queue).unwrap();
        let (mut tap, mut board) = (recorder.tap(), Encoder::default());
        let held = is_held.then(|| hold.lock().unwrap());
        let mut say = |tick: u64| {
            let frame = board.encode(&ToHost::Temperature { joint: 0, value: 1 }).1;
            tap.bytes(Direction::ToHost, tick * 1_000_000, frame);
            recorder.report().unwritten
        };
        for tick in 0..60_000 {
            say(tick);
        }
        drop(held);
        // A repeated frame number shows that others are missing.
        let mut unwritten = say(60_000);
        for tick in 60_001.. {
            let before = std::mem::replace(&mut unwritten, say(tick));
            if unwritten == before {
                break;
            }
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        (path, recorder)
    }

    #[test]
    fn a_full_disk_is_reported_and_written_data_can_be_read() {
        let (path, recorder) = record("full", 3_000_000, false, Queue::new(true, 1 << 20));
        let error = recorder.finish().unwrap_err().to_string();
        assert!(error.contains("the disk is full: make room"), "{error}");
        assert!(error.contains("-full)"), "{error}");
        let recording = Recording::load(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        assert!(recording.events.len() > 1_000, "{}", recording.events.len());
        assert_eq!(recording.damage.len(), 1, "{:?}", recording.damage);
    }

    #[test]
    fn a_slow_disk_does_not_block_the_link_and_is_reported() {
        // Waiting for it would never end.
        let (path, recorder) = record("slow", usize::MAX, true, Queue::new(false, 200_000));
        let report = recorder.finish().unwrap();
        let trouble = report.trouble.unwrap();
        assert!(trouble.contains("the disk is too slow"), "{trouble}");
        assert!(report.unwritten > 100_000, "{}", report.unwritten);
        let recording = Recording::load(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        assert_eq!(recording.damage, [""; 0]);
        let lost = recording.events.iter().any(|event| {
            matches!(
                event.kind,
                armbridge_client::event::EventKind::Lost(Direction::ToHost, _)
            )
        });
        assert!(lost, "frames that were not written are not missed");
    }
}
