//! Data line: senders over time.
//!
//! The line idles high and any sender can pull it low (real levels under
//! contention are undefined; low wins is the usual outcome and the worst for
//! a receiver that waits for a start bit). A byte is a start bit (low), eight
//! data bits, least significant first, and a stop bit (high).

/// Bits of a byte on the wire.
pub(super) const BITS: u64 = 10;

/// One byte on the line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    /// Sender: a servo's index, or [`MASTER`].
    pub(super) sender: usize,
    pub(super) byte: u8,
    pub(super) start_ns: u64,
    pub(super) bit_ns: u64,
}

/// Index of the master as a sender.
pub(super) const MASTER: usize = usize::MAX;

impl Frame {
    /// Start of its stop bit, from which on it leaves the line high.
    fn stop_ns(&self) -> u64 {
        self.start_ns + (BITS - 1) * self.bit_ns
    }

    pub(super) fn end_ns(&self) -> u64 {
        self.start_ns + BITS * self.bit_ns
    }

    pub(super) fn low(&self, at_ns: u64) -> bool {
        if at_ns < self.start_ns || at_ns >= self.end_ns() {
            return false;
        }
        self.bit_is_low((at_ns - self.start_ns) / self.bit_ns)
    }

    pub(super) fn bit_is_low(&self, bit: u64) -> bool {
        match bit {
            0 => true,
            1..=8 => self.byte >> (bit - 1) & 1 == 0,
            _ => false,
        }
    }
}

/// Number of bytes from which on those that are over are forgotten.
const FRAMES_KEPT: usize = 8;

/// The line, with the bytes that have begun and are still needed by a receiver.
#[derive(Debug, Clone, Default)]
pub(super) struct Line {
    /// In order of their start.
    pub(super) frames: Vec<Frame>,
    /// Time from which on all bytes begun so far leave the line high.
    pub(super) high_ns: u64,
    /// The newest byte began on a line that was high already.
    newest_is_alone: bool,
}

impl Line {
    /// A byte begins.
    pub(super) fn begin(&mut self, frame: Frame) {
        self.newest_is_alone = self.high_ns < frame.start_ns;
        self.high_ns = self.high_ns.max(frame.stop_ns());
        self.frames.push(frame);
    }

    /// The newest byte, if no other one pulls the line low while it is sent.
    #[inline]
    pub(super) fn alone(&self) -> Option<&Frame> {
        self.frames.last().filter(|_| self.newest_is_alone)
    }

    /// The byte of one of the first `senders` servos on the line at `at_ns`.
    pub(super) fn sent_by_servo(&self, servos: usize, at_ns: u64) -> Option<&Frame> {
        let is_sending =
            |f: &&Frame| f.sender < servos && f.start_ns <= at_ns && at_ns < f.end_ns();
        self.frames.iter().find(is_sending)
    }

    /// Whether it is time to [forget](Self::forget) bytes.
    pub(super) fn is_full(&self) -> bool {
        self.frames.len() >= FRAMES_KEPT
    }

    /// Forgets bytes that are over before `needed_ns`.
    pub(super) fn forget(&mut self, needed_ns: u64) {
        self.frames.retain(|frame| frame.end_ns() + 1 >= needed_ns);
    }
}

/// Senders that a receiver can receive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SenderFilter {
    /// All.
    All,
    /// All but the master.
    Servos,
    /// None: the receiver is cut off.
    None,
}

impl SenderFilter {
    pub(super) fn includes(self, frame: &Frame) -> bool {
        match self {
            SenderFilter::All => true,
            SenderFilter::Servos => frame.sender != MASTER,
            SenderFilter::None => false,
        }
    }
}
