//! The receive state machine and the two message buffers.
//!
//! Every received byte passes [`Receiver::push`] in the interrupt handler. A
//! packet whose checksum is right becomes a message in one of two buffers,
//! and the main loop polls only the one completed last: an older message
//! that still waits is lost. A sync write is different. The handler itself
//! extracts the servo's own bytes, and a PWM takes effect at once,
//! before the checksum has been received.
//!
//! Lengths and indices are bytes and wrap as bytes, as in the firmware: several of
//! its hazards follow from that.

/// First byte of every packet.
const HEADER: u8 = 0xAA;
/// Command whose packets are parsed while they arrive.
pub(super) const SYNC_WRITE: u8 = 0x83;
/// Register whose sync write takes effect at once.
const PWM_ADDRESS: u8 = 0x10;
/// Longest length byte that is accepted, and the number of bytes after which
/// the receiver resets itself.
const LONGEST: u8 = 200;
/// Length that marks the buffer of the open message.
const IN_USE: u8 = 0xFF;

/// State of the receiver: the item that it expects next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReceiverState {
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
    SyncData,
    /// The end of the sync write.
    SyncTail,
}

/// The message that the main loop executes.
#[derive(Debug, Clone, Copy)]
struct OpenMessage {
    buffer: usize,
    length: u8,
}

/// The receive state machine with its buffers.
#[derive(Debug, Clone)]
pub(super) struct Receiver {
    state: ReceiverState,
    failsafe: u8,
    buffers: [[u8; 256]; 2],
    lengths: [u8; 2],
    filling: usize,
    open: Option<OpenMessage>,
    length: u8,
    count: u8,
    checksum: u8,
    block_size: u8,
    block_count: u8,
    taken: u8,
}

