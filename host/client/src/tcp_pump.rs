//! TCP in wall-clock time: a host driven over a socket, and two sockets joined.

use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::Host;

/// Longest wait for bytes before the host is polled again.
const WAIT_MAX: Duration = Duration::from_millis(20);

/// Reason for the early end of a run over a socket.
#[derive(Debug)]
pub enum PumpError<H> {
    /// The connection broke.
    Io(io::Error),
    /// Error of the host.
    Host(H),
}

/// Drives `host` over `link` until it is done. Its time runs `slow` times
/// slower than the wall clock, as the board's does.
///
/// # Errors
/// If the connection breaks, or the host returns an error.
pub fn run<H: Host>(
    link: &mut TcpStream,
    host: &mut H,
    slow: u32,
) -> Result<(), PumpError<H::Error>> {
    let begun = Instant::now();
    let now_us = || begun.elapsed().as_micros() as u64 / u64::from(slow);
    let mut buffer = [0; 4096];
    while !host.is_done() {
        let bytes = host.transmit(now_us()).map_err(PumpError::Host)?;
        link.write_all(bytes).map_err(PumpError::Io)?;
        let until_wake = Duration::from_micros(host.wake_at_us().saturating_sub(now_us()));
        let until_wake = until_wake.saturating_mul(slow);
        let wait = until_wake.clamp(Duration::from_micros(100), WAIT_MAX);
        link.set_read_timeout(Some(wait)).map_err(PumpError::Io)?;
        match link.read(&mut buffer) {
            Ok(0) => return Err(PumpError::Io(io::ErrorKind::UnexpectedEof.into())),
            Ok(count) => host
                .receive(now_us(), &buffer[..count])
                .map_err(PumpError::Host)?,
            Err(error) if is_timeout(&error) => {}
            Err(error) => return Err(PumpError::Io(error)),
        }
    }
    Ok(())
}

/// Whether a read timed out or was interrupted.
pub fn is_timeout(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut | io::ErrorKind::Interrupted
    )
}

/// Copies bytes between two sockets, both ways, until either closes.
///
/// # Errors
/// If a socket cannot be duplicated.
pub fn join(a: &TcpStream, b: &TcpStream) -> io::Result<[JoinHandle<()>; 2]> {
    let copy = |from: &TcpStream, to: &TcpStream| -> io::Result<JoinHandle<()>> {
        let (mut from, mut to) = (from.try_clone()?, to.try_clone()?);
        Ok(std::thread::spawn(move || {
            // The end of one direction ends the other.
            let _ = io::copy(&mut from, &mut to);
            let _ = from.shutdown(Shutdown::Both);
            let _ = to.shutdown(Shutdown::Both);
        }))
    };
    Ok([copy(a, b)?, copy(b, a)?])
}
