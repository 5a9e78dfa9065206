//! Commands one after the other at a rate, whose sender does not wait for their answers.

use std::time::Duration;

use armbridge_client::session::{PendingAnswer, Request, RequestError};
use armbridge_link::message::{Command, Refusal};

use super::{BoardClient, ClientError};

/// See the [module](self).
#[derive(Debug, Default)]
pub struct CommandSender(Option<(Request, PendingAnswer)>);

impl CommandSender {
    /// Sends a command. Returns whether the one before came too late for the board.
    ///
    /// # Errors
    /// If the link has ended, or the board refused the one before for another reason.
    pub fn send(&mut self, client: &BoardClient, command: Command) -> Result<bool, ClientError> {
        let request = Request::Command(command);
        let pending = client.thread().session().ask(request)?;
        let Some((before, answer)) = self.0.replace((request, pending)) else {
            return Ok(false);
        };
        match answer.wait(Duration::ZERO) {
            Some(Err(RequestError::Refused(Refusal::Late { .. }))) => Ok(true),
            Some(Err(error)) => Err(ClientError::of_request(before, error)),
            // It is under way; the session sends both in order.
            Some(Ok(())) | None => Ok(false),
        }
    }
}
