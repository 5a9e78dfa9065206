//! Registers read piece by piece.
//!
//! No piece ends inside a register, so that no value is half old, half new.

use super::Ask;
use crate::bridge::gateway::voice::Bytes;
use crate::servo::morpheus::{self, ServoId, safe_read};
use crate::servo::protocol1::{self, Instruction};
use crate::servo::table::{AX12A, MORPHEUS, Table};

/// Bytes of a READ request, in both protocols.
const REQUEST_BYTES: usize = 8;

/// Where Morpheus keeps the position, two bytes. No safe READ begins there.
const POSITION: u8 = 0x0B;

/// Whose registers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::bridge::gateway) enum Target {
    /// A stock servo.
    Stock(u8),
    /// A Morpheus servo, and its position: that comes from the control loop.
    Morpheus(ServoId, Option<u16>),
}

impl Target {
    const fn table(self) -> &'static Table {
        match self {
            Self::Stock(_) => &AX12A,
            Self::Morpheus(..) => &MORPHEUS,
        }
    }

    /// Bytes of an answer beside its data.
    const fn overhead(self) -> usize {
        match self {
            Self::Stock(_) => protocol1::frame::OVERHEAD,
            Self::Morpheus(..) => morpheus::frame::OVERHEAD,
        }
    }

    /// Bytes that must be read before the one at `address`.
    fn run_up(self, address: u8) -> u8 {
        match self {
            Self::Stock(_) => 0,
            Self::Morpheus(..) => safe_read::plan(address, 1)
                .map_or(0, |plan| address.saturating_sub(plan.asked().start)),
        }
    }

    fn ask(self, address: u8, count: u8) -> Option<Ask> {
        let (packet, id, data_bytes) = match self {
            Self::Stock(id) => {
                let read = Instruction::Read { address, count };
                (read.encode(id)?, id, count)
            }
            Self::Morpheus(servo, _) => {
                let plan = safe_read::plan(address, count).ok()?;
                let packet = Bytes::from_slice(&plan.request(servo)).ok()?;
                (packet, servo.get(), plan.asked().len() as u8)
            }
        };
        Some(Ask {
            packet,
            id,
            reply_bytes: self.overhead() as u8 + data_bytes,
        })
    }
}

/// A reading of some registers, and how far it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::bridge::gateway) struct Reading {
    target: Target,
    address: u8,
    /// After the last byte.
    end: u8,
    /// What was read so far.
    data: Bytes,
    /// Bytes that were asked for last.
    asked: u8,
}

impl Reading {
    /// A reading that has only what need not be asked for. `None` if the table
    /// has not all of it, if it is of no bytes, or if it needs a position that
    /// is not known.
    pub(in crate::bridge::gateway) fn new(target: Target, address: u8, count: u8) -> Option<Self> {
        let end = address.checked_add(count)?;
        let is_known =
            !matches!(target, Target::Morpheus(_, None)) || !(address..end).contains(&POSITION);
        let mut reading = Self {
            target,
            address,
            end,
            data: Bytes::new(),
            asked: 0,
        };
        reading.insert_position();
        (count > 0 && end <= target.table().size && is_known).then_some(reading)
    }

    /// First byte that is still missing.
    fn at(&self) -> u8 {
        // No more than a table's size.
        self.address + self.data.len() as u8
    }

    pub(in crate::bridge::gateway) fn is_complete(&self) -> bool {
        self.at() >= self.end
    }

    pub(in crate::bridge::gateway) fn data(&self) -> &[u8] {
        &self.data
    }

    /// The next request, of so many bytes with its answer at the most.
    pub(super) fn next(&mut self, room: usize) -> Option<Ask> {
        let at = self.at();
        self.asked = self.piece(at, room);
        self.target.ask(at, self.asked).filter(|_| self.asked > 0)
    }

    pub(super) fn can_ever_fit(&self, room: usize) -> bool {
        (self.at()..self.end)
            .filter(|at| !matches!(self.target, Target::Morpheus(..) if *at == POSITION))
            .all(|at| self.piece(at, room) > 0)
    }

    /// How many bytes to ask for from `at` on.
    fn piece(&self, at: u8, room: usize) -> u8 {
        let end = match self.target {
            Target::Morpheus(..) if at < POSITION => self.end.min(POSITION),
            Target::Morpheus(..) | Target::Stock(_) => self.end,
        };
        let run_up = usize::from(self.target.run_up(at));
        let room = room.saturating_sub(REQUEST_BYTES + self.target.overhead() + run_up);
        let left = end.saturating_sub(at);
        let piece = left.min(u8::try_from(room).unwrap_or(u8::MAX));
        let is_split = piece < left && splits_register(self.target.table(), at + piece);
        // Registers are of two bytes at the most.
        piece.saturating_sub(u8::from(is_split))
    }

    /// Takes the data of an answer; whether it is what was asked for.
    pub(super) fn took(&mut self, data: &[u8]) -> bool {
        let wanted = match self.target {
            Target::Stock(_) => Some(data),
            Target::Morpheus(..) => safe_read::plan(self.at(), self.asked)
                .ok()
                .and_then(|plan| plan.wanted(data)),
        };
        let is_it = |data: &&[u8]| !data.is_empty() && data.len() == usize::from(self.asked);
        let Some(wanted) = wanted.filter(is_it) else {
            return false;
        };
        // What is asked for is within a table, for which there is room.
        let _ = self.data.extend_from_slice(wanted);
        self.insert_position();
        true
    }

    /// Both bytes at once, so that they belong together.
    fn insert_position(&mut self) {
        if let Target::Morpheus(_, Some(counts)) = self.target
            && self.at() == POSITION
        {
            let left = usize::from(self.end.saturating_sub(POSITION));
            let counts = counts.to_le_bytes();
            let wanted = counts.get(..left).unwrap_or(&counts);
            let _ = self.data.extend_from_slice(wanted);
        }
    }
}

/// Whether a register has bytes on both sides of the start of this one.
fn splits_register(table: &Table, address: u8) -> bool {
    table
        .registers
        .iter()
        .any(|register| register.address < address && address < register.end())
}
