//! A host program on a socket or a pseudo-terminal, at the link of a board in virtual
//! time.
//!
//! Virtual time is held back to the wall clock, so that a program that thinks
//! in seconds finds the arm as fast as it should be; on a machine that cannot
//! keep up it is slower, and nothing else changes.
//!
//! # One host
//!
//! A board has one host. Whoever connects while somebody has the link is told
//! [`IN_USE`] and closed; the first is not disturbed. A terminal is opened by our own
//! program for itself alone.
//!
//! # Who does not read
//!
//! A board does not wait for its host. What a full socket does not take is lost, whole
//! frames at a time, and their numbers tell the host how many. A host that does not
//! speak either is found silent by the board itself, which brakes and switches off.

use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
#[cfg(unix)]
use std::time::Duration;

use crate::pacer::Pacer;
use armbridge_client::Host;
use armbridge_client::endpoint::OpenError;
use armbridge_client::tcp_pump::is_timeout;
use armbridge_client::transport::{IN_USE, LinkUri};

/// Virtual time between two looks at the socket.
const LOOK_US: u64 = 1_000;

/// Where programs come from.
#[derive(Debug)]
enum Port {
    /// One connection at a time, for ever.
    Socket {
        listener: TcpListener,
        peer: Option<TcpStream>,
        /// Was told that there is one already. Kept until it has gone: closing before
        /// it has said all that it wants to would take back what it was told.
        turned_away: Option<TcpStream>,
    },
    #[cfg(unix)]
    Terminal {
        controller: std::fs::File,
        pty: armbridge_client::pty::Pty,
        is_open: bool,
    },
}

/// Why a link cannot be served.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// The port does not open.
    #[error(transparent)]
    Port(#[from] OpenError),
    /// The port cannot be polled.
    #[error("cannot poll the port: {0}")]
    Poll(#[from] io::Error),
    /// The system gives no pseudo-terminal.
    #[error("the system gives no pseudo-terminal: {0}")]
    Terminal(io::Error),
    /// This system has none.
    #[error("there are no pseudo-terminals on this system: use tcp://127.0.0.1:PORT")]
    NoTerminals,
    /// A link that cannot be served.
    #[error("a link cannot be served on {0}: expected tcp://HOST:PORT or pty:")]
    Name(LinkUri),
}

/// Hosts that connect, one at a time, without end.
#[derive(Debug)]
pub struct LinkServer {
    port: Port,
    /// The rest of a frame that has begun to be sent.
    unsent: Vec<u8>,
    held: Pacer,
    next_us: u64,
    bytes: Vec<u8>,
}

impl LinkServer {
    /// Nobody has connected yet.
    ///
    /// # Errors
    /// If the listener cannot be polled.
    pub fn new(listener: TcpListener) -> io::Result<Self> {
        listener.set_nonblocking(true)?;
        Ok(Self::at(Port::Socket {
            listener,
            peer: None,
            turned_away: None,
        }))
    }

    /// The same on a pseudo-terminal that nobody has opened yet.
    ///
    /// # Errors
    /// If the terminal cannot be polled.
    #[cfg(unix)]
    pub fn on_terminal(pty: armbridge_client::pty::Pty) -> io::Result<Self> {
        use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};

        let controller = pty.controller()?;
        let flags = fcntl_getfl(&controller)?;
        fcntl_setfl(&controller, flags | OFlags::NONBLOCK)?;
        Ok(Self::at(Port::Terminal {
            controller,
            pty: pty.for_one(),
            is_open: false,
        }))
    }

    /// Serves a board's link under this name; gives back the name under which others find
    /// it.
    ///
    /// # Errors
    /// If that is not possible.
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
        let pty = armbridge_client::pty::Pty::open().map_err(ServeError::Terminal)?;
        let at = LinkUri::Pty(Some(pty.name().into()));
        let server = Self::on_terminal(pty).map_err(ServeError::Terminal)?;
        Ok((server, at))
    }

    #[cfg(not(unix))]
    fn offer_terminal() -> Result<(Self, LinkUri), ServeError> {
        Err(ServeError::NoTerminals)
    }

    fn at(port: Port) -> Self {
        Self {
            port,
            unsent: Vec::new(),
            held: Pacer::begin(),
            next_us: 0,
            bytes: Vec::new(),
        }
    }

    fn look(&mut self) -> io::Result<()> {
        match &mut self.port {
            Port::Socket {
                listener,
                peer,
                turned_away,
            } => {
                if turned_away.as_mut().is_some_and(is_gone) {
                    *turned_away = None;
                }
                // Before the next one is asked in: he may come in the same moment.
                if peer
                    .as_mut()
                    .is_some_and(|peer| !read(peer, &mut self.bytes))
                {
                    *peer = None;
                }
                if let (None, Some(came)) = (&turned_away, accept(listener)?) {
                    if peer.is_none() {
                        *peer = Some(came);
                        self.unsent.clear();
                    } else {
                        turn_away(&came);
                        *turned_away = Some(came);
                    }
                }
            }
            #[cfg(unix)]
            Port::Terminal {
                controller,
                pty,
                is_open,
            } => {
                *is_open = pty.wait(Duration::ZERO)? != armbridge_client::pty::Ready::Nobody;
                if *is_open {
                    read(controller, &mut self.bytes);
                } else {
                    self.unsent.clear();
                }
            }
        }
        Ok(())
    }

    /// Sends as much as there is room for.
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
        let sent = pass(stream, &self.unsent);
        self.unsent.drain(..sent);
        if self.unsent.is_empty() {
            let sent = pass(stream, bytes);
            self.unsent.extend_from_slice(rest_of_frame(bytes, sent));
        }
    }
}

/// Somebody who waits to be let in.
fn accept(listener: &TcpListener) -> io::Result<Option<TcpStream>> {
    match listener.accept() {
        Ok((peer, _)) => {
            peer.set_nonblocking(true)?;
            peer.set_nodelay(true)?;
            Ok(Some(peer))
        }
        Err(error) if is_timeout(&error) => Ok(None),
        Err(error) => Err(error),
    }
}

/// Best effort: whoever is closed without a word knows as well.
fn turn_away(mut stream: &TcpStream) {
    let _ = stream.write_all(IN_USE);
    let _ = stream.shutdown(Shutdown::Write);
}

fn is_gone(stream: &mut TcpStream) -> bool {
    !read(stream, &mut Vec::new())
}

/// Reads what is there; false if it has ended.
fn read(stream: &mut impl Read, into: &mut Vec<u8>) -> bool {
    let mut chunk = [0; 1024];
    loop {
        match stream.read(&mut chunk) {
            Ok(count @ 1..) => into.extend_from_slice(&chunk[..count]),
            Err(error) if is_timeout(&error) => return true,
            Ok(0) | Err(_) => return false,
        }
    }
}

/// How much of it was taken. A stream that is gone is seen when it is read.
fn pass(stream: &mut dyn Write, bytes: &[u8]) -> usize {
    let mut sent = 0;
    while sent < bytes.len() {
        match stream.write(&bytes[sent..]) {
            Ok(count @ 1..) => sent += count,
            Ok(0) | Err(_) => break,
        }
    }
    sent
}

/// What must still be sent of the frame that was cut after so many bytes: the rest is
/// whole frames, which may be lost.
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
            self.next_us = now_us + LOOK_US;
            self.held.wait(now_us);
            self.look()?;
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
    fn a_frame_that_has_begun_is_ended() {
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
