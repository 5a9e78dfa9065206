//! Master of the bus, one exchange at a time: sends a request, and decodes the received
//! bytes until the reply is complete, or times out.
//!
//! Whether the line echoes is detected at the start, and at each rate, by bytes
//! that no servo answers: 210 times 0xFF, which also reset every Morpheus
//! servo's receiver to the start of a packet.

use std::io;
use std::time::{Duration, Instant};

use armbridge_servo::morpheus::{self, HEADER};
use armbridge_servo::{Alarms, Firmware};

use super::diagnosis::{Diagnosis, Refusal};
use super::line::Line;
use super::request::Request;
use super::response::{Packet, Response};

/// Timeout of a reply beyond its time on the wire: USB, sockets and two loaded systems. A
/// servo takes 0.5 ms at the most.
pub const PATIENCE: Duration = Duration::from_millis(20);
/// Silence after a reply that excludes a second one: the longest return delay of a stock
/// servo, with a margin for the system.
const SECOND_REPLY_TIME: Duration = Duration::from_millis(3);
/// Factor of the first timeout, before the echo is detected: an adapter may still be
/// starting.
const FIRST_PATIENCE: u32 = 5;
/// Timeout of the echo, on a line that echoes: a late echo must not be decoded as the next
/// reply.
const ECHO_MAX: Duration = Duration::from_secs(3);
/// Bytes of a flush: more than a Morpheus servo can still expect.
const FLUSH: [u8; 210] = [0xFF; 210];
/// Assumed rate of a line whose rate cannot be read.
const BAUD: u32 = 1_000_000;
/// Bits of a byte on the wire.
const BITS: u32 = 10;
/// Overhead of a packet in bytes, in the longer protocol.
const OVERHEAD_BYTES: usize = 6;
/// Timeout of a START slot, per unit of the id: twice the 4.74 ms of a servo.
const START_SLOT: Duration = Duration::from_millis(10);
/// Attempts at a request without a valid reply.
const ATTEMPTS: usize = 3;
/// Limit of discarded chunks of old bytes: a line may never be silent.
const STALE_MAX: usize = 100;

