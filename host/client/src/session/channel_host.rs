//! Host that takes its requests from a channel and shares the board's status, for
//! programs that drive a link on a thread of its own.
//!
//! A request may be [asked](SessionHandle::ask), for its answer.

use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, TryRecvError, channel};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

use armbridge_link::message::{Command, Refusal};
use armbridge_link::server::LinkRole;

use super::{Request, Session};
use crate::error::SessionError;
use crate::status::BoardStatus;
use crate::{Host, ctrl_c, refusal_text};

/// Poll interval of the channel: short enough for key presses.
const POLL_INTERVAL_US: u64 = 10_000;

/// Host with requests from a channel. It ends its session when all handles are dropped.
#[derive(Debug)]
pub struct ChannelHost {
    requests: Receiver<Submitted>,
    /// Where the answers go, by the numbers of the requests.
    askers: VecDeque<(u64, Sender<Answer>)>,
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

/// Answer of the board to a request.
type Answer = Result<(), Refusal>;

/// A request, and where its answer goes.
type Submitted = (Request, Option<Sender<Answer>>);

/// Reason for which a request was not carried out.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum RequestError {
    /// The board refuses it.
    #[error("{}", refusal_text::in_words(*.0))]
    Refused(Refusal),
    /// Another request has overtaken it, the link broke, the board was reset, or the session has
    /// ended.
    #[error("dropped: another command overtook it, the link broke, or the board was reset")]
    Dropped,
}

/// Answer to a request that has been sent.
#[derive(Debug)]
pub struct PendingAnswer(Receiver<Answer>);

impl PendingAnswer {
    /// Waits for the answer; `None` after the timeout.
    pub fn wait(&self, timeout: Duration) -> Option<Result<(), RequestError>> {
        match self.0.recv_timeout(timeout) {
            Ok(answer) => Some(answer.map_err(RequestError::Refused)),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => Some(Err(RequestError::Dropped)),
        }
    }
}

/// Error of a session that has ended; [`drive`](crate::transport::drive) returned the reason.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the session with the board has ended")]
pub struct SessionEnded;

/// Sends requests to a [`ChannelHost`], and reads the board's status.
#[derive(Clone, Debug)]
pub struct SessionHandle {
    requests: Sender<Submitted>,
    shared: Arc<Shared>,
}

impl SessionHandle {
    /// Sends a request to the session.
    ///
    /// # Errors
    /// If it has ended.
    pub fn request(&self, request: Request) -> Result<(), SessionEnded> {
        self.submit(request, None)
    }

    /// Sends a request to the session, for its answer.
    ///
    /// # Errors
    /// If it has ended.
    pub fn ask(&self, request: Request) -> Result<PendingAnswer, SessionEnded> {
        let (answer, pending) = channel();
        self.submit(request, Some(answer))?;
        Ok(PendingAnswer(pending))
    }

    fn submit(&self, request: Request, answer: Option<Sender<Answer>>) -> Result<(), SessionEnded> {
        self.requests
            .send((request, answer))
            .map_err(|_| SessionEnded)
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
            askers: VecDeque::new(),
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
                Ok((request, asker)) => {
                    let number = self.session.request(now_us, request);
                    self.askers.extend(asker.map(|asker| (number, asker)));
                }
                Err(TryRecvError::Empty) => return,
                Err(TryRecvError::Disconnected) => {
                    self.session.request(now_us, Request::Leave);
                    return;
                }
            }
        }
    }

    /// Passes on the answer to the request that was begun last, and drops those that get none.
    fn pass_answer(&mut self) {
        let (begun, answer) = (self.session.begun(), self.session.take_answer());
        while let Some((number, _)) = self.askers.front()
            && (*number < begun || (*number == begun && answer.is_some()))
            && let Some((number, asker)) = self.askers.pop_front()
        {
            if let (true, Some(answer)) = (number == begun, answer) {
                // It may have given up.
                let _ = asker.send(answer);
            }
        }
        if self.session.is_settled() {
            self.askers.clear();
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
        // A status is seen before the answer that it belongs to.
        self.share();
        self.pass_answer();
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
        self.askers.clear();
        self.share();
    }
}
