//! Exchange of settings with a board: a host that reads, changes, and leaves.

use std::collections::VecDeque;

use armbridge_link::message::{Command, Refusal, Settings};
use armbridge_link::server::LinkRole;

use crate::error::SessionError;
use crate::session::{Request, Session};
use crate::{Host, ctrl_c};

/// Timeout of a board that has answered before.
const SILENCE_US: u64 = 3_000_000;

/// Result of an exchange.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Exchanged {
    /// Settings in force before it.
    pub before: Option<Settings>,
    /// Commands that the board accepted, in order.
    pub taken: Vec<Command>,
    /// The command that it refused, which ends the exchange, and the reason.
    pub refused: Option<(Command, Refusal)>,
}

/// Host of an exchange: sends a hello, receives the settings in force, and sends the commands
/// that `decide` derives from them, one after the other, until one is refused.
#[derive(Debug)]
pub struct Exchange<D> {
    session: Session,
    decide: Option<D>,
    queue: VecDeque<Command>,
    sent: Option<Command>,
    received_us: u64,
    /// Result so far.
    pub exchanged: Exchanged,
}

/// Commands that change a board's settings: limits first, which it accepts
/// only while idle, so that with torque on either all or nothing is changed.
pub fn commands(before: &Settings, after: &Settings, save: bool) -> Vec<Command> {
    let limit = (before.limits != after.limits).then_some(Command::Limit(after.limits));
    let configure = (before.setup != after.setup).then_some(Command::Configure(after.setup));
    let save = save.then_some(Command::Save);
    [limit, configure, save].into_iter().flatten().collect()
}

impl<D: FnOnce(&Settings) -> Vec<Command>> Exchange<D> {
    /// A host before its first message.
    pub fn new(decide: D) -> Self {
        Self {
            session: Session::default(),
            decide: Some(decide),
            queue: VecDeque::new(),
            sent: None,
            received_us: 0,
            exchanged: Exchanged::default(),
        }
    }

    fn update(&mut self, now_us: u64) {
        if let Some(settings) = self.session.status().settings
            && let Some(decide) = self.decide.take()
        {
            self.exchanged.before = Some(settings);
            self.queue = decide(&settings).into();
            self.next(now_us);
        }
        if let Some(answer) = self.session.take_answer()
            && let Some(command) = self.sent.take()
        {
            match answer {
                Ok(()) => self.exchanged.taken.push(command),
                Err(refusal) => {
                    self.exchanged.refused = Some((command, refusal));
                    self.queue.clear();
                }
            }
            self.next(now_us);
        }
    }

    fn next(&mut self, now_us: u64) {
        self.sent = self.queue.pop_front();
        let request = self.sent.map_or(Request::Leave, Request::Command);
        self.session.request(now_us, request);
    }
}

impl<D: FnOnce(&Settings) -> Vec<Command>> Host for Exchange<D> {
    type Error = SessionError;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], SessionError> {
        if ctrl_c::is_raised() {
            self.session.request(now_us, Request::Leave);
        }
        if self.received_us > 0 && now_us > self.received_us + SILENCE_US {
            return Err(SessionError::Silent);
        }
        self.session.transmit(now_us)
    }

    fn receive(&mut self, now_us: u64, bytes: &[u8]) -> Result<(), SessionError> {
        self.session.receive_all(now_us, bytes)?;
        if !bytes.is_empty() {
            self.received_us = now_us;
        }
        self.update(now_us);
        Ok(())
    }

    fn wake_at_us(&self) -> u64 {
        self.session.wake_at_us()
    }

    fn is_done(&self) -> bool {
        self.session.is_done()
    }

    fn emergency_stop(&mut self, now_us: u64) -> bool {
        self.session.request(now_us, Request::Stop);
        true
    }

    fn disarm(&mut self, _now_us: u64) -> bool {
        // Its hello has disarmed the board, and it arms nothing.
        true
    }

    /// An unanswered command is sent again: settings are a state, not an event.
    fn link_role(&mut self, role: LinkRole) {
        self.session.set_role(role);
    }

    fn disconnected(&mut self, now_us: u64) {
        self.session.disconnected();
        self.received_us = 0;
        if let Some(command) = self.sent.take() {
            self.queue.push_front(command);
            self.next(now_us);
        }
    }
}
