//! Recording of a link, for `--record`: in a file, or in a new folder.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use armbridge_analysis::run_folder::RunFolder;
use armbridge_client::event::Direction;
use armbridge_client::{Tap, stdio};
use armbridge_link::message::Settings;
use armbridge_log::LogError;
use armbridge_log::recorder::{Recorder, RecorderReport};
use armbridge_log::run_info::RunFacts;

use super::Error;

/// A recorder, and the folder that was made for its log.
pub(super) struct Recording {
    recorder: Option<Recorder>,
    folder: Option<RecordingFolder>,
}

/// A new folder for a log, which is removed if the link carries no byte.
struct RecordingFolder {
    path: PathBuf,
    has_bytes: Arc<AtomicBool>,
}

impl Drop for RecordingFolder {
    fn drop(&mut self) {
        if !self.has_bytes.load(Ordering::Relaxed) {
            // Best effort: the log in it has nothing of the link.
            let _ = std::fs::remove_dir_all(&self.path);
        }
    }
}

/// Tap that notices the first byte.
struct FirstByte(Arc<AtomicBool>);

impl Tap for FirstByte {
    fn bytes(&mut self, _: Direction, _: u64, _: &[u8]) {
        self.0.store(true, Ordering::Relaxed);
    }

    fn disconnected(&mut self, _: u64) {}
}

impl Recording {
    /// Begins the log with this path, or one in a new folder under it.
    pub(super) fn begin(path: &Path, name: &str, world: &str) -> Result<Self, Error> {
        // Until the board reports its own, which go into the log too.
        let facts = RunFacts::from_settings(name, world, &Settings::default());
        if path
            .extension()
            .is_some_and(|extension| extension == "mcap")
        {
            return Ok(Self {
                recorder: Some(Recorder::create(path, &facts)?),
                folder: None,
            });
        }
        let folder = RunFolder::create(Some(path), name)?;
        // Dropped after an error.
        let kept = RecordingFolder {
            path: folder.path().into(),
            has_bytes: Arc::default(),
        };
        let recorder = Recorder::create(&folder.file("run.mcap"), &facts)?;
        stdio::note(format_args!("recording in {}", folder.path().display()));
        Ok(Self {
            recorder: Some(recorder),
            folder: Some(kept),
        })
    }

    /// Taps of the link.
    pub(super) fn taps(&self) -> Vec<Box<dyn Tap>> {
        let mut taps: Vec<Box<dyn Tap>> = Vec::new();
        taps.extend(self.recorder.as_ref().map(Recorder::tap));
        if let Some(folder) = &self.folder {
            taps.push(Box::new(FirstByte(Arc::clone(&folder.has_bytes))));
        }
        taps
    }

    /// Closes the log.
    pub(super) fn finish(mut self) -> Result<RecorderReport, LogError> {
        let report = self.recorder.take().map(Recorder::finish).transpose()?;
        Ok(report.unwrap_or_default())
    }
}
