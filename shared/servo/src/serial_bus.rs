//! A [`Bus`] made of any serial port and pin: `embedded-hal-nb`'s serial traits, `embedded-hal`'s
//! output pin.
//!
//! It polls: the pin is lowered in the first call of [`Bus::transmission`] after the port's
//! `flush` reports the last stop bit, and a port that holds few bytes is filled a byte's time
//! after another. The port must receive while nothing is polled, a tick's replies at the least.

use super::bus::{Bus, LineAfter, Received, SEND_MAX, Transmission};
use super::port::{SERVO_BAUD_MAX, SetBaud};
use embedded_hal::digital::OutputPin;
use embedded_hal_nb::serial::{Error, Read, Write};
use heapless::Vec;

/// Bytes passed on at once.
const RECEIVED_MAX: usize = 64;

/// A bus on a serial port and a direction pin, high to send.
#[derive(Debug)]
pub struct SerialBus<S, D> {
    serial: S,
    direction: D,
    /// The transmission, and the number of its bytes that the port has taken.
    outgoing: Vec<u8, SEND_MAX>,
    taken: usize,
    /// Whether the last stop bit is still to be seen leaving.
    is_sending: bool,
    after: LineAfter,
    received: Vec<u8, RECEIVED_MAX>,
}

impl<S, D: OutputPin> SerialBus<S, D> {
    /// A bus with its line released.
    pub fn new(serial: S, direction: D) -> Self {
        let mut bus = Self {
            serial,
            direction,
            outgoing: Vec::new(),
            taken: 0,
            is_sending: false,
            after: LineAfter::Released,
            received: Vec::new(),
        };
        bus.drive(false);
        bus
    }

    /// Turns the line driver on or off. A pin that fails has no remedy here;
    /// the missing replies show it.
    fn drive(&mut self, on: bool) {
        let _ = self.direction.set_state(on.into());
    }
}

impl<S: Write<u8>, D> SerialBus<S, D> {
    /// Passes bytes to the port while it takes them; whether it has taken all.
    fn fill(&mut self) -> bool {
        while let Some(byte) = self.outgoing.get(self.taken) {
            match self.serial.write(*byte) {
                Err(nb::Error::WouldBlock) => return false,
                // A byte that the port refuses is missing on the wire: the servos'
                // checksum detects it.
                Ok(()) | Err(nb::Error::Other(_)) => self.taken += 1,
            }
        }
        true
    }
}

impl<S, D> Bus for SerialBus<S, D>
where
    S: Read<u8> + Write<u8> + SetBaud,
    D: OutputPin,
{
    const RELEASES_BY_ITSELF: bool = false;
    /// The fastest of any servo: which rates a port has, its traits do not say.
    const BAUD_MAX: u32 = SERVO_BAUD_MAX;

    fn set_baud(&mut self, baud: u32) {
        self.serial.set_baud(baud);
    }

    fn send(&mut self, bytes: &[u8], after: LineAfter) {
        self.drive(true);
        self.outgoing.clear();
        // Longer than that is nothing that the master sends.
        let _ = self.outgoing.extend_from_slice(bytes);
        self.taken = 0;
        self.is_sending = true;
        self.after = after;
        self.fill();
    }

    fn transmission(&mut self) -> Transmission {
        if !self.is_sending {
            return Transmission::Complete;
        }
        if !self.fill() {
            return Transmission::Waiting;
        }
        if let Err(nb::Error::WouldBlock) = self.serial.flush() {
            return Transmission::Sending;
        }
        self.is_sending = false;
        if self.after == LineAfter::Released {
            self.drive(false);
        }
        Transmission::Complete
    }

    fn release(&mut self) {
        self.drive(false);
    }

    fn received(&mut self) -> Received<'_> {
        self.received.clear();
        let mut error = None;
        while !self.received.is_full() {
            match self.serial.read() {
                Ok(byte) => {
                    // There is room.
                    let _ = self.received.push(byte);
                }
                Err(nb::Error::WouldBlock) => break,
                Err(nb::Error::Other(other)) => {
                    error = Some(other.kind());
                    break;
                }
            }
        }
        Received {
            bytes: &self.received,
            error,
        }
    }
}
