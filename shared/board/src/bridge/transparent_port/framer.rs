//! Framer: assembles the client's bytes to whole packets, so that a packet is never sent
//! in parts, however USB splits it.
//!
//! ```text
//! FF FF ID LEN ..          Protocol 1.0   LEN 2..=255    LEN + 4 bytes    Packet
//! AA LEN ..                Morpheus       LEN 3..=200    LEN + 3 bytes    Packet
//! FF FF FD 00 ID LEN LEN   Protocol 2.0   to 260 bytes   LEN + 7 bytes    Packet
//! anything else            up to the next of these, or 2 ms of silence    Raw
//! ```
//!
//! The length decides, not the checksum: a damaged packet is a packet, for a
//! servo may answer it with an alarm. A Morpheus packet that is longer than a
//! servo tolerates (LEN of 128 or more) is a packet too, so that it can be refused
//! as a whole; above 200 the firmware itself searches for the next header.
//! Protocol 2.0 is recognised by its length of 0 in Protocol 1.0's place.
//!
//! After 100 ms without a byte, half a packet is dropped, as a stock servo
//! drops it. A Morpheus servo would wait for the rest for ever. A run of more
//! than two 0xFF is no half packet but a flush, and is passed on; 0xAA after it
//! is Morpheus's header and not an id of Protocol 1.0.

use armbridge_servo::morpheus::HEADER as MORPHEUS;
use armbridge_servo::protocol::Extent;
use armbridge_servo::protocol1::frame::HEADER as STOCK;
use armbridge_servo::{ClientFrame, Firmware};
use heapless::Vec;

/// Time without a byte after which a stock servo drops a packet, in µs (e-Manual,
/// "DYNAMIXEL Protocol 1.0", "Instruction Packet").
const HALF_PACKET_US: u64 = 100_000;

/// Time without a byte that ends raw bytes, in µs: two USB frames, because bytes of the next
/// frame may belong to them.
const RAW_QUIET_US: u64 = 2_000;

/// Capacity in bytes: the longest Protocol 1.0 packet has 259.
const CAPACITY: usize = 260;

/// Kind of the frame that [`Framer::bytes`] hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameKind {
    /// A whole packet of this firmware's protocol, with any instruction and any checksum.
    Packet(Firmware),
    /// Bytes that are no packet of either protocol.
    Raw,
}

/// Classification of bytes by their beginning.
enum PrefixClass {
    /// No packet begins with the first byte.
    Raw,
    /// More bytes are needed.
    Incomplete,
    /// A packet of this kind and length in bytes.
    Whole(FrameKind, usize),
}

/// Framer of bytes, one frame at a time.
#[derive(Clone, Debug, Default)]
pub struct Framer {
    /// The frame handed out, raw bytes, and the bytes of an incomplete packet.
    bytes: Vec<u8, CAPACITY>,
    /// Length of the frame handed out.
    taken: usize,
    /// Index of the first byte of the incomplete packet.
    start: usize,
    received_us: u64,
    /// Number of truncated packets.
    truncated: u32,
}

impl Framer {
    /// A framer that has received nothing.
    pub const fn new() -> Self {
        Self {
            bytes: Vec::new(),
            taken: 0,
            start: 0,
            received_us: 0,
            truncated: 0,
        }
    }

    /// Takes one byte; `Some` when a frame is complete.
    pub fn push(&mut self, byte: u8, now_us: u64) -> Option<FrameKind> {
        let late = self.expire(now_us);
        self.received_us = now_us;
        // There is room: a full buffer was handed out.
        let _ = self.bytes.push(byte);
        let class = self.find_start();
        if late.is_some() {
            return late;
        }
        let (kind, bytes) = match class {
            PrefixClass::Whole(kind, bytes) if self.start == 0 => {
                (self.bytes.len() == bytes).then_some((kind, bytes))?
            }
            // A packet begins here: the bytes before it are raw.
            PrefixClass::Whole(..) => (FrameKind::Raw, self.start),
            _ if self.bytes.is_full() => (FrameKind::Raw, self.start),
            _ => return None,
        };
        self.taken = bytes;
        Some(kind)
    }

    /// The frame handed out last, until the next call of [`Framer::push`] or
    /// [`Framer::expire`].
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.taken).unwrap_or_default()
    }

    /// The frame handed out last, parsed.
    pub fn frame(&self, kind: FrameKind) -> ClientFrame<'_> {
        let firmware = match kind {
            FrameKind::Packet(firmware) => Some(firmware),
            FrameKind::Raw => None,
        };
        ClientFrame::new(firmware, self.bytes())
    }

    /// Ends the wait for bytes that do not come: drops half a packet and hands
    /// out the bytes before it as [`FrameKind::Raw`].
    pub fn expire(&mut self, now_us: u64) -> Option<FrameKind> {
        self.drop_taken();
        if now_us < self.wake_at_us()? {
            return None;
        }
        let begun = self.bytes.len() - self.start;
        let is_flush = begun == 2 && self.bytes.ends_with(&[STOCK; 3]);
        if begun > 0 && !is_flush {
            self.truncated = self.truncated.saturating_add(1);
            self.bytes.truncate(self.start);
        }
        self.start = self.bytes.len();
        self.taken = self.start;
        (self.taken > 0).then_some(FrameKind::Raw)
    }

    /// Time of the next call of [`Framer::expire`], if no byte is pushed before.
    pub fn wake_at_us(&self) -> Option<u64> {
        let held = self.bytes.len();
        let wait_us = if self.start < held {
            HALF_PACKET_US
        } else {
            RAW_QUIET_US
        };
        (self.taken < held).then(|| self.received_us.saturating_add(wait_us))
    }

    /// Whether it holds no byte, not even of a frame handed out.
    pub fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    /// Number of truncated packets that were dropped.
    pub fn truncated(&self) -> u32 {
        self.truncated
    }

    /// Drops the bytes handed out.
    fn drop_taken(&mut self) {
        let taken = core::mem::take(&mut self.taken).min(self.bytes.len());
        self.bytes.rotate_left(taken);
        self.bytes.truncate(self.bytes.len() - taken);
        self.start = self.start.saturating_sub(taken);
    }

    /// Advances to the next byte at which a packet may begin.
    fn find_start(&mut self) -> PrefixClass {
        loop {
            let (raw, begun) = self.bytes.split_at_checked(self.start).unwrap_or_default();
            let is_flushed =
                raw.ends_with(&[STOCK]) && begun.starts_with(&[STOCK, STOCK, MORPHEUS]);
            match classify(begun) {
                PrefixClass::Raw => self.start += 1,
                _ if is_flushed => self.start += 1,
                class => return class,
            }
        }
    }
}

/// Classifies bytes by their beginning.
fn classify(bytes: &[u8]) -> PrefixClass {
    let mut is_incomplete = false;
    for firmware in Firmware::ALL {
        match firmware.extent(bytes) {
            Extent::Whole(length) if length <= CAPACITY => {
                return PrefixClass::Whole(FrameKind::Packet(firmware), length);
            }
            Extent::Incomplete => is_incomplete = true,
            Extent::Whole(_) | Extent::NoHeader | Extent::BadLength => {}
        }
    }
    if is_incomplete {
        PrefixClass::Incomplete
    } else {
        PrefixClass::Raw
    }
}

#[cfg(test)]
mod tests;
