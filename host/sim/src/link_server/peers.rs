//! Connections to a served link: one commands, the others watch, and each may stop.
//!
//! | role      | to the board                        | from the board                        |
//! |-----------|-------------------------------------|---------------------------------------|
//! | newcomer  | `Stop`                              | nothing                               |
//! | commander | every frame, garbage as well        | every byte                            |
//! | watcher   | `Stop`; a command is refused        | every message but the commander's own |
//!
//! A newcomer that does not begin with a frame is closed at once: a page in a browser can send
//! an HTTP request here, with frames in it.
//!
//! The first connection that says a valid hello commands; while it does, a hello makes a
//! watcher. When the commander leaves or breaks, the next hello commands, except of a program
//! that has joined as an observer: it remains a watcher. A board without a session sends no
//! records, so the server itself says hello to it for watchers without a commander.
//!
//! Messages to the server end here: see [`armbridge_link::server`]. The server informs
//! each program that has joined, and every watcher, which program commands, and of each change.
//!
//! # Bounds
//!
//! A connection is read by at most [`READ_MAX`] bytes in a poll, and holds one frame in each
//! direction. One that sends no valid frame for [`SILENCE_US`] of the board's time is
//! closed. There are at most [`PEERS_MAX`]; a further one takes the place of the oldest
//! newcomer, otherwise of the oldest watcher, so that a stop always finds a connection.

use std::io;
use std::net::TcpListener;

use armbridge_link::frame::{self, Decoder, Encoder, FrameError, Received};
use armbridge_link::message::{Refusal, ToBoard, ToHost};
use armbridge_link::schema;
use armbridge_link::server::{FromServer, Program, ToServer};

use super::POLL_US;
use super::latest::Latest;
use super::peer::{Peer, Role};
use super::touching::Touching;
use crate::nonblocking;

/// Bytes taken from a connection in a poll, which is once in a millisecond: as many as USB
/// carries at 12 Mbaud. More wait at the sender.
const READ_MAX: usize = 1_024;
/// Silence after which a connection is closed; a host sends a frame every 25 ms.
const SILENCE_US: u64 = 3_000_000;
/// Connections at a time.
const PEERS_MAX: usize = 16;
/// Connections accepted in a poll.
const ACCEPTS_MAX: usize = 4;

/// The message to the server in a frame, if it is one.
fn to_server(frame: &[u8]) -> Option<ToServer> {
    let mut decoder = Decoder::default();
    let received = frame.iter().find_map(|byte| decoder.push(*byte))?;
    received
        .ok()
        .map(|received: Received<ToServer>| received.message)
}

/// All connections.
#[derive(Debug)]
pub(super) struct Peers {
    listener: TcpListener,
    /// Oldest first.
    all: Vec<Peer>,
    /// The commander, if there is one.
    commander: Option<Program>,
    /// It has changed since the connections were informed.
    is_role_due: bool,
    /// The board has a session, of a commander or of the server itself.
    is_board_greeted: bool,
    /// Hands on the simulated arm.
    pub(super) touching: Touching,
    latest: Latest,
    decoder: Decoder,
    /// Of the server's own hellos.
    encoder: Encoder,
    /// The board has received a part of a frame.
    is_mid_frame: bool,
    received: Vec<u8>,
}

impl Peers {
    /// No connection yet.
    pub(super) fn new(listener: TcpListener) -> io::Result<Self> {
        listener.set_nonblocking(true)?;
        Ok(Self {
            listener,
            all: Vec::new(),
            commander: None,
            is_role_due: false,
            is_board_greeted: false,
            touching: Touching::default(),
            latest: Latest::default(),
            decoder: Decoder::default(),
            encoder: Encoder::default(),
            is_mid_frame: false,
            received: Vec::new(),
        })
    }

