//! Reads of registers in pieces.
//!
//! No piece ends inside a register, so that no value is half old, half new. A
//! position that no READ may have comes from the control loop.

use crate::bridge::transparent_port::response::{BYTES_MAX, Bytes, Responder};
use armbridge_servo::{Firmware, Query};

/// One query on the bus.
pub type BusQuery = Query<BYTES_MAX>;

/// Bytes of the longest reply with so many bytes of data.
fn reply_bytes(firmware: Firmware, count: u16) -> usize {
    let count = usize::from(count);
    let stuffing = match firmware {
        Firmware::Morpheus | Firmware::Stock => 0,
        Firmware::XSeries => count / 3,
    };
    firmware.reply_overhead() + count + stuffing
}

/// A read of some registers, and its progress.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::bridge::transparent_port) struct RegisterRead {
    firmware: Firmware,
    /// The servo.
    id: u8,
    /// Its last position in the control loop.
    position: Option<u16>,
    address: u16,
    /// End of the registers, exclusive.
    end: u16,
    /// Data read so far.
    data: Bytes,
    /// Number of bytes in the last query.
    requested: u16,
}

impl RegisterRead {
    /// A read that has the position only. `None` if the table
    /// lacks a register, if it is of no bytes or of more than a reply may have, or if it needs a position that
    /// is not known.
    pub(in crate::bridge::transparent_port) fn new(
        responder: Responder,
        position: Option<u16>,
        address: u16,
        count: u16,
    ) -> Option<Self> {
        let end = address.checked_add(count)?;
        let mut read = Self {
            firmware: responder.firmware,
            id: responder.id,
            position,
            address,
            end,
            data: Bytes::new(),
            requested: 0,
        };
        let needs_position = (address..end).any(|at| read.is_unreadable(at));
        let is_known = position.is_some() || !needs_position;
        read.insert_position();
        let is_short = reply_bytes(responder.firmware, count) <= BYTES_MAX;
        let is_in_table = count > 0 && end <= responder.firmware.memory_bytes();
        (is_short && is_in_table && is_known).then_some(read)
    }

    /// Address of the first byte that is still missing.
    fn next_address(&self) -> u16 {
        // At most a table's size.
        self.address + self.data.len() as u16
    }

    fn is_unreadable(&self, address: u16) -> bool {
        self.firmware.unreadable() == Some(address)
    }

    pub(in crate::bridge::transparent_port) fn is_complete(&self) -> bool {
        self.next_address() >= self.end
    }

    pub(in crate::bridge::transparent_port) fn data(&self) -> &[u8] {
        &self.data
    }

    /// The next query, with at most this many bytes in query and reply.
    pub(super) fn next(&mut self, room: usize) -> Option<BusQuery> {
        let at = self.next_address();
        self.requested = self.piece(at, room);
        let query = || self.firmware.read_query(self.id, at, self.requested);
        (self.requested > 0).then(query).flatten()
    }

    /// Whether slots of this size complete the read.
    pub(super) fn can_complete(&self, room: usize) -> bool {
        (self.next_address()..self.end)
            .filter(|at| !self.is_unreadable(*at))
            .all(|at| self.piece(at, room) > 0)
    }

    /// Number of bytes in a query from `at` on.
    fn piece(&self, at: u16, room: usize) -> u16 {
        let end = match self.firmware.unreadable() {
            Some(unreadable) if at < unreadable => self.end.min(unreadable),
            _ => self.end,
        };
        let overhead = self.firmware.reply_overhead() + usize::from(self.firmware.lead_bytes(at));
        let room = room.saturating_sub(self.firmware.read_bytes() + overhead);
        let remaining = end.saturating_sub(at);
        let piece = remaining.min(u16::try_from(room).unwrap_or(u16::MAX));
        if piece == remaining {
            return piece;
        }
        self.firmware.register_start(at + piece).saturating_sub(at)
    }

    /// Takes the data of a reply; whether it answers the last query.
    pub(super) fn take_data(&mut self, data: &[u8]) -> bool {
        let contents = self
            .firmware
            .read_reply(self.next_address(), self.requested, data);
        let Some(contents) = contents.filter(|contents| !contents.is_empty()) else {
            return false;
        };
        // Contents are within a table, for which there is room.
        let _ = self.data.extend_from_slice(contents);
        self.insert_position();
        true
    }

    /// Inserts both bytes of the position at once, so that they are of one sample.
    fn insert_position(&mut self) {
        if let Some(counts) = self.position
            && self.is_unreadable(self.next_address())
        {
            let remaining = usize::from(self.end.saturating_sub(self.next_address()));
            let counts = counts.to_le_bytes();
            let bytes = counts.get(..remaining).unwrap_or(&counts);
            let _ = self.data.extend_from_slice(bytes);
        }
    }
}
