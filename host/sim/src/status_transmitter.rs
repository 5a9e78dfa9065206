//! Transmitter of a Dynamixel servo: a status packet after its delay, byte by byte.

use std::collections::VecDeque;

use super::morpheus_servo::Action;

/// Bits of a byte on the wire.
const BITS: u64 = 10;

/// A status packet on its way.
#[derive(Clone, Debug)]
pub(crate) struct Transmitter {
    bytes: VecDeque<u8>,
    /// Start of the next byte, or end of the last one.
    next_ns: u64,
    driving: bool,
}

impl Transmitter {
    /// A transmitter with nothing to send.
    pub(crate) fn new() -> Self {
        Self {
            bytes: VecDeque::new(),
            next_ns: 0,
            driving: false,
        }
    }

    /// Sends a packet that begins at `at_ns`.
    pub(crate) fn begin(&mut self, at_ns: u64, packet: &[u8]) {
        self.bytes = packet.iter().copied().collect();
        self.next_ns = at_ns;
    }

    pub(crate) fn driving(&self) -> bool {
        self.driving
    }

    pub(crate) fn next_event_ns(&self) -> u64 {
        if self.driving || !self.bytes.is_empty() {
            self.next_ns
        } else {
            u64::MAX
        }
    }

    /// Delays the next step to `at_ns` at the earliest.
    pub(crate) fn wait_until(&mut self, at_ns: u64) {
        self.next_ns = self.next_ns.max(at_ns);
    }

    /// Sends the next byte, or switches the driver off after the last one.
    pub(crate) fn step(&mut self, now_ns: u64, bit_ns: u64) -> Option<Action> {
        match self.bytes.pop_front() {
            Some(byte) => {
                self.driving = true;
                self.next_ns = now_ns + BITS * bit_ns;
                let start_ns = now_ns;
                Some(Action::Send { byte, start_ns })
            }
            None if self.driving => {
                self.driving = false;
                Some(Action::Release)
            }
            None => None,
        }
    }
}
