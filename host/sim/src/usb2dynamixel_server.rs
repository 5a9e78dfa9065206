//! Another program at the board's transparent port: on a socket, or on a
//! pseudo-terminal that it takes for a serial port.
//!
//! Virtual time is held back to the wall clock, so that a program whose time-outs
//! are in seconds finds servos as quick as they should be; on a machine that
//! cannot keep up they are slower, and nothing else changes.

use std::fs::File;
use std::io::{self, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::time::{Duration, Instant};

use armbridge_shared::bridge::gateway::ClientLine;

use crate::cosim::PortClient;
#[cfg(unix)]
use armbridge_client::pty::Pty;
use armbridge_client::tcp_pump::is_timeout;

/// Virtual time between two looks at the port.
const LOOK_US: u64 = 500;

/// Where the program is.
#[derive(Debug)]
enum Port {
    /// One connection at a time, for ever. A socket has no speed.
    Socket {
        listener: TcpListener,
        peer: Option<TcpStream>,
    },
    /// Nobody can tell whether somebody has it open.
    #[cfg(unix)]
    Terminal { controller: File, _pty: Pty },
}

/// Whoever opens the port.
#[derive(Debug)]
pub struct PortServer {
    port: Port,
    epoch: Instant,
    next_us: u64,
    bytes: Vec<u8>,
}

impl PortServer {
    /// Nobody has connected yet.
    ///
    /// # Errors
    /// If the listener cannot be polled.
    pub fn on_socket(listener: TcpListener) -> io::Result<Self> {
        listener.set_nonblocking(true)?;
        Ok(Self::at(Port::Socket {
            listener,
            peer: None,
        }))
    }

    /// On a terminal, whose speed is what the other side sets.
    ///
    /// # Errors
    /// If the terminal cannot be polled.
    #[cfg(unix)]
    pub fn on_terminal(pty: Pty) -> io::Result<Self> {
        let controller = pty.controller()?;
        let flags = rustix::fs::fcntl_getfl(&controller)?;
        rustix::fs::fcntl_setfl(&controller, flags | rustix::fs::OFlags::NONBLOCK)?;
        Ok(Self::at(Port::Terminal {
            controller,
            _pty: pty,
        }))
    }

    fn at(port: Port) -> Self {
        Self {
            port,
            epoch: Instant::now(),
            next_us: 0,
            bytes: Vec::new(),
        }
    }

    fn look(&mut self) {
        let mut chunk = [0; 1024];
        match &mut self.port {
            Port::Socket { listener, peer } => {
                if peer.is_none() {
                    *peer = accept(listener);
                }
                while let Some(stream) = peer {
                    match stream.read(&mut chunk) {
                        Ok(count @ 1..) => self.bytes.extend_from_slice(&chunk[..count]),
                        Err(error) if is_timeout(&error) => break,
                        // Gone, however: the next one may come.
                        Ok(0) | Err(_) => *peer = None,
                    }
                }
            }
            #[cfg(unix)]
            Port::Terminal { controller, .. } => {
                while let Ok(count @ 1..) = controller.read(&mut chunk) {
                    self.bytes.extend_from_slice(&chunk[..count]);
                }
            }
        }
    }
}

/// Somebody who waits to be let in. A listener that fails lets nobody in.
fn accept(listener: &TcpListener) -> Option<TcpStream> {
    let (peer, _) = listener.accept().ok()?;
    peer.set_nonblocking(true).ok()?;
    peer.set_nodelay(true).ok()?;
    Some(peer)
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

    fn transmit(&mut self, now_us: u64) -> Vec<u8> {
        if now_us >= self.next_us {
            self.next_us = now_us + LOOK_US;
            let due = self.epoch + Duration::from_micros(now_us);
            std::thread::sleep(due.saturating_duration_since(Instant::now()));
            self.look();
        }
        std::mem::take(&mut self.bytes)
    }

    fn receive(&mut self, _now_us: u64, bytes: &[u8]) {
        if bytes.is_empty() {
            return;
        }
        match &mut self.port {
            Port::Socket { peer, .. } => {
                // Gone, or so far behind that its socket is full: either way it
                // must not hold up the board.
                if peer
                    .as_mut()
                    .is_some_and(|peer| peer.write_all(bytes).is_err())
                {
                    *peer = None;
                }
            }
            #[cfg(unix)]
            Port::Terminal { controller, .. } => {
                // A terminal that nobody reads is full some day; what is lost
                // then was for nobody.
                let _ = controller.write_all(bytes);
            }
        }
    }

    fn wake_at_us(&self) -> u64 {
        self.next_us
    }
}
