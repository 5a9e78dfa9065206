//! Host that takes its requests from a channel and shares the board's status, for
//! programs that drive a link on a thread of its own.
//!
//! A request is passed to the session when the one before it has been answered, so that each answer
//! belongs to one request. A stop, the end of the session and the command to disarm overtake the
//! others, which are dropped.

use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, TryRecvError, channel};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

use armbridge_link::message::{Command, Refusal};
use armbridge_link::server::LinkRole;

use super::{QUEUE_MAX, Request, Session};
use crate::error::SessionError;
use crate::status::BoardStatus;
use crate::{Host, ctrl_c, refusal_text};

/// Poll interval of the channel: short enough for key presses.
const POLL_INTERVAL_US: u64 = 10_000;

/// Host with requests from a channel. It ends its session when all handles are dropped.
#[derive(Debug)]
pub struct ChannelHost {
    requests: Receiver<Submitted>,
    waiting: VecDeque<Submitted>,
    /// Where the answer to the request under way goes.
    answer: Option<Sender<Answer>>,
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

#[derive(Debug)]
struct Submitted {
    request: Request,
    answer: Option<Sender<Answer>>,
}

/// Reason for which a request was not carried out.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum RequestError {
    /// The board refuses it.
    #[error("{}", refusal_text::in_words(*.0))]
    Refused(Refusal),
    /// Another request has overtaken it, the link broke, the board was reset, or the session has
    /// ended.
    #[error("dropped: a stop or a disarm overtook it, the link broke, or the board was reset")]
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
        let submitted = Submitted { request, answer };
        self.requests.send(submitted).map_err(|_| SessionEnded)
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
            waiting: VecDeque::new(),
            answer: None,
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

    /// Takes the requests of the channel, and passes the next ones to the session.
    fn poll_requests(&mut self, now_us: u64) {
        if ctrl_c::is_raised() {
            self.session.request(now_us, Request::Leave);
        }
        loop {
            match self.requests.try_recv() {
                Ok(submitted) => self.take(now_us, submitted),
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => {
                    self.session.request(now_us, Request::Leave);
                    break;
                }
            }
        }
        while self.answer.is_none()
            && self.session.is_settled()
            && let Some(next) = self.waiting.pop_front()
        {
            self.pass(now_us, next);
        }
    }

    fn take(&mut self, now_us: u64, submitted: Submitted) {
        match submitted.request {
            Request::Stop | Request::Leave | Request::Command(Command::Idle) => {
                self.waiting.clear();
                self.pass(now_us, submitted);
            }
            Request::Command(_) | Request::Arm => {
                if self.waiting.len() < QUEUE_MAX {
                    self.waiting.push_back(submitted);
                }
            }
        }
    }

    fn pass(&mut self, now_us: u64, submitted: Submitted) {
        self.session.request(now_us, submitted.request);
        self.answer = submitted.answer;
    }

    /// Passes on the answer to the request under way, or drops it if there will be none.
    fn pass_answer(&mut self) {
        let answer = self.session.take_answer();
        if answer.is_none() && !self.session.is_settled() {
            return;
        }
        if let (Some(waiting), Some(answer)) = (self.answer.take(), answer) {
            // Its asker may have given up.
            let _ = waiting.send(answer);
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
        self.waiting.clear();
        self.answer = None;
        self.share();
    }
}
