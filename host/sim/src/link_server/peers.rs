//! Connections to a served link: one commands, the others watch, and each may stop.
//!
//! | role      | to the board                        | from the board                        |
//! |-----------|-------------------------------------|---------------------------------------|
//! | newcomer  | `Stop`                              | nothing                               |
//! | commander | every byte, garbage as well         | every byte                            |
//! | watcher   | `Stop`; a command is refused        | every message but the commander's own |
//!
//! A newcomer that begins with something else than a frame is closed at once: a page in a
//! browser can send an HTTP request here, with frames in it.
//!
//! The first connection that says a valid hello commands; while it does, a hello makes a
//! watcher. When the commander leaves or breaks, the next hello commands.
//!
//! # Bounds
//!
//! A connection is read by at most [`READ_MAX`] bytes in a poll, and holds one frame in each
//! direction. One that sends no valid frame for [`SILENCE_US`] of the board's time is
//! closed. There are at most [`PEERS_MAX`]; a further one takes the place of the oldest
//! newcomer, otherwise of the oldest watcher, so that a stop always finds a connection.

use std::io;
use std::net::{TcpListener, TcpStream};

use armbridge_client::transport::WATCHING;
use armbridge_shared::link::frame::{self, Decoder, Encoder, FrameError, Received};
use armbridge_shared::link::message::{Refusal, ToBoard, ToHost};
use armbridge_shared::link::schema;

use super::latest::Latest;
use super::outbox::Outbox;
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

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    Newcomer,
    Commander,
    Watcher,
    /// It has begun with something else than a frame: to be closed.
    Stranger,
}

/// A connection.
#[derive(Debug)]
struct Peer {
    stream: TcpStream,
    role: Role,
    decoder: Decoder,
    /// The frame that it is sending, as it is on the wire; at most one byte more than fits.
    frame: Vec<u8>,
    /// Of messages to a watcher: its own numbers show what it has lost.
    encoder: Encoder,
    outbox: Outbox,
    /// Time of its last valid frame, or of its connection.
    heard_us: u64,
}

/// All connections.
#[derive(Debug)]
pub(super) struct Peers {
    listener: TcpListener,
    /// Oldest first.
    all: Vec<Peer>,
    /// One of them is the commander.
    is_commanded: bool,
    latest: Latest,
    decoder: Decoder,
    /// The commander has sent a part of a frame.
    is_mid_frame: bool,
    received: Vec<u8>,
}

impl Peers {
    /// Nobody is connected.
    pub(super) fn new(listener: TcpListener) -> io::Result<Self> {
        listener.set_nonblocking(true)?;
        Ok(Self {
            listener,
            all: Vec::new(),
            is_commanded: false,
            latest: Latest::default(),
            decoder: Decoder::default(),
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
        Ok(())
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
        if is_open && now_us.saturating_sub(peer.heard_us) < SILENCE_US {
            self.all.push(peer);
        } else if peer.role == Role::Commander {
            self.is_commanded = false;
        }
    }

    fn take(&mut self, peer: &mut Peer, byte: u8, now_us: u64, to_board: &mut Vec<u8>) {
        if peer.role == Role::Stranger {
            return;
        }
        if peer.role == Role::Commander {
            to_board.push(byte);
            self.is_mid_frame = byte != 0;
        } else if peer.frame.len() <= frame::MAX {
            peer.frame.push(byte);
        }
        let Some(received) = peer.decoder.push::<ToBoard>(byte) else {
            if byte == 0 {
                // An empty frame.
                peer.frame.clear();
            }
            return;
        };
        let frame = std::mem::take(&mut peer.frame);
        match received {
            Ok(received) => {
                if self.handle(peer, received, &frame, to_board) {
                    peer.heard_us = now_us;
                }
            }
            // A host of another build: our hello lets it inform its user.
            Err(FrameError::Version(_) | FrameError::Schema) if peer.role != Role::Commander => {
                peer.send(&[ToHost::Hello(schema::HELLO)]);
            }
            Err(_) if peer.role == Role::Newcomer => peer.role = Role::Stranger,
            Err(_) => {}
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
                self.is_commanded = false;
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
        if !self.is_commanded {
            self.is_commanded = true;
            peer.role = Role::Commander;
            peer.outbox.clear();
            self.inject(hello, to_board);
            return;
        }
        if peer.role == Role::Newcomer {
            peer.role = Role::Watcher;
            peer.outbox.send(&mut peer.stream, WATCHING);
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

impl Peer {
    fn new(stream: TcpStream, now_us: u64) -> Self {
        Self {
            stream,
            role: Role::Newcomer,
            decoder: Decoder::default(),
            frame: Vec::new(),
            encoder: Encoder::default(),
            outbox: Outbox::default(),
            heard_us: now_us,
        }
    }

    /// Sends messages of the server's own, or such as fit.
    fn send(&mut self, messages: &[ToHost]) {
        let mut frames = Vec::new();
        for message in messages {
            frames.extend_from_slice(self.encoder.encode(message).1);
        }
        self.outbox.send(&mut self.stream, &frames);
    }
}
