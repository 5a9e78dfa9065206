//! Reasons for which a call to a board fails, each as a sentence.

use std::time::Duration;

use armbridge_client::session::{Request, RequestError, SessionEnded};
use armbridge_client::status::Obstacle;
use armbridge_client::{enum_names, fault_text, refusal_text};
use armbridge_link::message::{Command, Fault, Refusal, Trip};
use armbridge_link::server::{LinkRole, Touch};

use crate::link::LinkThreadError;

/// Reason for which a call failed.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    /// The link could not be opened, or has ended.
    #[error(transparent)]
    Link(#[from] LinkThreadError),
    /// The link has ended before; the call that noticed it first had the reason.
    #[error("the link to the board has ended")]
    Ended,
    /// The board refuses a command.
    #[error("the board refuses to {}: {}", enum_names::command(command), refusal_text::in_words(*refusal))]
    Refused {
        /// The command.
        command: Box<Command>,
        /// The reason.
        refusal: Refusal,
    },
    /// The board refuses to arm.
    #[error("the board refuses to arm: {}", refusal_text::in_words(*.0))]
    NotArmed(Refusal),
    /// The board switched torque off.
    #[error("{}", fault(*.0, .1.as_ref()))]
    Fault(Fault, Option<Trip>),
    /// Another request overtook it, or the board was reset.
    #[error("{}", RequestError::Dropped)]
    Dropped,
    /// Something did not happen in time.
    #[error("{what} in {} s{}", waited.as_secs_f64(), obstacle.as_ref().map_or_else(String::new, |why| format!(": {why}")))]
    Timeout {
        /// As "the board did not answer".
        what: &'static str,
        /// Time for which it was waited.
        waited: Duration,
        /// What the board reports that it lacks.
        obstacle: Option<Obstacle>,
    },
    /// Another program commands the board; this one observes.
    #[error("{}", observes(*.0))]
    Observes(LinkRole),
    /// A push is none.
    #[error(
        "the arm cannot be pushed like that: joint 1 or 2, at most {} N m and {} s",
        Touch::TORQUE_MAX_NM,
        Touch::DURATION_MAX_US / 1_000_000
    )]
    Push,
    /// The caller is interrupted.
    #[error("interrupted")]
    Interrupted,
}

impl ClientError {
    /// The error of this request.
    pub(super) fn of_request(request: Request, error: RequestError) -> Self {
        match (error, request) {
            (RequestError::Dropped, _) => Self::Dropped,
            (RequestError::Refused(refusal), Request::Command(command)) => Self::Refused {
                command: Box::new(command),
                refusal,
            },
            (RequestError::Refused(refusal), _) => Self::NotArmed(refusal),
        }
    }
}

impl From<SessionEnded> for ClientError {
    fn from(_: SessionEnded) -> Self {
        Self::Ended
    }
}

fn fault(fault: Fault, trip: Option<&Trip>) -> String {
    match trip {
        Some(trip) => format!("torque is off: {}", fault_text::in_words(trip)),
        None => format!("torque is off by a fault: {}", fault.name()),
    }
}

fn observes(role: LinkRole) -> String {
    match role.commander {
        Some(program) => format!("{program} commands the board; this program observes"),
        None => "no program commands the board; this one observes".into(),
    }
}
