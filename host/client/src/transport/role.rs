//! Role of this program on a link that several programs can have.
//!
//! A server of a link announces it; any other link has one program, which commands. The program
//! keeps its role when the link comes back: one that has observed does not take command after
//! a restart of the server.

use std::io;
use std::time::{Duration, Instant};

use armbridge_link::server::{LinkRole, ToServer};

use super::{LinkUri, TransportError, program};

/// Longest wait of an observer for the server to announce its role.
const ROLE_TIMEOUT: Duration = Duration::from_secs(2);

/// Requested role on a link that other programs may share.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Intent {
    /// To command; it ends at once if another program does.
    #[default]
    Command,
    /// To command if no other program does, and to observe otherwise.
    CommandOrObserve,
    /// To observe, and never to command.
    Observe,
}

/// The role so far.
#[derive(Debug)]
pub(super) struct RoleKeeper {
    intent: Intent,
    /// On this connection.
    role: Option<LinkRole>,
    opened: Instant,
    /// A server has announced a role, on this connection or an earlier one.
    is_served: bool,
}

impl RoleKeeper {
    /// No connection yet.
    pub(super) fn new(intent: Intent) -> Self {
        Self {
            intent,
            role: None,
            opened: Instant::now(),
            is_served: false,
        }
    }

    /// Begins a connection; the first message on it, if a server may be behind it.
    ///
    /// # Errors
    /// If the link cannot be observed.
    pub(super) fn join(&mut self, link: &LinkUri) -> Result<Option<ToServer>, TransportError> {
        self.role = None;
        self.opened = Instant::now();
        let is_observer = self.is_observer();
        match link {
            LinkUri::Tcp(_) => Ok(Some(ToServer::Join {
                is_observer,
                program: program::this(),
            })),
            _ if is_observer => Err(TransportError::NotObservable(link.clone())),
            LinkUri::Usb(_) | LinkUri::Serial(_) | LinkUri::Pty(_) => Ok(None),
        }
    }

    /// Takes the role that the server announces; returns whether it has changed.
    ///
    /// # Errors
    /// If another program commands, and this one has to.
    pub(super) fn take(&mut self, role: LinkRole) -> Result<bool, TransportError> {
        self.is_served = true;
        let is_other = self.role.replace(role) != Some(role);
        match (self.intent, role.commander) {
            (Intent::Command, Some(commander)) if !role.is_commander => {
                return Err(TransportError::Commanded(commander));
            }
            (Intent::CommandOrObserve, _) if !role.is_commander => self.intent = Intent::Observe,
            (Intent::Command | Intent::CommandOrObserve | Intent::Observe, _) => {}
        }
        Ok(is_other)
    }

    /// The role that the server announced on this connection.
    pub(super) fn role(&self) -> Option<LinkRole> {
        self.role
    }

    /// This program only observes.
    pub(super) fn is_observer(&self) -> bool {
        self.intent == Intent::Observe
    }

    /// Whether the host may say hello: an observer only to a server that knows it as one.
    ///
    /// # Errors
    /// If there is no such server, or it does not answer.
    pub(super) fn may_send(&self, link: &LinkUri) -> Result<bool, TransportError> {
        let may_send = !self.is_observer() || self.role.is_some();
        if !may_send && self.opened.elapsed() > ROLE_TIMEOUT {
            return Err(if self.is_served {
                TransportError::Broken(io::ErrorKind::TimedOut.into())
            } else {
                TransportError::NotObservable(link.clone())
            });
        }
        Ok(may_send)
    }
}
