//! Hosts that do one thing and end: what one-line commands put on a link.
//!
//! A [`TaskHost`] runs a [`Task`] on a [`Session`]: the task looks at the board's status
//! after each message, and makes its requests as the dashboard does. A task that fails
//! returns a [`TaskError`]; the link then sends the goodbye.
//!
//! | module         | what                                                       |
//! |----------------|------------------------------------------------------------|
//! | [`status`]     | counts frames, and measures round trips                    |
//! | [`arm`]        | armed, until ctrl-c, its time, or a fault                  |
//! | [`motors_off`] | disarmed, stopped, or a fault cleared                      |
//! | [`calibrate`]  | zero and sign of each joint                                |

pub mod arm;
pub mod calibrate;
mod error;
pub mod motors_off;
pub mod status;

pub use error::TaskError;

use armbridge_client::Host;
use armbridge_client::session::{ARM_TIMEOUT_US, Request, Session};
use armbridge_client::transport::Intent;
use armbridge_link::message::Command;
use armbridge_link::server::LinkRole;

/// Longest that a task waits for its time, in µs.
const LOOK_US: u64 = 10_000;
/// Time for the board's report, before a task ends that another program has disarmed.
const RELEASE_US: u64 = 100_000;

/// A task's view of the session: status, and requests.
#[derive(Debug)]
pub struct View<'a> {
    /// The host's time in µs.
    pub now_us: u64,
    /// The session with the board; [`Request::Leave`](armbridge_client::session::Request)
    /// ends the task.
    pub session: &'a mut Session,
}

impl View<'_> {
    /// Whether the board has acknowledged the request made at `since_us`.
    fn is_acknowledged(&mut self, since_us: u64, refused: &'static str) -> Result<bool, TaskError> {
        match self.session.take_answer() {
            Some(Ok(())) => Ok(true),
            Some(Err(refusal)) => Err(TaskError::Refused {
                result: refused,
                refusal,
            }),
            None if self.now_us.saturating_sub(since_us) > ARM_TIMEOUT_US => {
                Err(TaskError::NoAnswer)
            }
            None => Ok(false),
        }
    }
}

/// One thing to do.
pub trait Task {
    /// A message came, or time has passed.
    ///
    /// # Errors
    /// If the task cannot be done.
    fn look(&mut self, view: View<'_>) -> Result<(), TaskError>;

    /// The connection broke; it may come back, disarmed.
    fn disconnected(&mut self, _now_us: u64) {}

    /// Whether it needs to command the board.
    fn intent(&self) -> Intent {
        Intent::Command
    }
}

/// A host with one task.
#[derive(Debug)]
pub struct TaskHost<T> {
    /// The task.
    pub task: T,
    /// The session that it is done in.
    pub session: Session,
    look_us: u64,
    /// When another program asked to disarm.
    released_us: Option<u64>,
}

impl<T: Task> TaskHost<T> {
    /// Not begun yet.
    pub fn new(task: T) -> Self {
        Self {
            task,
            session: Session::default(),
            look_us: 0,
            released_us: None,
        }
    }

    fn look(&mut self, now_us: u64) -> Result<(), TaskError> {
        self.look_us = now_us + LOOK_US;
        if let Some(released_us) = self.released_us {
            // Nothing is armed from now on.
            return match now_us.saturating_sub(released_us) {
                0..=RELEASE_US => Ok(()),
                _ => Err(TaskError::Released),
            };
        }
        self.task.look(View {
            now_us,
            session: &mut self.session,
        })
    }
}

impl<T: Task> Host for TaskHost<T> {
    type Error = TaskError;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], TaskError> {
        self.look(now_us)?;
        Ok(self.session.transmit(now_us)?)
    }

    fn receive(&mut self, now_us: u64, mut bytes: &[u8]) -> Result<(), TaskError> {
        while self.session.receive(now_us, &mut bytes)?.is_some() {
            self.look(now_us)?;
        }
        Ok(())
    }

    fn wake_at_us(&self) -> u64 {
        self.look_us.min(self.session.wake_at_us())
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
        self.released_us.get_or_insert(now_us);
        true
    }

    fn link_role(&mut self, role: LinkRole) {
        self.session.set_role(role);
    }

    fn disconnected(&mut self, now_us: u64) {
        self.session.disconnected();
        self.task.disconnected(now_us);
    }
}
