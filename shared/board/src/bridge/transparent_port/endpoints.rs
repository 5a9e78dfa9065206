//! The queues between the tick and the board's second port.

use core::sync::atomic::{AtomicU32, Ordering};

use crate::bridge::queue::{Receiver, Sender};

/// Bytes of the transparent port in either direction: two of the longest packet.
pub(in crate::bridge) const CLIENT_BYTES: usize = 1024;

/// Settings that a client has given its serial port.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct ClientLine {
    /// Whether its port is open (on USB: DTR is on).
    pub is_open: bool,
    /// Speed in bits per second; 0 if the port has none.
    pub baud: u32,
}

impl ClientLine {
    /// Encodes the settings in one word.
    pub const fn to_bits(self) -> u32 {
        // No serial port goes beyond 2³¹ bits a second.
        self.baud << 1 | self.is_open as u32
    }

    /// Decodes the settings from a word.
    pub const fn from_bits(bits: u32) -> Self {
        Self {
            is_open: bits & 1 == 1,
            baud: bits >> 1,
        }
    }
}

/// The tick's end of the queues.
pub(crate) struct BusSide<'a> {
    pub(in crate::bridge) from_client: Receiver<'a, u8, CLIENT_BYTES>,
    pub(in crate::bridge) to_client: Sender<'a, u8, CLIENT_BYTES>,
    pub(in crate::bridge) line: &'a AtomicU32,
}

impl BusSide<'_> {
    pub(super) fn receive(&mut self) -> Option<u8> {
        self.from_client.dequeue()
    }

    /// Whether there is no byte from the client.
    pub(super) fn is_empty(&self) -> bool {
        self.from_client.is_empty()
    }

    /// Sends a byte to the client; `false` if the queue is full.
    pub(super) fn send(&mut self, byte: u8) -> bool {
        self.to_client.enqueue(byte).is_ok()
    }

    pub(super) fn line(&self) -> ClientLine {
        ClientLine::from_bits(self.line.load(Ordering::Relaxed))
    }
}

/// The end of the queues for the driver of the board's second port.
pub struct PortEnd<'a> {
    pub(in crate::bridge) from_client: Sender<'a, u8, CLIENT_BYTES>,
    pub(in crate::bridge) to_client: Receiver<'a, u8, CLIENT_BYTES>,
    pub(in crate::bridge) line: &'a AtomicU32,
}

impl PortEnd<'_> {
    /// Room for bytes from the client.
    pub fn room(&self) -> usize {
        self.from_client.room()
    }

    /// Takes bytes from the client, and returns the number that found room. Wake the
    /// tick then.
    pub fn receive(&mut self, bytes: &[u8]) -> usize {
        bytes
            .iter()
            .take_while(|byte| self.from_client.enqueue(**byte).is_ok())
            .count()
    }

    /// The next byte for the client.
    pub fn transmit(&mut self) -> Option<u8> {
        self.to_client.dequeue()
    }

    /// Sets the client's port settings.
    pub fn set_line(&mut self, line: ClientLine) {
        self.line.store(line.to_bits(), Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_fits_a_word() {
        for line in [
            ClientLine::default(),
            ClientLine {
                is_open: true,
                baud: 2_000_000,
            },
        ] {
            assert_eq!(ClientLine::from_bits(line.to_bits()), line);
        }
    }
}