    /// Takes bytes and connections; appends the bytes for the board.
    pub(super) fn poll(&mut self, now_us: u64, to_board: &mut Vec<u8>) -> io::Result<()> {
        for peer in std::mem::take(&mut self.all) {
            self.read(peer, now_us, to_board);
        }
        for _ in 0..ACCEPTS_MAX {
            let Some((stream, _)) = nonblocking::accept(&self.listener)? else {
                break;
            };
            self.make_room();
            self.all.push(Peer::new(stream, now_us));
        }
        self.greet_for_watchers(to_board);
        if std::mem::take(&mut self.is_role_due) {
            for peer in &mut self.all {
                peer.notify_role(self.commander, &self.touching);
            }
        }
        Ok(())
    }

    /// Opens a session for watchers if there is no other.
    fn greet_for_watchers(&mut self, to_board: &mut Vec<u8>) {
        let is_watched = self.all.iter().any(|peer| peer.role == Role::Watcher);
        if self.commander.is_none() && !self.is_board_greeted && is_watched {
            let hello = self.encoder.encode(&ToBoard::Hello(schema::HELLO)).1;
            let hello = hello.to_vec();
            self.inject(&hello, to_board);
            self.is_board_greeted = true;
        }
    }

    fn set_commander(&mut self, commander: Option<Program>) {
        self.commander = commander;
        self.is_role_due = true;
    }

    fn make_room(&mut self) {
        if self.all.len() < PEERS_MAX {
            return;
        }
        let oldest = |role| self.all.iter().position(|peer| peer.role == role);
        if let Some(index) = oldest(Role::Newcomer).or_else(|| oldest(Role::Watcher)) {
            self.all.remove(index);
        }
    }

    /// Reads from a connection, and keeps it unless it has ended or is silent.
    fn read(&mut self, mut peer: Peer, now_us: u64, to_board: &mut Vec<u8>) {
        let mut received = std::mem::take(&mut self.received);
        received.clear();
        let is_open = nonblocking::read(&mut peer.stream, &mut received, READ_MAX);
        for byte in &received {
            self.take(&mut peer, *byte, now_us, to_board);
        }
        self.received = received;
        let is_open = is_open && peer.role != Role::Stranger;
        if peer
            .touched_us
            .take_if(|end_us| now_us >= *end_us)
            .is_some()
        {
            peer.notify(&FromServer::Touched(Ok(())));
        }
        // While its hand moves, a program may be silent.
        let heard_us = peer.heard_us.max(peer.touched_us.unwrap_or_default());
        if is_open && now_us.saturating_sub(heard_us) < SILENCE_US {
            self.all.push(peer);
        } else if peer.role == Role::Commander {
            self.set_commander(None);
        }
    }

    fn take(&mut self, peer: &mut Peer, byte: u8, now_us: u64, to_board: &mut Vec<u8>) {
        if peer.role == Role::Stranger {
            return;
        }
        if peer.role == Role::Commander && peer.frame.len() > frame::MAX {
            // Not a frame: garbage is passed on to the board.
            to_board.push(byte);
            self.is_mid_frame = byte != 0;
        } else if peer.frame.len() <= frame::MAX {
            peer.frame.push(byte);
            if peer.role == Role::Commander && peer.frame.len() > frame::MAX {
                self.inject(&peer.frame, to_board);
                self.is_mid_frame = byte != 0;
            }
        }
        let received = peer.decoder.push::<ToBoard>(byte);
        if byte != 0 {
            return;
        }
        let frame = std::mem::take(&mut peer.frame);
        let message = to_server(&frame);
        if peer.role == Role::Commander && message.is_none() && frame.len() <= frame::MAX {
            self.inject(&frame, to_board);
        }
        let is_valid = match (message, received) {
            (Some(message), _) => {
                self.serve(peer, message, now_us);
                true
            }
            (None, Some(Ok(received))) => self.handle(peer, received, &frame, to_board),
            // A host of another build: our hello lets it inform its user.
            (None, Some(Err(FrameError::Version(_) | FrameError::Schema)))
                if peer.role != Role::Commander =>
            {
                peer.send(&[ToHost::Hello(schema::HELLO)]);
                false
            }
            (None, Some(Err(_))) => {
                if peer.role == Role::Newcomer {
                    peer.role = Role::Stranger;
                }
                false
            }
            // An empty frame.
            (None, None) => false,
        };
        if is_valid {
            peer.heard_us = now_us;
        }
    }

