//! Searches a servo bus: every id, with the protocols of both firmwares, at every baud rate.
//!
//! ```text
//! cargo run --package armbridge-servo --example scan -- /dev/ttyUSB0
//! ```
//!
//! The port is a USB adapter that turns the line around by itself, as those of the vendor do.
//! Pings alone are sent, so that no motor moves and no register changes. Each rate takes 10 s.

use std::io::{self, ErrorKind};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use armbridge_servo::port::{BAUD_RATES, bytes_us};
use armbridge_servo::stop::{FLUSH, FLUSH_BYTES};
use armbridge_servo::{Alarms, Firmware, ReplyParser, ServoId};
use serial2::SerialPort;

/// Timeout of a reply beyond its time on the wire: a servo takes 0.8 ms at the most, an adapter
/// hands bytes over every 16 ms.
const TIMEOUT: Duration = Duration::from_millis(20);
/// Longest reply that is parsed.
const REPLY_MAX: usize = 16;

fn main() -> ExitCode {
    let Some(path) = std::env::args_os().nth(1) else {
        eprintln!("which serial port? For example: scan /dev/ttyUSB0, scan COM3");
        return ExitCode::from(2);
    };
    let found = Bus::open(&path).and_then(|mut bus| bus.scan());
    match found {
        Ok(0) => {
            println!("no servo answers; is their supply on?");
            ExitCode::FAILURE
        }
        Ok(count) => {
            println!("servos: {count}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{}: {error}", path.display());
            ExitCode::FAILURE
        }
    }
}

/// The bus at the adapter.
struct Bus {
    port: SerialPort,
    baud: u32,
    /// Whether the adapter returns each byte that it sends.
    is_echoing: bool,
}

impl Bus {
    fn open(path: &std::ffi::OsStr) -> io::Result<Self> {
        let [baud, ..] = BAUD_RATES;
        let mut port = SerialPort::open(path, baud)?;
        port.set_read_timeout(Duration::from_millis(1))?;
        Ok(Self {
            port,
            baud,
            is_echoing: false,
        })
    }

    /// Prints the servos that answer, and returns their number.
    fn scan(&mut self) -> io::Result<usize> {
        let mut found = 0;
        for baud in BAUD_RATES {
            println!("{baud} baud");
            self.set_baud(baud)?;
            // All Morpheus pings first: bytes of the other protocol may begin a packet for
            // receivers of Morpheus servos.
            for firmware in Firmware::ALL {
                for id in (0..=u8::MAX).filter_map(ServoId::new) {
                    if let Some(alarms) = self.ping(firmware, id)? {
                        found += 1;
                        println!(
                            "  id {}: {firmware}, alarms {:#04x}",
                            id.get(),
                            alarms.bits()
                        );
                    }
                }
            }
        }
        Ok(found)
    }

    /// Changes the rate. The flush, which no servo answers, ends half packets in the receivers
    /// of Morpheus servos, and shows whether the adapter echoes.
    fn set_baud(&mut self, baud: u32) -> io::Result<()> {
        let mut settings = self.port.get_configuration()?;
        settings.set_baud_rate(baud)?;
        self.port.set_configuration(&settings)?;
        self.baud = baud;
        self.port.discard_input_buffer()?;
        let flush = [FLUSH; FLUSH_BYTES as usize];
        self.port.write_all(&flush)?;
        let mut echo = Vec::new();
        self.receive(2 * flush.len(), |byte| {
            echo.push(byte);
            None::<()>
        })?;
        self.is_echoing = echo == flush;
        Ok(())
    }

    /// The alarms of the servo with this id, if it answers.
    fn ping(&mut self, firmware: Firmware, id: ServoId) -> io::Result<Option<Alarms>> {
        let query = firmware.ping_query(id);
        self.port.discard_input_buffer()?;
        self.port.write_all(&query.packet)?;
        // An echo is no reply, although a stock servo's may be equal to it.
        let mut echo_bytes = if self.is_echoing {
            query.packet.len()
        } else {
            0
        };
        let mut parser = ReplyParser::<REPLY_MAX>::to_bridge(firmware, REPLY_MAX);
        let bytes = query.packet.len() + usize::from(query.reply_bytes);
        self.receive(bytes, |byte| {
            if echo_bytes > 0 {
                echo_bytes -= 1;
                return None;
            }
            match parser.push(byte)? {
                Ok(Some(reply)) if reply.id == id.get() && firmware.is_pong(reply.data) => {
                    Some(reply.alarms)
                }
                _ => None,
            }
        })
    }

    /// Passes on received bytes until there is a result, or for the time that this many bytes
    /// take on the wire and [`TIMEOUT`].
    fn receive<T>(
        &mut self,
        bytes: usize,
        mut push: impl FnMut(u8) -> Option<T>,
    ) -> io::Result<Option<T>> {
        let wire = Duration::from_micros(bytes_us(bytes as u32, self.baud));
        let end = Instant::now() + wire + TIMEOUT;
        let mut buffer = [0; 256];
        while Instant::now() < end {
            let length = match self.port.read(&mut buffer) {
                Ok(length) => length,
                Err(error) if error.kind() == ErrorKind::TimedOut => continue,
                Err(error) => return Err(error),
            };
            if let Some(result) = buffer[..length].iter().find_map(|byte| push(*byte)) {
                return Ok(Some(result));
            }
        }
        Ok(None)
    }
}
