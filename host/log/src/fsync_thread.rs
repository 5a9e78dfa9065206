//! Has a disk keep what was written, on a thread of its own.
//!
//! A disk takes as long as it likes to make a file survive a power cut, seconds on
//! a busy one. Whoever writes the log must not wait for it meanwhile: what it would
//! hold back then is what a kill takes.

use std::io;
use std::sync::mpsc::{SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;

/// Does not return before what was written survives a power cut.
pub(super) type SyncFn = Box<dyn FnMut() -> io::Result<()> + Send>;

/// Whoever syncs.
pub(super) struct Syncer {
    wishes: SyncSender<()>,
    thread: Option<JoinHandle<io::Result<()>>>,
}

impl Syncer {
    pub(super) fn start(mut sync: SyncFn) -> io::Result<Self> {
        // One wish waits at most: it stands for all that was written before it.
        let (wishes, heard) = sync_channel(1);
        let thread = std::thread::Builder::new()
            .name("recorder-sync".into())
            .spawn(move || {
                heard.iter().try_for_each(|()| sync())?;
                sync()
            })?;
        Ok(Self {
            wishes,
            thread: Some(thread),
        })
    }

    /// Asks for it, and does not wait.
    ///
    /// # Errors
    /// Those of a sync before this one.
    pub(super) fn ask(&mut self) -> io::Result<()> {
        match self.wishes.try_send(()) {
            Ok(()) | Err(TrySendError::Full(())) => Ok(()),
            Err(TrySendError::Disconnected(())) => join(&mut self.thread),
        }
    }

    /// Syncs a last time, and waits for it.
    ///
    /// # Errors
    /// Those of any sync.
    pub(super) fn finish(self) -> io::Result<()> {
        let Self { wishes, mut thread } = self;
        drop(wishes);
        join(&mut thread)
    }
}

/// It does not panic, and what it said is heard once.
fn join(thread: &mut Option<JoinHandle<io::Result<()>>>) -> io::Result<()> {
    match thread.take().map(JoinHandle::join) {
        Some(Ok(done)) => done,
        Some(Err(_)) | None => Ok(()),
    }
}
