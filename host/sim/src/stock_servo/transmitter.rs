//! The transmitter: a status packet after its delay, byte by byte.

use std::collections::VecDeque;

use crate::morpheus_servo::Action;

/// Bits of a byte on the wire.
const BITS: u64 = 10;

/// A status packet on its way.
#[derive(Clone, Debug)]
pub(super) struct Sending {
    bytes: VecDeque<u8>,
    /// When the next byte begins, or the last ends.
    next_ns: u64,
    driving: bool,
}

impl Sending {
    /// With nothing to send.
    pub(super) fn new() -> Self {
        Self {
            bytes: VecDeque::new(),
            next_ns: 0,
            driving: false,
        }
    }

    /// A packet that begins then.
    pub(super) fn begin(&mut self, at_ns: u64, packet: &[u8]) {
        self.bytes = packet.iter().copied().collect();
        self.next_ns = at_ns;
    }

    pub(super) fn driving(&self) -> bool {
        self.driving
    }

    pub(super) fn next_event_ns(&self) -> u64 {
        if self.driving || !self.bytes.is_empty() {
            self.next_ns
        } else {
            u64::MAX
        }
    }

    /// Nothing can be done before.
    pub(super) fn wait_until(&mut self, at_ns: u64) {
        self.next_ns = self.next_ns.max(at_ns);
    }

    /// The next byte, or after the last one the driver off.
    pub(super) fn step(&mut self, now_ns: u64, bit_ns: u64) -> Option<Action> {
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
