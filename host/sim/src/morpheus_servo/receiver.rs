//! The receive state machine and the two message buffers.
//!
//! Every received byte passes [`Inbox::push`] in the interrupt handler. A
//! packet whose checksum is right becomes a message in one of two buffers,
//! and the main loop looks only at the one completed last: an older message
//! that still waits is lost. A sync write is different. The handler itself
//! picks the servo's own bytes out of it, and a PWM takes effect at once,
//! before the checksum has been seen.
//!
//! Lengths and indices are bytes and wrap as bytes, on purpose: several of
//! the firmware's hazards follow from that.

/// First byte of every packet.
const HEADER: u8 = 0xAA;
/// The command whose packets are taken apart while they arrive.
pub(super) const SYNC_WRITE: u8 = 0x83;
/// The register whose sync write acts at once.
const PWM_ADDRESS: u8 = 0x10;
/// Longest length byte that is accepted, and the number of bytes after which
/// the receiver starts afresh.
const LONGEST: u8 = 200;
/// Marks the buffer that the main loop works on.
const IN_USE: u8 = 0xFF;

/// State of the receiver.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Receiving {
    /// A header.
    Idle,
    /// The length byte.
    Length,
    /// Destination, source and command.
    Header,
    /// The rest of a packet.
    Body,
    /// The first register of a sync write.
    SyncAddress,
    /// The number of bytes for each servo.
    SyncSize,
    /// The servo's own id at the head of a block.
    SyncScan,
    /// The servo's own bytes.
    SyncTake,
    /// The end of the sync write.
    SyncTail,
}

/// The message the main loop works on.
#[derive(Debug, Clone, Copy)]
struct Open {
    buffer: usize,
    length: u8,
}

#[derive(Debug, Clone)]
pub(super) struct Inbox {
    state: Receiving,
    failsafe: u8,
    buffers: [[u8; 256]; 2],
    lengths: [u8; 2],
    filling: usize,
    open: Option<Open>,
    length: u8,
    count: u8,
    checksum: u8,
    block_size: u8,
    block_count: u8,
    taken: u8,
}

impl Inbox {
    pub(super) fn new() -> Self {
        Self {
            state: Receiving::Idle,
            failsafe: LONGEST,
            buffers: [[0; 256]; 2],
            lengths: [0; 2],
            filling: 0,
            open: None,
            length: 0,
            count: 0,
            checksum: 0,
            block_size: 0,
            block_count: 0,
            taken: 0,
        }
    }

    pub(super) fn state(&self) -> Receiving {
        self.state
    }

    pub(super) fn failsafe(&self) -> u8 {
        self.failsafe
    }

    /// A message is open whose length, read as a signed byte, is negative: it
    /// is never processed and never closed.
    pub(super) fn stuck(&self) -> bool {
        self.open.is_some_and(|open| open.length >= 0x80)
    }

    /// A message waits to be opened.
    pub(super) fn waiting(&self) -> bool {
        self.open.is_none() && self.lengths[1 - self.filling] != 0
    }

    pub(super) fn is_open(&self) -> bool {
        self.open.is_some()
    }

    /// Copies `into.len()` bytes of the message from `start`. Without an open
    /// message the newest one is opened for it. Reading beyond the end copies
    /// nothing and closes an open message. Returns the message's length.
    pub(super) fn read(&mut self, start: u8, into: &mut [u8]) -> Option<u8> {
        let end = usize::from(start) + into.len();
        let was_open = self.open.is_some();
        let open = self.open.or_else(|| {
            let buffer = 1 - self.filling;
            let length = self.lengths[buffer];
            (length != 0 && !into.is_empty()).then_some(Open { buffer, length })
        })?;
        if end > usize::from(open.length) {
            if was_open {
                self.close();
            }
            return None;
        }
        if !was_open {
            self.lengths[open.buffer] = IN_USE;
            self.open = Some(open);
        }
        into.copy_from_slice(&self.buffers[open.buffer][usize::from(start)..end]);
        Some(open.length)
    }

    /// Closes the open message, if there is one.
    pub(super) fn close(&mut self) {
        if let Some(open) = self.open.take() {
            self.lengths[open.buffer] = 0;
        }
    }

    fn store(&mut self, at: u8, byte: u8) {
        self.buffers[self.filling][usize::from(at)] = byte;
    }

    fn stored(&self, at: u8) -> u8 {
        self.buffers[self.filling][usize::from(at)]
    }

    /// The packet in `filling` is complete.
    fn complete(&mut self, length: u8) {
        self.lengths[self.filling] = length;
        self.filling = 1 - self.filling;
    }

    fn start_afresh(&mut self) {
        self.state = Receiving::Idle;
        self.length = 0;
        self.count = 0;
        self.checksum = 0;
        self.block_size = 0;
        self.block_count = 0;
        self.taken = 0;
        self.lengths = [0; 2];
        self.filling = 0;
        self.failsafe = LONGEST;
    }

