//! One connection to a served link.

use std::net::TcpStream;

use armbridge_link::frame::{Decoder, Encoder};
use armbridge_link::message::ToHost;
use armbridge_link::server::{FromServer, LinkRole, Program};

use super::outbox::Outbox;
use super::touching::Touching;

/// Role of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// It has sent no hello.
    Newcomer,
    /// It commands.
    Commander,
    /// It sees what the board says.
    Watcher,
    /// It did not begin with a frame: to be closed.
    Stranger,
}

/// A connection.
#[derive(Debug)]
pub(super) struct Peer {
    pub(super) stream: TcpStream,
    pub(super) role: Role,
    /// As it has announced itself.
    pub(super) program: Option<Program>,
    /// Its hello does not make it the commander.
    pub(super) is_observer: bool,
    pub(super) decoder: Decoder,
    /// The frame that it is sending, as it is on the wire; at most one byte more than fits.
    pub(super) frame: Vec<u8>,
    /// Of messages to a watcher: its own numbers show what it has lost.
    encoder: Encoder,
    /// Of messages of the server itself.
    notices: Encoder,
    pub(super) outbox: Outbox,
    /// Time of its last valid frame, or of its connection.
    pub(super) heard_us: u64,
    /// End of its hand's motion, which is answered then.
    pub(super) touched_us: Option<u64>,
}

impl Peer {
    /// A newcomer.
    pub(super) fn new(stream: TcpStream, now_us: u64) -> Self {
        Self {
            stream,
            role: Role::Newcomer,
            program: None,
            is_observer: false,
            decoder: Decoder::default(),
            frame: Vec::new(),
            encoder: Encoder::default(),
            notices: Encoder::default(),
            outbox: Outbox::default(),
            heard_us: now_us,
            touched_us: None,
        }
    }

    /// Informs it of its role, once it has one.
    pub(super) fn notify_role(&mut self, commander: Option<Program>, touching: &Touching) {
        let is_known = self.program.is_some() && self.role != Role::Newcomer;
        if is_known || self.role == Role::Watcher {
            self.notify(&FromServer::Role(LinkRole {
                is_commander: self.role == Role::Commander,
                commander,
                is_touchable: touching.is_possible(),
            }));
        }
    }

    /// Sends a message of the server itself.
    pub(super) fn notify(&mut self, message: &FromServer) {
        let frame = self.notices.encode(message).1;
        self.outbox.send(&mut self.stream, frame);
    }

    /// Sends messages of the board, as far as they fit.
    pub(super) fn send(&mut self, messages: &[ToHost]) {
        let mut frames = Vec::new();
        for message in messages {
            frames.extend_from_slice(self.encoder.encode(message).1);
        }
        self.outbox.send(&mut self.stream, &frames);
    }
}
