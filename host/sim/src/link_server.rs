//! Link of a simulated board, served to another program on a socket or a
//! pseudo-terminal.
//!
//! Virtual time follows the wall clock, so that time-outs of the program and speeds of the
//! arm match; on a machine that cannot keep up, virtual time is slower, and nothing else
//! changes.
//!
//! # One host
//!
//! A board has one host. A second connection receives [`IN_USE`] and is closed; the first
//! is not affected. A terminal is opened exclusively by a program of this project.
//!
//! # A host that does not read
//!
//! A board does not wait for its host. Frames that do not fit into a full socket are
//! dropped completely, and the frame numbers show the host how many. A host that does not send
//! either is silent: the board brakes and switches off.

use std::io::{self, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
#[cfg(unix)]
use std::time::Duration;

use armbridge_client::Host;
use armbridge_client::endpoint::OpenError;
#[cfg(unix)]
use armbridge_client::pty::{Pty, Ready};
use armbridge_client::transport::{IN_USE, LinkUri};

use crate::nonblocking;
use crate::pacer::Pacer;

/// Virtual time between two polls of the port.
const POLL_US: u64 = 1_000;

/// Port to which programs connect.
#[derive(Debug)]
enum Port {
    /// One connection at a time, without end.
    Socket {
        listener: TcpListener,
        peer: Option<TcpStream>,
        /// A second connection. Kept until it ends: closing a socket with unread bytes
        /// would discard the [`IN_USE`] that was sent to it.
        rejected: Option<TcpStream>,
    },
    #[cfg(unix)]
    Terminal {
        controller: std::fs::File,
        pty: Pty,
        is_open: bool,
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

/// Server of a board's link, for one host at a time.
#[derive(Debug)]
pub struct LinkServer {
    port: Port,
    /// The rest of a frame that has begun to be sent.
    unsent: Vec<u8>,
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
        listener.set_nonblocking(true)?;
        Ok(Self::with_port(Port::Socket {
            listener,
            peer: None,
            rejected: None,
        }))
    }

    /// Opens a server on the port of this name; also returns the name for programs that
    /// connect.
    ///
    /// # Errors
    /// If the port does not open.
    pub fn offer(at: &LinkUri) -> Result<(Self, LinkUri), ServeError> {
        match at {
            LinkUri::Tcp(endpoint) => {
                let (listener, at) = endpoint.listen()?;
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
            unsent: Vec::new(),
            pacer: Pacer::begin(),
            next_us: 0,
            bytes: Vec::new(),
        }
    }

    fn poll(&mut self) -> io::Result<()> {
        match &mut self.port {
            Port::Socket {
                listener,
                peer,
                rejected,
            } => {
                if rejected.as_mut().is_some_and(is_gone) {
                    *rejected = None;
                }
                // Checked before the next connection is accepted: it may arrive at the same moment.
                if peer
                    .as_mut()
                    .is_some_and(|peer| !nonblocking::read(peer, &mut self.bytes))
                {
                    *peer = None;
                }
                if let (None, Some((new, _))) = (&rejected, nonblocking::accept(listener)?) {
                    if peer.is_none() {
                        *peer = Some(new);
                        self.unsent.clear();
                    } else {
                        reject(&new);
                        *rejected = Some(new);
                    }
                }
            }
            #[cfg(unix)]
            Port::Terminal {
                controller,
                pty,
                is_open,
            } => {
                *is_open = pty.wait(Duration::ZERO)? != Ready::Nobody;
                if *is_open {
                    nonblocking::read(controller, &mut self.bytes);
                } else {
                    self.unsent.clear();
                }
            }
        }
        Ok(())
    }

    /// Sends as many bytes as fit, and stores the rest of a partial frame.
    fn send(&mut self, bytes: &[u8]) {
        let stream: &mut dyn Write = match &mut self.port {
            Port::Socket {
                peer: Some(peer), ..
            } => peer,
            Port::Socket { peer: None, .. } => return,
            #[cfg(unix)]
            Port::Terminal {
                controller,
                is_open: true,
                ..
            } => controller,
            #[cfg(unix)]
            Port::Terminal { is_open: false, .. } => return,
        };
        let sent = nonblocking::write(stream, &self.unsent);
        self.unsent.drain(..sent);
        if self.unsent.is_empty() {
            let sent = nonblocking::write(stream, bytes);
            self.unsent.extend_from_slice(rest_of_frame(bytes, sent));
        }
    }
}

/// Closes a second connection after [`IN_USE`], best effort: the close alone suffices.
fn reject(mut stream: &TcpStream) {
    let _ = stream.write_all(IN_USE);
    let _ = stream.shutdown(Shutdown::Write);
}

fn is_gone(stream: &mut TcpStream) -> bool {
    !nonblocking::read(stream, &mut Vec::new())
}

/// Remainder of the frame that was cut after `sent` bytes. Complete frames follow, which
/// may be dropped.
fn rest_of_frame(bytes: &[u8], sent: usize) -> &[u8] {
    let rest = &bytes[sent..];
    if sent == 0 || bytes[sent - 1] == 0 {
        return &[];
    }
    let end = rest.iter().position(|byte| *byte == 0);
    &rest[..end.map_or(rest.len(), |end| end + 1)]
}

impl Host for LinkServer {
    type Error = io::Error;

    fn transmit(&mut self, now_us: u64) -> io::Result<&[u8]> {
        self.bytes.clear();
        if now_us >= self.next_us {
            self.next_us = now_us + POLL_US;
            self.pacer.wait(now_us);
            self.poll()?;
        }
        Ok(&self.bytes)
    }

    fn receive(&mut self, _now_us: u64, bytes: &[u8]) -> io::Result<()> {
        if !bytes.is_empty() {
            self.send(bytes);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cut_frame_is_completed() {
        let frames = [1, 2, 0, 3, 4, 0, 5, 0];
        for (sent, rest) in [
            (0, &[][..]),
            (1, &[2, 0]),
            (3, &[]),
            (4, &[4, 0]),
            (7, &[0]),
            (8, &[]),
        ] {
            assert_eq!(rest_of_frame(&frames, sent), rest, "{sent}");
        }
    }
}