    /// Handles a message to the server.
    fn serve(&mut self, peer: &mut Peer, message: ToServer, now_us: u64) {
        match message {
            ToServer::Join {
                is_observer,
                program,
            } => {
                peer.program = Some(program);
                peer.is_observer = is_observer;
                if is_observer && peer.role == Role::Newcomer {
                    peer.role = Role::Watcher;
                }
                peer.notify_role(self.commander, &self.touching);
            }
            ToServer::Touch(touch) => {
                let result = self.touching.touch(touch);
                if result.is_ok() && touch.motion_us() > 0 {
                    peer.touched_us = Some(now_us + u64::from(touch.motion_us()) + POLL_US);
                } else {
                    peer.notify(&FromServer::Touched(result));
                }
            }
        }
    }

    /// Whether the frame shows a host that may stay.
    fn handle(
        &mut self,
        peer: &mut Peer,
        received: Received<ToBoard>,
        frame: &[u8],
        to_board: &mut Vec<u8>,
    ) -> bool {
        match (peer.role, received.message) {
            (Role::Stranger, _) => return false,
            (Role::Commander, ToBoard::Goodbye) => {
                peer.role = Role::Newcomer;
                self.is_board_greeted = false;
                self.set_commander(None);
            }
            (Role::Commander, _) | (Role::Watcher, ToBoard::Heartbeat | ToBoard::Goodbye) => {}
            (_, ToBoard::Stop) => self.inject(frame, to_board),
            (_, ToBoard::Hello(hello)) if hello.schema != schema::HASH => {
                peer.send(&[ToHost::Hello(schema::HELLO)]);
                return false;
            }
            (_, ToBoard::Hello(_)) => self.greet(peer, frame, to_board),
            (Role::Watcher, ToBoard::Command(_)) => peer.send(&[ToHost::Ack {
                sequence: received.sequence,
                result: Err(Refusal::OtherSession),
                moment: None,
            }]),
            (Role::Newcomer, ToBoard::Command(_) | ToBoard::Heartbeat | ToBoard::Goodbye) => {
                return false;
            }
        }
        true
    }

    /// Makes a connection the commander, or a watcher if there is one.
    fn greet(&mut self, peer: &mut Peer, hello: &[u8], to_board: &mut Vec<u8>) {
        if self.commander.is_none() && !peer.is_observer {
            peer.role = Role::Commander;
            peer.outbox.clear();
            self.inject(hello, to_board);
            self.is_board_greeted = true;
            self.set_commander(Some(peer.program.unwrap_or(Program::UNKNOWN)));
            return;
        }
        if peer.role == Role::Newcomer {
            peer.role = Role::Watcher;
            peer.notify_role(self.commander, &self.touching);
        }
        let answer: Vec<ToHost> = self.latest.answer().collect();
        peer.send(&answer);
    }

    /// Appends a whole frame; a part of one before it is ended, and lost.
    fn inject(&mut self, frame: &[u8], to_board: &mut Vec<u8>) {
        if std::mem::take(&mut self.is_mid_frame) {
            to_board.push(0);
        }
        to_board.extend_from_slice(frame);
    }

    /// Sends bytes of the board to the commander, and their messages to the watchers.
    pub(super) fn send(&mut self, bytes: &[u8]) {
        let mut messages = Vec::new();
        for byte in bytes {
            if let Some(Ok(received)) = self.decoder.push::<ToHost>(*byte) {
                self.latest.take(&received.message);
                self.touching.take(&received.message);
                match received.message {
                    ToHost::Hello(_) | ToHost::Ack { .. } | ToHost::Departs { .. } => {}
                    message => messages.push(message),
                }
            }
        }
        for peer in &mut self.all {
            match peer.role {
                Role::Newcomer | Role::Stranger => {}
                Role::Commander => peer.outbox.send(&mut peer.stream, bytes),
                Role::Watcher => peer.send(&messages),
            }
        }
    }
}
