//! Thread that syncs a file to the disk.
//!
//! A sync takes seconds on a busy disk. The log's writer must not wait for it: data that
//! is buffered meanwhile would be lost when the program is killed.

use std::io;
use std::sync::mpsc::{SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;

/// Syncs the written data; it survives a power cut afterwards.
pub(super) type SyncFn = Box<dyn FnMut() -> io::Result<()> + Send>;

/// Handle of the thread.
pub(super) struct Syncer {
    requests: SyncSender<()>,
    thread: Option<JoinHandle<io::Result<()>>>,
}

impl Syncer {
    pub(super) fn start(mut sync: SyncFn) -> io::Result<Self> {
        // At most one request is queued: it covers all data written before it.
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
    pub(super) fn request(&mut self) -> io::Result<()> {
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

/// Joins the thread, which does not panic; each error is reported once.
fn join(thread: &mut Option<JoinHandle<io::Result<()>>>) -> io::Result<()> {
    match thread.take().map(JoinHandle::join) {
        Some(Ok(done)) => done,
        Some(Err(_)) | None => Ok(()),
    }
}
