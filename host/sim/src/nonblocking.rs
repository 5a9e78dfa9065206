//! Non-blocking reads and writes on sockets and pseudo-terminals: another program must
//! not stop virtual time.

#[cfg(unix)]
use std::fs::File;
use std::io::{self, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};

#[cfg(unix)]
use armbridge_client::pty::Pty;
use armbridge_client::tcp_pump::is_timeout;

/// A pending connection of a non-blocking listener, itself non-blocking. One that its peer
/// has given up already is no error of the listener.
pub(crate) fn accept(listener: &TcpListener) -> io::Result<Option<(TcpStream, SocketAddr)>> {
    match listener.accept() {
        Ok((peer, address)) => {
            let ready = peer.set_nonblocking(true).and(peer.set_nodelay(true));
            Ok(ready.ok().map(|()| (peer, address)))
        }
        Err(error) if is_timeout(&error) || error.kind() == io::ErrorKind::ConnectionAborted => {
            Ok(None)
        }
        Err(error) => Err(error),
    }
}

/// Our end of a terminal, non-blocking.
#[cfg(unix)]
pub(crate) fn controller(pty: &Pty) -> io::Result<File> {
    use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};

    let controller = pty.controller()?;
    let flags = fcntl_getfl(&controller)?;
    fcntl_setfl(&controller, flags | OFlags::NONBLOCK)?;
    Ok(controller)
}

/// Appends bytes that have arrived, at most `most`; false if the stream has ended. The rest
/// stays in the system's buffers, which slows a sender down.
pub(crate) fn read(stream: &mut impl Read, into: &mut Vec<u8>, most: usize) -> bool {
    let mut chunk = [0; 1024];
    let mut left = most;
    while left > 0 {
        let room = left.min(chunk.len());
        match stream.read(&mut chunk[..room]) {
            Ok(count @ 1..) => {
                into.extend_from_slice(&chunk[..count]);
                left -= count;
            }
            Err(error) if is_timeout(&error) => return true,
            Ok(0) | Err(_) => return false,
        }
    }
    true
}

/// Writes as many bytes as there is room for, and returns their number. The end of a
/// stream shows when it is read.
pub(crate) fn write(stream: &mut dyn Write, bytes: &[u8]) -> usize {
    let mut sent = 0;
    while sent < bytes.len() {
        match stream.write(&bytes[sent..]) {
            Ok(count @ 1..) => sent += count,
            Ok(0) | Err(_) => break,
        }
    }
    sent
}
