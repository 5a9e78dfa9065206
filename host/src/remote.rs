//! A host program on a socket, at the link of a board in virtual time.
//!
//! Virtual time is held back to the wall clock, so that a program that thinks
//! in seconds finds the arm as fast as it should be; on a machine that cannot
//! keep up it is slower, and nothing else changes.

use std::io::{self, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::time::{Duration, Instant};

use crate::bench::cosim::Host;
use crate::wall::is_timeout;

/// Virtual time between two looks at the socket.
const LOOK_US: u64 = 1_000;

/// Whoever connects, one at a time, for ever.
#[derive(Debug)]
pub struct RemoteHost {
    listener: TcpListener,
    peer: Option<TcpStream>,
    epoch: Instant,
    next_us: u64,
    bytes: Vec<u8>,
}

impl RemoteHost {
    /// Nobody has connected yet.
    ///
    /// # Errors
    /// If the listener cannot be polled.
    pub fn new(listener: TcpListener) -> io::Result<Self> {
        listener.set_nonblocking(true)?;
        Ok(Self {
            listener,
            peer: None,
            epoch: Instant::now(),
            next_us: 0,
            bytes: Vec::new(),
        })
    }

    fn look(&mut self) -> io::Result<()> {
        if self.peer.is_none() {
            match self.listener.accept() {
                Ok((peer, _)) => {
                    peer.set_nonblocking(true)?;
                    peer.set_nodelay(true)?;
                    self.peer = Some(peer);
                }
                Err(error) if is_timeout(&error) => {}
                Err(error) => return Err(error),
            }
        }
        let mut chunk = [0; 1024];
        while let Some(peer) = &mut self.peer {
            match peer.read(&mut chunk) {
                Ok(count @ 1..) => self.bytes.extend_from_slice(&chunk[..count]),
                Err(error) if is_timeout(&error) => break,
                // Gone, however: the next one may come.
                Ok(0) | Err(_) => self.peer = None,
            }
        }
        Ok(())
    }
}

impl Host for RemoteHost {
    type Error = io::Error;

    fn speak(&mut self, now_us: u64) -> io::Result<&[u8]> {
        self.bytes.clear();
        if now_us >= self.next_us {
            self.next_us = now_us + LOOK_US;
            let due = self.epoch + Duration::from_micros(now_us);
            std::thread::sleep(due.saturating_duration_since(Instant::now()));
            self.look()?;
        }
        Ok(&self.bytes)
    }

    fn hear(&mut self, _now_us: u64, bytes: &[u8]) -> io::Result<()> {
        let sent = match &mut self.peer {
            Some(peer) if !bytes.is_empty() => peer.write_all(bytes),
            _ => Ok(()),
        };
        if sent.is_err() {
            // Gone, or so far behind that its socket is full: either way it
            // must not hold up the board.
            self.peer = None;
        }
        Ok(())
    }

    fn wake_at_us(&self) -> u64 {
        self.next_us
    }

    fn is_done(&self) -> bool {
        false
    }
}
