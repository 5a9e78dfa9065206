//! Lines: byte streams that carry the bus, TCP or a serial device.

use std::io::{self, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use serial2::{CharSize, FlowControl, Parity, SerialPort, StopBits};

use crate::tcp_pump::is_timeout;

/// A stream with timed reads, and possibly a baud rate.
pub trait Line {
    /// Queues these bytes for sending.
    ///
    /// # Errors
    /// If the stream is broken.
    fn send(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// Received bytes, as soon as there is one; empty if none arrives until then, or
    /// the wait is interrupted. A time in the past returns the buffered bytes.
    ///
    /// # Errors
    /// If the stream is broken.
    fn receive(&mut self, until: Instant) -> io::Result<Vec<u8>>;

    /// Changes the rate of the bus. `false` if the stream has no rate of its own.
    ///
    /// # Errors
    /// If the device does not run at this rate.
    fn set_baud(&mut self, _baud: u32) -> io::Result<bool> {
        Ok(false)
    }

    /// The rate, where it can be set.
    fn baud(&self) -> Option<u32> {
        None
    }

    /// Longest time that a driver buffers received bytes.
    fn latency(&self) -> Duration {
        Duration::ZERO
    }
}

impl<L: Line + ?Sized> Line for Box<L> {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        (**self).send(bytes)
    }

    fn receive(&mut self, until: Instant) -> io::Result<Vec<u8>> {
        (**self).receive(until)
    }

    fn set_baud(&mut self, baud: u32) -> io::Result<bool> {
        (**self).set_baud(baud)
    }

    fn baud(&self) -> Option<u32> {
        (**self).baud()
    }

    fn latency(&self) -> Duration {
        (**self).latency()
    }
}

/// Longest read: more than a control link carries in 20 ms.
const CHUNK: usize = 4_096;

/// A bus over a socket, whose rate the other side sets.
#[derive(Debug)]
pub struct TcpLine(TcpStream);

impl TcpLine {
    /// A line on this connection.
    pub fn new(stream: TcpStream) -> Self {
        Self(stream)
    }
}

impl Line for TcpLine {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.0.write_all(bytes)
    }

    fn receive(&mut self, until: Instant) -> io::Result<Vec<u8>> {
        let wait = until.saturating_duration_since(Instant::now());
        self.0.set_nonblocking(wait.is_zero())?;
        if !wait.is_zero() {
            self.0.set_read_timeout(Some(wait))?;
        }
        let bytes = read_chunk(&mut self.0);
        // Writes must block until there is room.
        self.0.set_nonblocking(false)?;
        bytes
    }
}

/// A serial device.
#[derive(Debug)]
pub struct SerialLine {
    port: SerialPort,
    baud: u32,
    latency: Duration,
}

impl SerialLine {
    /// A line on this device, whose driver may buffer bytes for `latency`.
    pub fn new(port: SerialPort, baud: u32, latency: Duration) -> Self {
        Self {
            port,
            baud,
            latency,
        }
    }
}

impl Line for SerialLine {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.port.write_all(bytes)
    }

    fn receive(&mut self, until: Instant) -> io::Result<Vec<u8>> {
        let wait = until.saturating_duration_since(Instant::now());
        // The timeout has whole milliseconds; round up.
        let whole_ms = wait + Duration::from_micros(999);
        self.port.set_read_timeout(whole_ms)?;
        read_chunk(&mut self.port)
    }

    fn set_baud(&mut self, baud: u32) -> io::Result<bool> {
        let mut settings = self.port.get_configuration()?;
        settings.set_raw();
        settings.set_char_size(CharSize::Bits8);
        settings.set_parity(Parity::None);
        settings.set_stop_bits(StopBits::One);
        settings.set_flow_control(FlowControl::None);
        settings.set_baud_rate(baud)?;
        self.port.set_configuration(&settings)?;
        self.baud = baud;
        Ok(true)
    }

    fn baud(&self) -> Option<u32> {
        Some(self.baud)
    }

    fn latency(&self) -> Duration {
        self.latency
    }
}

/// Reads once; empty if nothing arrives before the stream's timeout.
pub(crate) fn read_chunk(stream: &mut impl Read) -> io::Result<Vec<u8>> {
    let mut bytes = vec![0; CHUNK];
    let count = match stream.read(&mut bytes) {
        Ok(0) => return Err(io::ErrorKind::UnexpectedEof.into()),
        Ok(count) => count,
        Err(error) if is_timeout(&error) => 0,
        Err(error) => return Err(error),
    };
    bytes.truncate(count);
    Ok(bytes)
}
