//! The stream that carries the bus: TCP or a serial device.

use std::io::{self, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use serial2::{CharSize, FlowControl, Parity, SerialPort, StopBits};

use crate::tcp_pump::is_timeout;

/// Bytes out, and bytes in until a time.
pub trait Line {
    /// Hands these bytes over to be sent.
    ///
    /// # Errors
    /// If the stream is broken.
    fn send(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// What has come, as soon as it is at least one byte; empty if nothing does
    /// until then, or something else wakes us. A time that is past means: what
    /// is there already.
    ///
    /// # Errors
    /// If the stream is broken.
    fn receive(&mut self, until: Instant) -> io::Result<Vec<u8>>;

    /// Changes the rate of the bus. `false` if that cannot be done from here.
    ///
    /// # Errors
    /// If the device does not go along.
    fn set_baud(&mut self, baud: u32) -> io::Result<bool>;

    /// The rate, where it can be set from here.
    fn baud(&self) -> Option<u32>;

    /// How long bytes may lie about between the bus and us.
    fn latency(&self) -> Duration;
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

/// Longest read: more than comes of a control link in 20 ms.
const CHUNK: usize = 4_096;

/// A bus whose rate the other side of a socket decides.
#[derive(Debug)]
pub struct TcpLine(TcpStream);

impl TcpLine {
    /// Over this connection.
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
        let mut bytes = vec![0; CHUNK];
        let came = self.0.read(&mut bytes);
        // Writing must wait for room.
        self.0.set_nonblocking(false)?;
        taken(came, bytes)
    }

    fn set_baud(&mut self, _baud: u32) -> io::Result<bool> {
        Ok(false)
    }

    fn baud(&self) -> Option<u32> {
        None
    }

    fn latency(&self) -> Duration {
        Duration::ZERO
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
    /// On this device, whose driver may keep bytes back for `latency`.
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
        // The timeout has whole milliseconds, of which none is left out.
        let whole_ms = wait + Duration::from_micros(999);
        self.port.set_read_timeout(whole_ms)?;
        let mut bytes = vec![0; CHUNK];
        let came = self.port.read(&mut bytes);
        taken(came, bytes)
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

/// The bytes that a read has left in `bytes`; none if it found nothing in time.
pub(crate) fn taken(came: io::Result<usize>, mut bytes: Vec<u8>) -> io::Result<Vec<u8>> {
    let count = match came {
        Ok(0) => return Err(io::ErrorKind::UnexpectedEof.into()),
        Ok(count) => count,
        Err(error) if is_timeout(&error) => 0,
        Err(error) => return Err(error),
    };
    bytes.truncate(count);
    Ok(bytes)
}
