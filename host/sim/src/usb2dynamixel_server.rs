//! Transparent port of a simulated board, served to another program on a socket, or on a
//! pseudo-terminal in place of a serial port.
//!
//! Virtual time follows the wall clock, so that time-outs of the program match; on a
//! machine that cannot keep up, virtual time is slower, and nothing else changes.
//!
//! # Bounds
//!
//! One program at a time is served, and the next one waits. A program that has been silent
//! for 5 s gives way to it. Bytes for which the board has no room wait at the
//! program.

#[cfg(unix)]
use std::fs::File;
use std::io::{self, Write};
use std::net::{TcpListener, TcpStream};

use armbridge_board::bridge::transparent_port::ClientLine;
#[cfg(unix)]
use armbridge_client::pty::Pty;

use crate::cosim::PortClient;
use crate::nonblocking;
use crate::pacer::Pacer;

/// Virtual time between two polls of the port.
const POLL_US: u64 = 500;
/// Bytes taken in a poll and kept for the board: several times what the bus carries in it.
const READ_MAX: usize = 1_024;
/// Silence after which another program takes the port over, in virtual time.
const SILENCE_US: u64 = 5_000_000;

/// Port to which the program connects.
#[derive(Debug)]
enum Port {
    /// One connection at a time, without end. A socket has no rate.
    Socket {
        listener: TcpListener,
        peer: Option<TcpStream>,
        /// Time of its last bytes, or of its connection.
        heard_us: u64,
    },
    /// Always open: whether a program has it open is not known.
    #[cfg(unix)]
    Terminal { controller: File, _pty: Pty },
}

/// Server of the port, for one program at a time.
#[derive(Debug)]
pub struct PortServer {
    port: Port,
    pacer: Pacer,
    next_us: u64,
    bytes: Vec<u8>,
    /// Bytes that wait for room in the board.
    waiting: usize,
}

impl PortServer {
    /// A server on this listener, without a connection.
    ///
    /// # Errors
    /// If the listener cannot be polled.
    pub fn on_socket(listener: TcpListener) -> io::Result<Self> {
        listener.set_nonblocking(true)?;
        Ok(Self::with_port(Port::Socket {
            listener,
            peer: None,
            heard_us: 0,
        }))
    }

    /// A server on a terminal, whose rate the program sets.
    ///
    /// # Errors
    /// If the terminal cannot be polled.
    #[cfg(unix)]
    pub fn on_terminal(pty: Pty) -> io::Result<Self> {
        Ok(Self::with_port(Port::Terminal {
            controller: nonblocking::controller(&pty)?,
            _pty: pty,
        }))
    }

    fn with_port(port: Port) -> Self {
        Self {
            port,
            pacer: Pacer::begin(),
            next_us: 0,
            bytes: Vec::new(),
            waiting: 0,
        }
    }

    fn poll(&mut self, now_us: u64) {
        let room = READ_MAX.saturating_sub(self.waiting);
        match &mut self.port {
            Port::Socket {
                listener,
                peer,
                heard_us,
            } => {
                if let Some(stream) = peer
                    && !nonblocking::read(stream, &mut self.bytes, room)
                {
                    *peer = None;
                }
                // One that is kept waiting cannot be heard.
                if !self.bytes.is_empty() || room == 0 {
                    *heard_us = now_us;
                }
                let is_silent = now_us.saturating_sub(*heard_us) > SILENCE_US;
                // A listener that fails accepts no program.
                if (peer.is_none() || is_silent)
                    && let Some((next, _)) = nonblocking::accept(listener).ok().flatten()
                {
                    *peer = Some(next);
                    *heard_us = now_us;
                }
            }
            #[cfg(unix)]
            Port::Terminal { controller, .. } => {
                nonblocking::read(controller, &mut self.bytes, room);
            }
        }
    }
}

impl PortClient for PortServer {
    fn line(&self) -> ClientLine {
        match &self.port {
            Port::Socket { peer, .. } => ClientLine {
                is_open: peer.is_some(),
                baud: 0,
            },
            #[cfg(unix)]
            Port::Terminal { controller, .. } => ClientLine {
                is_open: true,
                baud: Pty::baud(controller).unwrap_or(0),
            },
        }
    }

    fn set_waiting(&mut self, bytes: usize) {
        self.waiting = bytes;
    }

    fn transmit(&mut self, now_us: u64) -> Vec<u8> {
        if now_us >= self.next_us {
            self.next_us = now_us + POLL_US;
            self.pacer.wait(now_us);
            self.poll(now_us);
        }
        std::mem::take(&mut self.bytes)
    }

    fn receive(&mut self, _now_us: u64, bytes: &[u8]) {
        if bytes.is_empty() {
            return;
        }
        match &mut self.port {
            Port::Socket { peer, .. } => {
                // Closed, or so far behind that its socket is full: either way it
                // must not block the board.
                if peer
                    .as_mut()
                    .is_some_and(|peer| peer.write_all(bytes).is_err())
                {
                    *peer = None;
                }
            }
            #[cfg(unix)]
            Port::Terminal { controller, .. } => {
                // A terminal that is not read fills up; then the bytes are dropped.
                let _ = controller.write_all(bytes);
            }
        }
    }

    fn wake_at_us(&self) -> u64 {
        self.next_us
    }
}