/// Reason for which there is no reply.
#[derive(Debug, thiserror::Error)]
pub enum BusError {
    /// The stream itself failed.
    #[error("the port failed: {0}; was it unplugged, or has the other side closed it?")]
    Line(#[from] io::Error),
    /// Error of the exchange on a working stream.
    #[error(transparent)]
    Diagnosis(#[from] Diagnosis),
    /// No request exists for this access.
    #[error("no safe request asks for this")]
    NoRequest,
}

/// End of reception.
#[derive(Clone, Copy, Debug)]
enum ReceiveUntil {
    /// After this time.
    Timeout(Duration),
    /// After silence that follows a reply, or after this time.
    ReplyOrTimeout(Duration),
}

/// Master of a bus. There must be only one.
#[derive(Debug)]
pub struct BusMaster<L> {
    line: L,
    patience: Duration,
    echoes: bool,
}

impl<L: Line> BusMaster<L> {
    /// A master on this line. Flushes the servos' receivers.
    ///
    /// # Errors
    /// If the stream fails.
    pub fn new(line: L, patience: Duration) -> io::Result<Self> {
        let patience = patience + 2 * line.latency();
        let mut client = Self {
            line,
            patience,
            echoes: false,
        };
        client.detect_echo(FIRST_PATIENCE * patience)?;
        Ok(client)
    }

    /// Rate of the bus, where it can be set.
    pub fn baud(&self) -> Option<u32> {
        self.line.baud()
    }

    /// Whether the line echoes.
    pub fn echoes(&self) -> bool {
        self.echoes
    }

    /// Changes the rate, and flushes. `false` if it cannot be changed.
    ///
    /// # Errors
    /// If the stream fails, or does not support the rate.
    pub fn set_baud(&mut self, baud: u32) -> io::Result<bool> {
        let is_changed = self.line.set_baud(baud)?;
        if is_changed {
            self.detect_echo(self.patience)?;
        }
        Ok(is_changed)
    }

    /// Sends a request once.
    ///
    /// # Errors
    /// If the stream fails, or the reply is missing or not valid.
    pub fn ask(&mut self, request: &Request) -> Result<Packet, BusError> {
        let reply = OVERHEAD_BYTES + request.reply_data;
        let time =
            self.on_wire(request.bytes.len() + reply) + request.execution_time + self.patience;
        let response = self.exchange(
            request.firmware,
            &request.bytes,
            ReceiveUntil::ReplyOrTimeout(time),
        )?;
        Ok(response.answer(request)?)
    }

    /// Sends a request until there is a valid reply or a refusal, three times at most.
    ///
    /// # Errors
    /// Like [`BusMaster::ask`], for the last attempt.
    pub(crate) fn request_with_retries(&mut self, request: &Request) -> Result<Packet, BusError> {
        for _ in 1..ATTEMPTS {
            match self.ask(request) {
                Err(BusError::Diagnosis(diagnosis))
                    if !matches!(diagnosis, Diagnosis::Refused(_)) => {}
                settled => return settled,
            }
        }
        self.ask(request)
    }

    /// The alarms of the servo with this id, if there is one with this firmware.
    /// Silence is accepted at once; after any other error the ping is repeated.
    ///
    /// # Errors
    /// If the stream fails, or an invalid reply was received.
    pub fn ping(&mut self, firmware: Firmware, id: u8) -> Result<Option<Alarms>, BusError> {
        let Some(request) = Request::ping(firmware, id) else {
            return Ok(None);
        };
        let mut attempt = 1;
        loop {
            match self.ask(&request) {
                Ok(packet) => return Ok(Some(packet.alarms)),
                // The servo is present with any alarms. But every servo executes PING:
                // only the board, in a loop, refuses one.
                Err(BusError::Diagnosis(Diagnosis::Refused(Refusal::Alarms(alarms))))
                    if !alarms.contains(Alarms::INSTRUCTION) =>
                {
                    return Ok(Some(alarms));
                }
                Err(BusError::Diagnosis(Diagnosis::Silence | Diagnosis::EchoOnly)) => {
                    return Ok(None);
                }
                Err(BusError::Diagnosis(_)) if attempt < ATTEMPTS => attempt += 1,
                Err(error) => return Err(error),
            }
        }
    }

    /// Positions of all started Morpheus servos, as (id, counts).
    ///
    /// # Errors
    /// If the stream fails.
    pub fn cycle(&mut self) -> io::Result<Vec<(u8, u16)>> {
        let request = morpheus::Request::Cycle.encode();
        let time = self.on_wire(FLUSH.len()) + self.patience;
        let response = self.exchange(
            Firmware::Morpheus,
            &request,
            ReceiveUntil::ReplyOrTimeout(time),
        )?;
        let position = |packet: &Packet| {
            let counts = u16::from_be_bytes(packet.data.as_slice().try_into().ok()?);
            (counts <= 1023).then_some((packet.from, counts))
        };
        Ok(response.packets.iter().filter_map(position).collect())
    }

    /// Starts all Morpheus servos up to this id one after the other, after which they
    /// take part in [`BusMaster::cycle`]. Takes 10 ms for each id.
    ///
    /// # Errors
    /// If the stream fails.
    pub fn start(&mut self, highest_id: u8) -> io::Result<()> {
        let request = morpheus::Request::Start.encode();
        let time = START_SLOT * u32::from(highest_id) + self.patience;
        self.exchange(Firmware::Morpheus, &request, ReceiveUntil::Timeout(time))?;
        Ok(())
    }

    /// Sends a request, and decodes the received bytes.
    fn exchange<'a>(
        &mut self,
        firmware: Firmware,
        request: &'a [u8],
        end: ReceiveUntil,
    ) -> io::Result<Response<'a>> {
        self.discard_input()?;
        let echo = if self.echoes { request } else { &[] };
        let mut response = Response::new(firmware, echo);
        let mut has_header = request.contains(&HEADER);
        self.line.send(request)?;
        let (ReceiveUntil::Timeout(time) | ReceiveUntil::ReplyOrTimeout(time)) = end;
        let sent_max = if self.echoes {
            ECHO_MAX
        } else {
            Duration::ZERO
        };
        let mut until = Instant::now() + time + sent_max;
        loop {
            let bytes = self.line.receive(until)?;
            if bytes.is_empty() {
                if Instant::now() >= until {
                    break;
                }
                continue;
            }
            has_header |= bytes.contains(&HEADER);
            let was_sent = response.is_echoed();
            for byte in bytes {
                response.push(byte);
            }
            let now = Instant::now();
            if !was_sent && response.is_echoed() {
                // The request is sent now: the servo's time begins.
                until = now + time;
            }
            if matches!(end, ReceiveUntil::ReplyOrTimeout(_)) && response.has_complete_packet() {
                until = until.min(now + SECOND_REPLY_TIME + self.on_wire(1));
            }
        }
        if !response.is_echoed() {
            let text = "the bus no longer echoes the host's own bytes";
            return Err(io::Error::new(io::ErrorKind::TimedOut, text));
        }
        // A Morpheus servo takes the bytes after its header for a packet: LEN of 2,
        // as in a ping of stock servo 170, blocks its receiver.
        if firmware == Firmware::Stock && has_header {
            self.flush(self.patience)?;
        }
        Ok(response)
    }

    /// Flushes, and detects whether the line echoes. One that has echoed always
    /// does.
    fn detect_echo(&mut self, patience: Duration) -> io::Result<()> {
        let echoed = self.flush(patience)?;
        self.echoes |= echoed > FLUSH.len() / 2;
        Ok(())
    }

    /// Flushes; returns the number of bytes that came back.
    fn flush(&mut self, patience: Duration) -> io::Result<usize> {
        self.discard_input()?;
        self.line.send(&FLUSH)?;
        let deadline = Instant::now() + self.on_wire(FLUSH.len()) + patience;
        let mut echoed = 0;
        while echoed < FLUSH.len() {
            let mut bytes = self.line.receive(deadline)?;
            if bytes.is_empty() && Instant::now() >= deadline {
                break;
            }
            // A late reply may be among them.
            bytes.retain(|byte| FLUSH.contains(byte));
            echoed += bytes.len();
        }
        Ok(echoed)
    }

    /// Discards bytes received earlier.
    fn discard_input(&mut self) -> io::Result<()> {
        for _ in 0..STALE_MAX {
            if self.line.receive(Instant::now())?.is_empty() {
                break;
            }
        }
        Ok(())
    }

    /// Duration of this many bytes.
    fn on_wire(&self, bytes: usize) -> Duration {
        let baud = self.line.baud().unwrap_or(BAUD);
        let bits = bytes as u32 * BITS;
        Duration::from_secs(1) * bits / baud
    }
}
