//! A session with a board, and its log, shared by the objects of Python that use it.

use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use armbridge_link::message::{Command, Settings};
use armbridge_log::recorder::Recorder;
use armbridge_log::run_info::RunFacts;
use armbridge_sim::link::{BoardClient, BoardUri, ClientError, Options};
use pyo3::prelude::*;

use crate::errors::{ClosedError, from_client, log_error};

/// Connections that are open, to be closed when the interpreter ends.
static OPEN: Mutex<Vec<Weak<Connection>>> = Mutex::new(Vec::new());

/// A session with a board, shared by the objects that use it.
pub(crate) struct Connection {
    link: String,
    client: Mutex<Option<Arc<BoardClient>>>,
    recorder: Mutex<Option<Recorder>>,
    /// The exception of a signal that interrupted a call.
    raised: Arc<Mutex<Option<PyErr>>>,
    /// The process that has the link's thread.
    process: u32,
}

impl Connection {
    /// Opens a link with these options, whose log has this path.
    pub(crate) fn open(
        py: Python<'_>,
        uri: BoardUri,
        options: impl FnOnce() -> Options + Send + 'static,
        log: Option<&Path>,
    ) -> PyResult<Arc<Self>> {
        let link = uri.to_string();
        let facts = RunFacts::from_settings("python", &uri.world(), &Settings::default());
        let recorder = log.map(|path| Recorder::create(path, &facts)).transpose();
        let mut recorder = recorder.map_err(log_error)?;
        let tap = recorder.as_ref().map(Recorder::tap);
        let options = move || {
            let mut options = options();
            options.link.taps.extend(tap);
            options
        };
        let raised = Arc::<Mutex<Option<PyErr>>>::default();
        #[expect(
            clippy::redundant_closure_for_method_calls,
            reason = "its lifetime is not general"
        )]
        let is_interrupted = {
            let raised = Arc::clone(&raised);
            move || match Python::attach(|py| py.check_signals()) {
                Ok(()) => false,
                Err(error) => {
                    *lock(&raised) = Some(error);
                    true
                }
            }
        };
        let opened = py.detach(|| BoardClient::open(uri, options, is_interrupted));
        let client = opened.map_err(|error| {
            if let (Some(recorder), Some(path)) = (recorder.take(), log) {
                drop(recorder);
                // Best effort: the log has nothing of a board.
                let _ = std::fs::remove_file(path);
            }
            raised_error(&raised, &error)
        })?;
        let connection = Arc::new(Self {
            link,
            client: Mutex::new(Some(Arc::new(client))),
            recorder: Mutex::new(recorder),
            raised,
            process: std::process::id(),
        });
        let mut open = lock(&OPEN);
        open.retain(|it| it.strong_count() > 0);
        open.push(Arc::downgrade(&connection));
        Ok(connection)
    }

    /// Name of the link, and whether it is closed.
    pub(crate) fn text(&self) -> String {
        let end = if lock(&self.client).is_some() {
            ""
        } else {
            ", closed"
        };
        format!("{}{end}", self.link)
    }

    /// The client.
    pub(crate) fn client(&self) -> PyResult<Arc<BoardClient>> {
        if std::process::id() != self.process {
            return Err(ClosedError::new_err(format!(
                "{} belongs to the parent of this process; connect in the child, too",
                self.link
            )));
        }
        let client = lock(&self.client).clone();
        client.ok_or_else(|| ClosedError::new_err(format!("{} is closed", self.link)))
    }

    /// Makes a call, without the interpreter's lock.
    pub(crate) fn call<T: Send>(
        &self,
        py: Python<'_>,
        call: impl FnOnce(&BoardClient) -> Result<T, ClientError> + Send,
    ) -> PyResult<T> {
        let client = self.client()?;
        let result = py.detach(|| call(&client));
        result.map_err(|error| raised_error(&self.raised, &error))
    }

    pub(crate) fn command(&self, py: Python<'_>, command: Command) -> PyResult<()> {
        self.call(py, |client| client.command(command))
    }

    /// Ends the session, parking the arm or disarming, and closes the log. Without effect on one
    /// that is closed.
    pub(crate) fn close(&self, py: Python<'_>) -> PyResult<()> {
        if std::process::id() != self.process {
            return Ok(());
        }
        let Some(client) = lock(&self.client).take() else {
            return Ok(());
        };
        let recorder = lock(&self.recorder).take();
        let (left, written) = py.detach(|| {
            // Other threads may be in a call, which ends with the link.
            let left = client.close();
            drop(client);
            (left, recorder.map(Recorder::finish).transpose())
        });
        let written = written.map_err(log_error)?;
        if let Some(trouble) = written.and_then(|report| report.trouble) {
            return Err(log_error(trouble));
        }
        left.map_err(|error| from_client(&error))
    }
}

/// The exception of a call: that of the signal which interrupted it, if one did.
fn raised_error(raised: &Mutex<Option<PyErr>>, error: &ClientError) -> PyErr {
    match (error, lock(raised).take()) {
        (ClientError::Interrupted, Some(raised)) => raised,
        _ => from_client(error),
    }
}

impl Drop for Connection {
    fn drop(&mut self) {
        if std::process::id() == self.process {
            return;
        }
        // The threads that these would wait for are the parent's.
        std::mem::forget(lock(&self.client).take());
        std::mem::forget(lock(&self.recorder).take());
    }
}

pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Closes every connection, when the interpreter ends.
#[pyfunction]
pub(crate) fn close_all(py: Python<'_>) {
    let open = std::mem::take(&mut *lock(&OPEN));
    for connection in open.iter().filter_map(Weak::upgrade) {
        // Nobody is left who could be told.
        let _ = connection.close(py);
    }
}
