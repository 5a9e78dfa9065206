//! Link of a simulated board, served to another program on a socket or a
//! pseudo-terminal.
//!
//! Virtual time follows the wall clock, so that time-outs of the program and speeds of the
//! arm match; on a machine that cannot keep up, virtual time is slower, and nothing else
//! changes.
//!
//! # Hosts
//!
//! On a socket one host commands, any number may watch, and each may stop: see `peers`. Each
//! may touch the simulated arm: see `touching`.
//! A terminal has one host: a program of this project opens it exclusively.
//!
//! # A host that does not read
//!
//! A board does not wait for its host. Frames that do not fit into a full socket are
//! dropped completely, and the frame numbers show the host how many. A host that does not send
//! either is silent: the board brakes and switches off.

mod latest;
mod outbox;
mod peer;
mod peers;
mod touching;

use std::io;
use std::net::TcpListener;
use std::sync::mpsc::Receiver;
#[cfg(unix)]
use std::time::Duration;

use armbridge_client::Host;
use armbridge_client::endpoint::{Exposure, OpenError};
#[cfg(unix)]
use armbridge_client::pty::{Pty, Ready};
use armbridge_client::transport::LinkUri;

use crate::cosim::Interaction;
#[cfg(unix)]
use crate::nonblocking;
use crate::pacer::Pacer;
#[cfg(unix)]
use outbox::Outbox;
use peers::Peers;

/// Virtual time between two polls of the port.
const POLL_US: u64 = 1_000;

/// Bytes taken from a terminal in a poll; more wait at the sender.
#[cfg(unix)]
const READ_MAX: usize = 1_024;

/// Port to which programs connect.
#[derive(Debug)]
enum Port {
    Socket(Box<Peers>),
    #[cfg(unix)]
    Terminal {
        controller: std::fs::File,
        pty: Pty,
        is_open: bool,
        outbox: Outbox,
    },
}

/// Reason for which a link cannot be served.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// The port does not open.
    #[error(transparent)]
    Port(#[from] OpenError),
    /// The port cannot be polled.
    #[error("cannot poll the port: {0}")]
    Poll(#[from] io::Error),
    /// No pseudo-terminal is available.
    #[error("the system gives no pseudo-terminal: {0}")]
    Terminal(io::Error),
    /// This system has none.
    #[error("there are no pseudo-terminals on this system: use tcp://127.0.0.1:PORT")]
    NoTerminals,
    /// A link that cannot be served.
    #[error("a link cannot be served on {0}: expected tcp://HOST:PORT or pty:")]
    Name(LinkUri),
}

/// Server of a board's link.
#[derive(Debug)]
pub struct LinkServer {
    port: Port,
    pacer: Pacer,
    next_us: u64,
    bytes: Vec<u8>,
}

impl LinkServer {
    /// A server on this listener, without a connection.
    ///
    /// # Errors
    /// If the listener cannot be polled.
    pub fn new(listener: TcpListener) -> io::Result<Self> {
        Ok(Self::with_port(Port::Socket(Box::new(Peers::new(
            listener,
        )?))))
    }

    /// Lets programs on a socket touch the simulated arm of the [`Cosim`](crate::cosim::Cosim)
    /// that takes these interactions. A terminal has none.
    pub fn interactions(&mut self) -> Option<Receiver<Interaction>> {
        match &mut self.port {
            Port::Socket(peers) => Some(peers.touching.connect()),
            #[cfg(unix)]
            Port::Terminal { .. } => None,
        }
    }

    /// Opens a server on the port of this name; also returns the name for programs that
    /// connect.
    ///
    /// # Errors
    /// If the port does not open.
    pub fn offer(at: &LinkUri, exposure: Exposure) -> Result<(Self, LinkUri), ServeError> {
        match at {
            LinkUri::Tcp(endpoint) => {
                let (listener, at) = endpoint.listen(exposure)?;
                let host = Self::new(listener)?;
                Ok((host, LinkUri::Tcp(at)))
            }
            LinkUri::Pty(None) => Self::offer_terminal(),
            LinkUri::Usb(_) | LinkUri::Serial(_) | LinkUri::Pty(Some(_)) => {
                Err(ServeError::Name(at.clone()))
            }
        }
    }

    #[cfg(unix)]
    fn offer_terminal() -> Result<(Self, LinkUri), ServeError> {
        let pty = Pty::open().map_err(ServeError::Terminal)?;
        let at = LinkUri::Pty(Some(pty.name().into()));
        let server = Self::with_port(Port::Terminal {
            controller: nonblocking::controller(&pty).map_err(ServeError::Terminal)?,
            pty: pty.for_one(),
            is_open: false,
            outbox: Outbox::default(),
        });
        Ok((server, at))
    }

    #[cfg(not(unix))]
    fn offer_terminal() -> Result<(Self, LinkUri), ServeError> {
        Err(ServeError::NoTerminals)
    }

    fn with_port(port: Port) -> Self {
        Self {
            port,
            pacer: Pacer::begin(),
            next_us: 0,
            bytes: Vec::new(),
        }
    }

    fn poll(&mut self, now_us: u64) -> io::Result<()> {
        match &mut self.port {
            Port::Socket(peers) => peers.poll(now_us, &mut self.bytes)?,
            #[cfg(unix)]
            Port::Terminal {
                controller,
                pty,
                is_open,
                outbox,
            } => {
                *is_open = pty.wait(Duration::ZERO)? != Ready::Nobody;
                if *is_open {
                    nonblocking::read(controller, &mut self.bytes, READ_MAX);
                } else {
                    outbox.clear();
                }
            }
        }
        Ok(())
    }
}

impl Host for LinkServer {
    type Error = io::Error;

    fn transmit(&mut self, now_us: u64) -> io::Result<&[u8]> {
        self.bytes.clear();
        if now_us >= self.next_us {
            self.next_us = now_us + POLL_US;
            self.pacer.wait(now_us);
            self.poll(now_us)?;
        }
        Ok(&self.bytes)
    }

    fn receive(&mut self, _now_us: u64, bytes: &[u8]) -> io::Result<()> {
        match &mut self.port {
            _ if bytes.is_empty() => {}
            Port::Socket(peers) => peers.send(bytes),
            #[cfg(unix)]
            Port::Terminal {
                controller,
                is_open,
                outbox,
                ..
            } => {
                if *is_open {
                    outbox.send(controller, bytes);
                }
            }
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
