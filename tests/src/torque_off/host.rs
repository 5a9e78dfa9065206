//! A host whose writes a test composes frame by frame: several frames in one write,
//! or garbage. It sends heartbeats of itself unless it is silent.

use std::convert::Infallible;

use armbridge_client::Host;
use armbridge_link::frame::{Decoder, Encoder};
use armbridge_link::message::{Command, Record, Refusal, ToBoard, ToHost};
use armbridge_link::schema;

/// Period of heartbeats in µs: that of the host program.
const HEARTBEAT_US: u64 = 25_000;

/// The host and the board's messages to it.
#[derive(Debug, Default)]
pub struct RawHost {
    encoder: Encoder,
    decoder: Decoder,
    /// Bytes of the next write.
    chunk: Vec<u8>,
    written: Vec<u8>,
    heartbeat_us: u64,
    /// No heartbeats are sent.
    pub is_silent: bool,
    /// Messages of the board with their times in µs, except records.
    pub messages: Vec<(u64, ToHost)>,
    /// The latest record.
    pub record: Option<Record>,
}

impl RawHost {
    /// Adds a frame to the next write; returns its sequence number.
    pub fn send(&mut self, message: ToBoard) -> u16 {
        let (sequence, frame) = self.encoder.encode(&message);
        self.chunk.extend_from_slice(frame);
        sequence
    }

    /// The same for a command.
    pub fn command(&mut self, command: Command) -> u16 {
        self.send(ToBoard::Command(command))
    }

    /// Adds so many bytes of garbage to the next write.
    pub fn garbage(&mut self, count: u32) {
        self.chunk.extend((0..count).map(|i| (i * 7 % 251) as u8));
    }

    /// Adds another session's hello to the next write, with sequence numbers from 0.
    pub fn begin_session(&mut self) {
        self.encoder = Encoder::default();
        self.is_silent = false;
        // Ends whatever half frame the board is in.
        self.chunk.push(0);
        self.send(ToBoard::Hello(schema::HELLO));
    }

    /// The answer to the command of this sequence number, after the first `since`
    /// messages.
    pub fn answer(&self, since: usize, sequence: u16) -> Option<Result<(), Refusal>> {
        let mut messages = self.messages.iter().skip(since);
        messages.find_map(|(_, message)| match message {
            ToHost::Ack {
                sequence: answered,
                result,
                ..
            } if *answered == sequence => Some(*result),
            _ => None,
        })
    }

    /// The session that the board reported last.
    pub fn session(&self) -> u32 {
        let mut messages = self.messages.iter().rev();
        messages
            .find_map(|(_, message)| match message {
                ToHost::Board(report) => Some(report.session),
                _ => None,
            })
            .expect("a report of the session")
    }
}

impl Host for RawHost {
    type Error = Infallible;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], Infallible> {
        if !self.is_silent && self.chunk.is_empty() && now_us >= self.heartbeat_us {
            self.send(ToBoard::Heartbeat);
        }
        if !self.chunk.is_empty() {
            self.heartbeat_us = now_us + HEARTBEAT_US;
        }
        self.written.clear();
        self.written.append(&mut self.chunk);
        Ok(&self.written)
    }

    fn receive(&mut self, now_us: u64, bytes: &[u8]) -> Result<(), Infallible> {
        for byte in bytes {
            match self.decoder.push::<ToHost>(*byte) {
                Some(Ok(received)) => match received.message {
                    ToHost::Record(record) => self.record = Some(record),
                    message => self.messages.push((now_us, message)),
                },
                Some(Err(error)) => panic!("a frame of the board is not readable: {error:?}"),
                None => {}
            }
        }
        Ok(())
    }

    fn wake_at_us(&self) -> u64 {
        if !self.chunk.is_empty() {
            0
        } else if self.is_silent {
            u64::MAX
        } else {
            self.heartbeat_us
        }
    }

    fn is_done(&self) -> bool {
        false
    }
}
