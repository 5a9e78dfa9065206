//! Reads of registers in pieces.
//!
//! No piece ends inside a register, so that no value is half old, half new. A
//! position that no READ may have comes from the control loop.

use crate::bridge::gateway::response::{BYTES_MAX, Bytes, Responder};
use crate::servo::{Firmware, Query};

/// One query on the bus.
pub type BusQuery = Query<BYTES_MAX>;

/// Bytes of a READ, in both protocols.
const QUERY_BYTES: usize = 8;

/// A read of some registers, and how far it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::bridge::gateway) struct RegisterRead {
    firmware: Firmware,
    /// The servo.
    id: u8,
    /// Its last position in the control loop.
    position: Option<u16>,
    address: u8,
    /// After the last byte.
    end: u8,
    /// What was read so far.
    data: Bytes,
    /// Bytes that were asked for last.
    asked: u8,
}

impl RegisterRead {
    /// A read that has only what need not be asked for. `None` if the table
    /// has not all of it, if it is of no bytes, or if it needs a position that
    /// is not known.
    pub(in crate::bridge::gateway) fn new(
        of: Responder,
        position: Option<u16>,
        address: u8,
        count: u8,
    ) -> Option<Self> {
        let end = address.checked_add(count)?;
        let mut read = Self {
            firmware: of.firmware,
            id: of.id,
            position,
            address,
            end,
            data: Bytes::new(),
            asked: 0,
        };
        let needs_position = (address..end).any(|at| read.is_unreadable(at));
        let is_known = position.is_some() || !needs_position;
        read.insert_position();
        (count > 0 && end <= of.firmware.memory_bytes() && is_known).then_some(read)
    }

    /// First byte that is still missing.
    fn at(&self) -> u8 {
        // No more than a table's size.
        self.address + self.data.len() as u8
    }

    fn is_unreadable(&self, address: u8) -> bool {
        self.firmware.unreadable() == Some(address)
    }

    pub(in crate::bridge::gateway) fn is_complete(&self) -> bool {
        self.at() >= self.end
    }

    pub(in crate::bridge::gateway) fn data(&self) -> &[u8] {
        &self.data
    }

    /// The next query, with at most this many bytes in query and reply.
    pub(super) fn next(&mut self, room: usize) -> Option<BusQuery> {
        let at = self.at();
        self.asked = self.piece(at, room);
        let query = || self.firmware.read_query(self.id, at, self.asked);
        (self.asked > 0).then(query).flatten()
    }

    pub(super) fn can_ever_fit(&self, room: usize) -> bool {
        (self.at()..self.end)
            .filter(|at| !self.is_unreadable(*at))
            .all(|at| self.piece(at, room) > 0)
    }

    /// How many bytes to ask for from `at` on.
    fn piece(&self, at: u8, room: usize) -> u8 {
        let end = match self.firmware.unreadable() {
            Some(unreadable) if at < unreadable => self.end.min(unreadable),
            _ => self.end,
        };
        let beside = self.firmware.reply_overhead() + usize::from(self.firmware.lead_bytes(at));
        let room = room.saturating_sub(QUERY_BYTES + beside);
        let left = end.saturating_sub(at);
        let piece = left.min(u8::try_from(room).unwrap_or(u8::MAX));
        let is_split = piece < left && self.firmware.splits_register(at + piece);
        // Registers are of two bytes at the most.
        piece.saturating_sub(u8::from(is_split))
    }

    /// Takes the data of an answer; whether it is what was asked for.
    pub(super) fn take_data(&mut self, data: &[u8]) -> bool {
        let wanted = self.firmware.read_reply(self.at(), self.asked, data);
        let Some(wanted) = wanted.filter(|wanted| !wanted.is_empty()) else {
            return false;
        };
        // What is asked for is within a table, for which there is room.
        let _ = self.data.extend_from_slice(wanted);
        self.insert_position();
        true
    }

    /// Both bytes at once, so that they belong together.
    fn insert_position(&mut self) {
        if let Some(counts) = self.position
            && self.is_unreadable(self.at())
        {
            let left = usize::from(self.end.saturating_sub(self.at()));
            let counts = counts.to_le_bytes();
            let wanted = counts.get(..left).unwrap_or(&counts);
            let _ = self.data.extend_from_slice(wanted);
        }
    }
}
