//! A bulk pipe.

use std::collections::VecDeque;

use super::PACKET;
use crate::peripherals::otg::{Answer, Otg};

/// One direction of a function: bytes to be sent, or received and not yet taken.
#[derive(Clone, Debug, Default)]
pub struct Pipe {
    /// The bytes.
    pub bytes: VecDeque<u8>,
    /// Packets so far.
    pub packets: u64,
    /// Packets that were dropped for their toggle.
    pub repeated: u64,
    endpoint: Option<u8>,
    toggle: bool,
}

impl Pipe {
    /// Opens it at an endpoint's address, its toggle at DATA0.
    pub fn open(&mut self, address: Option<u8>) {
        self.endpoint = address.map(|address| address & 0xF);
        self.toggle = false;
    }

    /// Whether it is open.
    pub fn is_open(&self) -> bool {
        self.endpoint.is_some()
    }

    /// Number of its endpoint.
    pub fn endpoint(&self) -> usize {
        self.endpoint.unwrap_or(0).into()
    }

    /// Sends a packet. Like other hosts' drivers it ends a transfer that fills its packets
    /// with a shorter one.
    pub fn send(&mut self, otg: &mut Otg) {
        let len = self.bytes.len().min(PACKET - 1);
        let packet: Vec<u8> = self.bytes.iter().take(len).copied().collect();
        if otg.out(self.endpoint(), &packet, self.toggle) == Answer::Ack {
            self.toggle = !self.toggle;
            self.packets += 1;
            self.bytes.drain(..len);
        }
    }

    /// Asks for a packet.
    pub fn receive(&mut self, otg: &mut Otg) {
        if let Answer::Data(data, toggle) = otg.input(self.endpoint()) {
            if toggle == self.toggle {
                self.toggle = !self.toggle;
                self.packets += 1;
                self.bytes.extend(data);
            } else {
                self.repeated += 1;
            }
        }
    }
}
