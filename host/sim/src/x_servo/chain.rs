//! Replies of several servos to one instruction: when it is this one's turn, and its bytes.
//!
//! ```text
//! sync read       | status of the first | status of the second | ..
//! fast sync read  | head | part of the first | part of the second | ..
//! ```
//!
//! In the list of a (fast) sync or bulk read each servo follows the one before it in the list. It
//! listens to the bus: for the status packet of that one, or for as many bytes of the joint packet
//! as come before its part. If they do not come, it stays silent, and so do those after it; the
//! next instruction ends the wait. That is assumed: the e-Manual does not tell what a servo does
//! whose predecessor is silent.

use armbridge_servo::protocol2::frame::{HEADER, STATUS};
use armbridge_servo::protocol2::register as at;
use armbridge_servo::protocol2::{BROADCAST, BulkItem, FastStatus, Instruction, Part, StatusError};

use super::commands::REPLY_MAX;
use super::{PROCESSING_NS, XServo};

/// Address and number of the bytes to read.
pub(super) type Span = (u16, u16);

/// Place of this servo in a list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place {
    pub(super) span: Span,
    /// The servo before it.
    pub(super) predecessor: Option<u8>,
    /// Place in a joint packet.
    pub(super) fast: Option<FastPlace>,
}

/// Place in a joint packet, in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FastPlace {
    /// Bytes before the part.
    pub(super) before: usize,
    /// Bytes of the whole packet.
    pub(super) total: usize,
}

/// What a reply waits for.
#[derive(Clone, Debug)]
pub(super) enum Turn {
    /// The status packet of this servo.
    Status {
        /// Its id.
        id: u8,
        /// The status packet to send then.
        reply: Vec<u8>,
    },
    /// So many bytes of a joint packet.
    Part {
        /// The number of bytes.
        before: usize,
        /// Error to add then.
        error: Option<StatusError>,
        /// Data to add then.
        data: Vec<u8>,
    },
}

/// The place of servo `id` in a read of several, or `None` if it is not in the list.
pub(super) fn place(instruction: &Instruction, id: u8) -> Option<Place> {
    match *instruction {
        Instruction::SyncRead {
            address,
            count,
            ids,
        } => find(ids.iter().map(|id| (*id, (address, count))), id, false),
        Instruction::FastSyncRead {
            address,
            count,
            ids,
        } => find(ids.iter().map(|id| (*id, (address, count))), id, true),
        Instruction::BulkRead(items) => find(items_of(items), id, false),
        Instruction::FastBulkRead(items) => find(items_of(items), id, true),
        _ => None,
    }
}

fn items_of(bytes: &[u8]) -> impl Iterator<Item = (u8, Span)> {
    BulkItem::decode_all(bytes).map(|item| (item.id, (item.address, item.count)))
}

fn find(list: impl Iterator<Item = (u8, Span)>, own_id: u8, is_fast: bool) -> Option<Place> {
    let mut place = None;
    let mut predecessor = None;
    let mut total = FastStatus::packet_bytes(0, 0);
    for (id, span) in list {
        if id == own_id && place.is_none() {
            place = Some((span, predecessor, total));
        }
        let part = FastStatus::packet_bytes(1, span.1.into()) - FastStatus::packet_bytes(0, 0);
        (predecessor, total) = (Some(id), total + part);
    }
    let (span, predecessor, before) = place?;
    Some(Place {
        span,
        predecessor,
        fast: is_fast.then_some(FastPlace { before, total }),
    })
}

/// Whether these bytes begin a joint packet.
fn is_joint_packet(bytes: &[u8]) -> bool {
    bytes.starts_with(&HEADER)
        && bytes.get(HEADER.len()) == Some(&BROADCAST)
        && bytes.get(FastStatus::packet_bytes(0, 0) - 1) == Some(&STATUS)
}

impl XServo {
    /// Replies to a read of several servos: now if this is the first, else in its turn.
    pub(super) fn read_in_turn(&mut self, place: &Place, end_ns: u64) {
        if self.memory.byte(at::STATUS_RETURN_LEVEL) == 0 {
            return;
        }
        let (address, count) = place.span;
        let contents = self.memory.read(address, count);
        let Some(fast) = place.fast else {
            let reply = self.status(&contents);
            match place.predecessor {
                None => self.transmit(self.reply_start_ns(end_ns), &reply),
                Some(id) => self.turn = Some(Turn::Status { id, reply }),
            }
            return;
        };
        let error = contents.as_ref().err().copied();
        let data = contents.unwrap_or_else(|_| vec![0; count.into()]);
        let (is_first, before) = (place.predecessor.is_none(), fast.before);
        self.turn = Some(Turn::Part {
            before,
            error,
            data,
        });
        if is_first && let Some(head) = FastStatus::encode_head(fast.total) {
            let start_ns = self.reply_start_ns(end_ns);
            self.add_part(&head, start_ns);
        }
    }

    /// Sends the part that waits, after `head` if this is the first.
    fn add_part(&mut self, head: &[u8], start_ns: u64) {
        let Some(Turn::Part { error, data, .. }) = self.turn.take() else {
            return;
        };
        let part = Part {
            id: self.id(),
            is_alert: self.is_alert(),
            error,
            data: &data,
        };
        let before = if head.is_empty() {
            self.receiver.begun()
        } else {
            head
        };
        let Some(part) = part.encode::<REPLY_MAX>(before) else {
            return;
        };
        self.transmit(start_ns, &[head, &part].concat());
        self.sends_part = true;
    }

    /// A packet has grown: it may be the turn of this servo's part.
    pub(super) fn part_received(&mut self, end_ns: u64) {
        let Some(Turn::Part { before, .. }) = self.turn else {
            return;
        };
        let begun = self.receiver.begun();
        if begun.len() == before && is_joint_packet(begun) {
            self.add_part(&[], end_ns + PROCESSING_NS);
        }
    }

    /// The status packet of another servo has been received.
    pub(super) fn status_received(&mut self, from: u8, end_ns: u64) {
        match self.turn.take() {
            Some(Turn::Status { id, reply }) if id == from => {
                self.transmit(self.reply_start_ns(end_ns), &reply);
            }
            other => self.turn = other,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_follows_the_one_before_it_in_the_list() {
        let read = Instruction::SyncRead {
            address: 132,
            count: 4,
            ids: &[3, 1, 2],
        };
        let predecessors = [3, 1, 2].map(|id| place(&read, id).unwrap().predecessor);
        assert_eq!(predecessors, [None, Some(3), Some(1)]);
        assert_eq!(place(&read, 4), None);
        let items = [1, 144, 0, 2, 0, 2, 146, 0, 1, 0];
        let second = place(&Instruction::FastBulkRead(&items), 2).unwrap();
        assert_eq!(second.span, (146, 1));
        let fast = FastPlace {
            before: 14,
            total: 19,
        };
        assert_eq!(second.fast, Some(fast));
    }
}
