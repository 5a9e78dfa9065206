//! Host that takes its requests from a channel and shares the board's status, for
//! programs that drive a link on a thread of its own.

use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

use armbridge_link::message::Command;
use armbridge_link::server::LinkRole;

use super::{Request, Session};
use crate::error::SessionError;
use crate::status::BoardStatus;
use crate::{Host, ctrl_c};

/// Poll interval of the channel: short enough for key presses.
const POLL_INTERVAL_US: u64 = 10_000;

/// Host with requests from a channel. It ends its session when all handles are dropped.
#[derive(Debug)]
pub struct ChannelHost {
    requests: Receiver<Request>,
    session: Session,
    shared: Arc<Shared>,
    next_poll_us: u64,
}

/// The board's status, as of the latest bytes.
#[derive(Debug, Default)]
struct Shared {
    status: Mutex<BoardStatus>,
    changed: Condvar,
}

/// Error of a session that has ended; [`drive`](crate::transport::drive) returned the reason.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the session with the board has ended")]
pub struct SessionEnded;

/// Sends requests to a [`ChannelHost`], and reads the board's status.
#[derive(Clone, Debug)]
pub struct SessionHandle {
    requests: Sender<Request>,
    shared: Arc<Shared>,
}

impl SessionHandle {
    /// Sends a request to the session.
    ///
    /// # Errors
    /// If it has ended.
    pub fn request(&self, request: Request) -> Result<(), SessionEnded> {
        self.requests.send(request).map_err(|_| SessionEnded)
    }

    /// The board's status.
    pub fn status(&self) -> BoardStatus {
        self.lock().clone()
    }

    /// Waits until the status meets a condition; false after a timeout.
    pub fn wait_for(&self, timeout: Duration, is_met: impl Fn(&BoardStatus) -> bool) -> bool {
        let waiting = |status: &mut BoardStatus| !is_met(status);
        let waited = self
            .shared
            .changed
            .wait_timeout_while(self.lock(), timeout, waiting);
        !waited.unwrap_or_else(PoisonError::into_inner).1.timed_out()
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, BoardStatus> {
        // A status is replaced as a whole.
        let status = self.shared.status.lock();
        status.unwrap_or_else(PoisonError::into_inner)
    }
}

impl ChannelHost {
    /// A host before its first message, and its handle.
    pub fn new() -> (Self, SessionHandle) {
        let (sender, requests) = channel();
        let shared = Arc::new(Shared::default());
        let host = Self {
            requests,
            session: Session::default(),
            shared: Arc::clone(&shared),
            next_poll_us: 0,
        };
        let handle = SessionHandle {
            requests: sender,
            shared,
        };
        (host, handle)
    }

    fn share(&self) {
        let status = self.session.status().clone();
        let shared = self.shared.status.lock();
        *shared.unwrap_or_else(PoisonError::into_inner) = status;
        self.shared.changed.notify_all();
    }

    /// Passes the requests of the channel to the session.
    fn poll_requests(&mut self, now_us: u64) {
        if ctrl_c::is_raised() {
            self.session.request(now_us, Request::Leave);
        }
        loop {
            match self.requests.try_recv() {
                Ok(request) => self.session.request(now_us, request),
                Err(TryRecvError::Empty) => return,
                Err(TryRecvError::Disconnected) => {
                    self.session.request(now_us, Request::Leave);
                    return;
                }
            }
        }
    }
}

impl Host for ChannelHost {
    type Error = SessionError;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], SessionError> {
        self.poll_requests(now_us);
        self.next_poll_us = now_us + POLL_INTERVAL_US;
        self.session.transmit(now_us)
    }

    fn receive(&mut self, now_us: u64, bytes: &[u8]) -> Result<(), SessionError> {
        self.session.receive_all(now_us, bytes)?;
        self.share();
        Ok(())
    }

    fn wake_at_us(&self) -> u64 {
        self.next_poll_us.min(self.session.wake_at_us())
    }

    fn is_done(&self) -> bool {
        self.session.is_done()
    }

    fn emergency_stop(&mut self, now_us: u64) -> bool {
        self.session.request(now_us, Request::Stop);
        true
    }

    fn disarm(&mut self, now_us: u64) -> bool {
        self.session
            .request(now_us, Request::Command(Command::Idle));
        true
    }

    fn link_role(&mut self, role: LinkRole) {
        self.session.set_role(role);
        self.share();
    }

    fn disconnected(&mut self, _now_us: u64) {
        self.session.disconnected();
        self.share();
    }
}
