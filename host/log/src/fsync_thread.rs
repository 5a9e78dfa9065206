//! Thread that syncs a file to the disk.
//!
//! A disk takes seconds to make a file survive a power cut when it is
//! busy. The log's writer must not wait for it meanwhile: the data that it would hold
//! back would be lost when the program is killed.

use std::io;
use std::sync::mpsc::{SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;

/// Returns when the written data survives a power cut.
pub(super) type SyncFn = Box<dyn FnMut() -> io::Result<()> + Send>;

/// Handle of the thread.
pub(super) struct Syncer {
    requests: SyncSender<()>,
    thread: Option<JoinHandle<io::Result<()>>>,
}

impl Syncer {
    pub(super) fn start(mut sync: SyncFn) -> io::Result<Self> {
        // At most one request waits: it stands for all data written before it.
        let (requests, received) = sync_channel(1);
        let thread = std::thread::Builder::new()
            .name("recorder-sync".into())
            .spawn(move || {
                received.iter().try_for_each(|()| sync())?;
                sync()
            })?;
        Ok(Self {
            requests,
            thread: Some(thread),
        })
    }

    /// Requests a sync, without waiting for it.
    ///
    /// # Errors
    /// That of an earlier sync.
    pub(super) fn ask(&mut self) -> io::Result<()> {
        match self.requests.try_send(()) {
            Ok(()) | Err(TrySendError::Full(())) => Ok(()),
            Err(TrySendError::Disconnected(())) => join(&mut self.thread),
        }
    }

    /// Syncs for the last time, and waits for it.
    ///
    /// # Errors
    /// That of any sync.
    pub(super) fn finish(self) -> io::Result<()> {
        let Self {
            requests,
            mut thread,
        } = self;
        drop(requests);
        join(&mut thread)
    }
}

/// It does not panic, and each error is reported once.
fn join(thread: &mut Option<JoinHandle<io::Result<()>>>) -> io::Result<()> {
    match thread.take().map(JoinHandle::join) {
        Some(Ok(done)) => done,
        Some(Err(_)) | None => Ok(()),
    }
}