impl Receiver {
    pub(super) fn new() -> Self {
        Self {
            state: ReceiverState::Idle,
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

    pub(super) fn state(&self) -> ReceiverState {
        self.state
    }

    pub(super) fn failsafe(&self) -> u8 {
        self.failsafe
    }

    /// Whether a message is open whose length, read as a signed byte, is negative: it
    /// is never processed and never closed.
    pub(super) fn stuck(&self) -> bool {
        self.open.is_some_and(|open| open.length >= 0x80)
    }

    /// Whether a message waits to be opened.
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
            (length != 0 && !into.is_empty()).then_some(OpenMessage { buffer, length })
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

    /// Completes the packet in `filling`.
    fn complete(&mut self, length: u8) {
        self.lengths[self.filling] = length;
        self.filling = 1 - self.filling;
    }

    fn reset(&mut self) {
        self.state = ReceiverState::Idle;
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

    /// Execution time of the interrupt handler for this byte, in cycles.
    pub(super) fn cost(&self, byte: u8, own_id: u8) -> u64 {
        let last = self.count == self.length;
        let block_over = self.block_over();
        if self.failsafe == 0 {
            return if byte == HEADER { 140 } else { 116 };
        }
        match self.state {
            ReceiverState::Idle if byte == HEADER => 137,
            ReceiverState::Idle => 113,
            ReceiverState::Length if byte > LONGEST => 117,
            ReceiverState::Length => 124,
            ReceiverState::Header if self.count == 2 && byte == SYNC_WRITE => 146,
            ReceiverState::Header if self.count == 2 => 144,
            ReceiverState::Header => 138,
            ReceiverState::Body if last && byte == self.checksum => 159,
            ReceiverState::Body if last => 151,
            ReceiverState::Body | ReceiverState::SyncSize => 143,
            ReceiverState::SyncAddress => 136,
            ReceiverState::SyncScan if !block_over => 136,
            ReceiverState::SyncScan if last => 146,
            ReceiverState::SyncScan if byte == own_id => 169,
            ReceiverState::SyncScan => 148,
            ReceiverState::SyncData if self.block_count != self.block_size => 151,
            ReceiverState::SyncData if self.stored(self.taken.wrapping_sub(4)) == PWM_ADDRESS => {
                182
            }
            ReceiverState::SyncData => 165,
            ReceiverState::SyncTail if !last => 127,
            ReceiverState::SyncTail if byte != self.checksum => 133,
            ReceiverState::SyncTail if self.register_of_block() == PWM_ADDRESS => 156,
            ReceiverState::SyncTail => 169,
        }
    }

    /// Processes a received byte; `own_id` is the servo's id. Returns a PWM that
    /// takes effect at the next tick.
    pub(super) fn push(&mut self, byte: u8, own_id: u8) -> Option<u16> {
        if self.failsafe == 0 {
            self.reset();
        } else {
            self.failsafe -= 1;
        }
        match self.state {
            ReceiverState::Idle => self.idle(byte),
            ReceiverState::Length => self.length_byte(byte),
            ReceiverState::Header => self.header(byte),
            ReceiverState::Body => self.body(byte),
            ReceiverState::SyncAddress => {
                self.append(byte);
                self.state = ReceiverState::SyncSize;
            }
            ReceiverState::SyncSize => {
                self.append(byte);
                self.block_size = byte;
                self.block_count = byte.wrapping_add(1);
                self.taken = self.count;
                self.state = ReceiverState::SyncScan;
            }
            ReceiverState::SyncScan => self.scan(byte, own_id),
            ReceiverState::SyncData => return self.own_block(byte),
            ReceiverState::SyncTail => self.tail(byte),
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
        self.state = ReceiverState::Length;
    }

    fn length_byte(&mut self, byte: u8) {
        self.count = 0;
        if byte > LONGEST {
            self.state = ReceiverState::Idle;
        } else {
            self.length = byte;
            self.checksum = !byte;
            self.state = ReceiverState::Header;
        }
    }

    fn header(&mut self, byte: u8) {
        self.append(byte);
        if self.count == 3 {
            self.state = if byte == SYNC_WRITE {
                ReceiverState::SyncAddress
            } else {
                ReceiverState::Body
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
        self.state = ReceiverState::Idle;
    }

    /// Whether the next byte is an id, between two blocks. Blocks of 255 bytes never
    /// end: the firmware compares with 256.
    fn block_over(&self) -> bool {
        u16::from(self.block_count) == u16::from(self.block_size) + 1
    }

    /// Searches for the servo's block. At the end given by the packet's length, the
    /// checksum is in place of an id.
    fn scan(&mut self, byte: u8, own_id: u8) {
        if self.block_over() {
            self.block_count = 0;
            if self.count == self.length {
                self.state = ReceiverState::Idle;
            } else if byte == own_id {
                self.store(self.taken, byte);
                self.taken = self.taken.wrapping_add(1);
                self.state = ReceiverState::SyncData;
            }
        }
        self.block_count = self.block_count.wrapping_add(1);
        self.count_in(byte);
    }

    /// The byte five indices back: the register if a block has two bytes, another
    /// byte if it has another size.
    fn register_of_block(&self) -> u8 {
        self.stored(self.taken.wrapping_sub(5))
    }

    fn own_block(&mut self, byte: u8) -> Option<u16> {
        self.store(self.taken, byte);
        self.taken = self.taken.wrapping_add(1);
        self.count_in(byte);
        let last = self.block_count == self.block_size;
        self.block_count = self.block_count.wrapping_add(1);
        if !last {
            return None;
        }
        self.state = ReceiverState::SyncTail;
        let low = self.stored(self.taken.wrapping_sub(2));
        let high = self.stored(self.taken.wrapping_sub(1));
        (self.register_of_block() == PWM_ADDRESS).then_some(u16::from_le_bytes([low, high]))
    }

    fn tail(&mut self, byte: u8) {
        if self.count != self.length {
            self.count_in(byte);
            return;
        }
        if self.checksum == byte && self.register_of_block() != PWM_ADDRESS {
            self.complete(self.block_size.wrapping_add(6));
        }
        self.state = ReceiverState::Idle;
    }
}