    /// How long the interrupt handler takes for this byte, in cycles.
    pub(super) fn cost(&self, byte: u8, own_id: u8) -> u64 {
        let last = self.count == self.length;
        let block_over = self.block_over();
        if self.failsafe == 0 {
            return if byte == HEADER { 140 } else { 116 };
        }
        match self.state {
            Receiving::Idle if byte == HEADER => 137,
            Receiving::Idle => 113,
            Receiving::Length if byte > LONGEST => 117,
            Receiving::Length => 124,
            Receiving::Header if self.count == 2 && byte == SYNC_WRITE => 146,
            Receiving::Header if self.count == 2 => 144,
            Receiving::Header => 138,
            Receiving::Body if last && byte == self.checksum => 159,
            Receiving::Body if last => 151,
            Receiving::Body | Receiving::SyncSize => 143,
            Receiving::SyncAddress => 136,
            Receiving::SyncScan if !block_over => 136,
            Receiving::SyncScan if last => 146,
            Receiving::SyncScan if byte == own_id => 169,
            Receiving::SyncScan => 148,
            Receiving::SyncTake if self.block_count != self.block_size => 151,
            Receiving::SyncTake if self.stored(self.taken.wrapping_sub(4)) == PWM_ADDRESS => 182,
            Receiving::SyncTake => 165,
            Receiving::SyncTail if !last => 127,
            Receiving::SyncTail if byte != self.checksum => 133,
            Receiving::SyncTail if self.five_back() == PWM_ADDRESS => 156,
            Receiving::SyncTail => 169,
        }
    }

    /// Takes a received byte; `own_id` is the servo's id. Returns a PWM that
    /// takes effect at the next tick.
    pub(super) fn push(&mut self, byte: u8, own_id: u8) -> Option<u16> {
        if self.failsafe == 0 {
            self.start_afresh();
        } else {
            self.failsafe -= 1;
        }
        match self.state {
            Receiving::Idle => self.idle(byte),
            Receiving::Length => self.take_length(byte),
            Receiving::Header => self.header(byte),
            Receiving::Body => self.body(byte),
            Receiving::SyncAddress => {
                self.append(byte);
                self.state = Receiving::SyncSize;
            }
            Receiving::SyncSize => {
                self.append(byte);
                self.block_size = byte;
                self.block_count = byte.wrapping_add(1);
                self.taken = self.count;
                self.state = Receiving::SyncScan;
            }
            Receiving::SyncScan => self.scan(byte, own_id),
            Receiving::SyncTake => return self.take_own(byte),
            Receiving::SyncTail => self.tail(byte),
        }
        None
    }

    fn append(&mut self, byte: u8) {
        self.store(self.count, byte);
        self.count_in(byte);
    }

    /// Counts a byte and adds it to the checksum.
    fn count_in(&mut self, byte: u8) {
        self.count = self.count.wrapping_add(1);
        self.checksum = self.checksum.wrapping_add(!byte);
    }

    fn idle(&mut self, byte: u8) {
        if byte != HEADER {
            return;
        }
        if self.lengths[self.filling] == IN_USE {
            self.filling = 1 - self.filling;
        }
        // A message still waiting in this buffer is lost here.
        self.lengths[self.filling] = 0;
        self.failsafe = LONGEST;
        self.state = Receiving::Length;
    }

    fn take_length(&mut self, byte: u8) {
        self.count = 0;
        if byte > LONGEST {
            self.state = Receiving::Idle;
        } else {
            self.length = byte;
            self.checksum = !byte;
            self.state = Receiving::Header;
        }
    }

    fn header(&mut self, byte: u8) {
        self.append(byte);
        if self.count == 3 {
            self.state = if byte == SYNC_WRITE {
                Receiving::SyncAddress
            } else {
                Receiving::Body
            };
        }
    }

    fn body(&mut self, byte: u8) {
        if self.count != self.length {
            self.append(byte);
            return;
        }
        self.store(self.count, byte);
        if self.checksum == byte {
            self.complete(self.length);
        }
        self.state = Receiving::Idle;
    }

    /// Between two blocks, where an id stands. Blocks of 255 bytes never end:
    /// the firmware compares with 256.
    fn block_over(&self) -> bool {
        u16::from(self.block_count) == u16::from(self.block_size) + 1
    }

    /// At the end given by the packet's length, the checksum is in
    /// place of an id.
    fn scan(&mut self, byte: u8, own_id: u8) {
        if self.block_over() {
            self.block_count = 0;
            if self.count == self.length {
                self.state = Receiving::Idle;
            } else if byte == own_id {
                self.store(self.taken, byte);
                self.taken = self.taken.wrapping_add(1);
                self.state = Receiving::SyncTake;
            }
        }
        self.block_count = self.block_count.wrapping_add(1);
        self.count_in(byte);
    }

    /// The byte five places back: the register when a block has two bytes,
    /// something else when it has another size.
    fn five_back(&self) -> u8 {
        self.stored(self.taken.wrapping_sub(5))
    }

    fn take_own(&mut self, byte: u8) -> Option<u16> {
        self.store(self.taken, byte);
        self.taken = self.taken.wrapping_add(1);
        self.count_in(byte);
        let last = self.block_count == self.block_size;
        self.block_count = self.block_count.wrapping_add(1);
        if !last {
            return None;
        }
        self.state = Receiving::SyncTail;
        let low = self.stored(self.taken.wrapping_sub(2));
        let high = self.stored(self.taken.wrapping_sub(1));
        (self.five_back() == PWM_ADDRESS).then_some(u16::from_le_bytes([low, high]))
    }

    fn tail(&mut self, byte: u8) {
        if self.count != self.length {
            self.count_in(byte);
            return;
        }
        if self.checksum == byte && self.five_back() != PWM_ADDRESS {
            self.complete(self.block_size.wrapping_add(6));
        }
        self.state = Receiving::Idle;
    }
}
