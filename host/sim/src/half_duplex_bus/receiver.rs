//! Decoding of the line by one receiver, bit by bit.
//!
//! A byte that pulls the line low alone, at the receiver's rate, is decoded as a whole:
//! its samples could give nothing else.

use super::line::{BITS, Line, SenderFilter};

/// From three quarters of the stop bit, the time of its last sample, to the
/// reception of the byte: up to two cycles of the servos' processor. Fitted to the
/// recorded latencies at 9600 to 2 000 000 baud, which a fraction of a bit
/// alone does not explain.
const SYNCHRONISED_NS: u64 = 94;

/// A byte as decoded.
#[derive(Debug, Clone, Copy)]
pub(super) struct Decoded {
    pub(super) byte: u8,
    pub(super) framing_error: bool,
}

/// An asynchronous receiver: waits for a falling edge, then samples each bit
/// in its middle.
#[derive(Debug, Clone)]
pub(super) struct Receiver {
    filter: SenderFilter,
    /// Start of the present receiver state, and the state before.
    since_ns: u64,
    before: SenderFilter,
    bit_ns: u64,
    start_ns: Option<u64>,
    /// A falling edge that is not yet confirmed as a start bit.
    unconfirmed_edge_ns: Option<u64>,
    /// End of the present byte, or the next known falling edge.
    next_ns: u64,
}

impl Receiver {
    pub(super) fn new(filter: SenderFilter, bit_ns: u64) -> Self {
        Self {
            filter,
            since_ns: 0,
            before: filter,
            bit_ns,
            start_ns: None,
            unconfirmed_edge_ns: None,
            next_ns: u64::MAX,
        }
    }

    pub(super) fn next_ns(&self) -> u64 {
        self.next_ns
    }

    /// Time before which it decodes no byte, if none begins before `start_ns`
    /// but those on the line now.
    pub(super) fn earliest_byte_ns(&self, start_ns: u64) -> u64 {
        if self.next_ns == u64::MAX {
            start_ns.saturating_add(self.decoded_after_ns())
        } else {
            self.next_ns
        }
    }

    /// From the start of a byte to its reception.
    fn decoded_after_ns(&self) -> u64 {
        // Above 2 Mbaud the next start bit would come before: it must not be missed.
        let synchronised_ns = SYNCHRONISED_NS.min((self.bit_ns / 4).saturating_sub(2));
        (4 * BITS - 1) * self.bit_ns / 4 + synchronised_ns
    }

    /// The earliest time at which it may have to sample the line.
    pub(super) fn earliest_sample_ns(&self, now_ns: u64) -> u64 {
        self.start_ns.or(self.unconfirmed_edge_ns).unwrap_or(now_ns)
    }

    /// Length of a bit at its rate.
    pub(super) fn bit_ns(&self) -> u64 {
        self.bit_ns
    }

    /// Sets the rate for later bytes.
    pub(super) fn set_bit(&mut self, bit_ns: u64) {
        self.bit_ns = bit_ns;
    }

    fn low(&self, line: &Line, at_ns: u64) -> bool {
        let filter = if at_ns >= self.since_ns {
            self.filter
        } else {
            self.before
        };
        line.frames
            .iter()
            .any(|f| filter.includes(f) && f.low(at_ns))
    }

    /// Enables or disables it. Returns true if a start bit is detected at once.
    pub(super) fn set_filter(&mut self, filter: SenderFilter, now_ns: u64, line: &Line) -> bool {
        if filter == self.filter {
            return false;
        }
        self.before = self.filter;
        self.filter = filter;
        self.since_ns = now_ns;
        self.waiting() && self.find_start_bit(now_ns, line)
    }

    /// Waiting for a start bit: detects one at `now_ns`. If there is none, stores the
    /// next known falling edge.
    #[inline]
    pub(super) fn find_start_bit(&mut self, now_ns: u64, line: &Line) -> bool {
        self.next_ns = u64::MAX;
        // The usual cases: the line is high, or pulled low by only one byte, which begins now.
        if line.high_ns <= now_ns {
            return false;
        }
        match line.alone() {
            Some(only) if only.start_ns == now_ns && only.bit_ns == self.bit_ns => {
                self.filter.includes(only) && self.begin(now_ns)
            }
            _ => self.search_start_bit(now_ns, line),
        }
    }

    fn search_start_bit(&mut self, now_ns: u64, line: &Line) -> bool {
        let Some(edge) = self.falling_edge(now_ns, line) else {
            return false;
        };
        self.next_ns = edge;
        if edge > now_ns {
            return false;
        }
        // A start bit is low for half a bit at least. Bytes not yet begun may
        // still pull the line low by then.
        let middle = edge + self.bit_ns / 2;
        if self.low(line, middle) {
            return self.begin(edge);
        }
        self.unconfirmed_edge_ns = Some(edge);
        self.next_ns = middle;
        false
    }

    fn begin(&mut self, edge: u64) -> bool {
        self.start_ns = Some(edge);
        self.next_ns = edge + self.decoded_after_ns();
        true
    }

    /// Detects a start bit at the expected edge, while no byte is being received.
    pub(super) fn process_edge(&mut self, now_ns: u64, line: &Line) -> bool {
        match self.unconfirmed_edge_ns.take() {
            Some(edge) if self.low(line, now_ns) => self.begin(edge),
            _ => self.find_start_bit(now_ns, line),
        }
    }

    fn falling_edge(&self, from_ns: u64, line: &Line) -> Option<u64> {
        let falls = |at: u64| {
            self.low(line, at) && (at == 0 || at == self.since_ns || !self.low(line, at - 1))
        };
        if falls(from_ns) {
            return Some(from_ns);
        }
        // The sender of the edge begins a low bit then.
        let received = line.frames.iter().filter(|f| self.filter.includes(f));
        let edges = received.filter_map(|f| {
            let first = from_ns.saturating_sub(f.start_ns).div_ceil(f.bit_ns);
            (first..BITS)
                .filter(|&bit| f.bit_is_low(bit))
                .map(|bit| f.start_ns + bit * f.bit_ns)
                .find(|&at| at > from_ns && falls(at))
        });
        edges.min()
    }

    /// Whether it waits for a falling edge.
    pub(super) fn waiting(&self) -> bool {
        self.start_ns.is_none() && self.unconfirmed_edge_ns.is_none()
    }

    /// Whether it is in the middle of a byte.
    pub(super) fn receiving(&self) -> bool {
        self.start_ns.is_some()
    }

    /// Completes the byte: three quarters of the stop bit have passed, and
    /// the receiver has processed it.
    pub(super) fn finish(&mut self, now_ns: u64, line: &Line) -> Option<Decoded> {
        let start = self.start_ns.take()?;
        let decoded = self.decode(start, line);
        self.find_start_bit(now_ns + 1, line);
        Some(decoded)
    }

    fn decode(&self, start: u64, line: &Line) -> Decoded {
        if let Some(only) = line.alone()
            && only.start_ns == start
            && only.bit_ns == self.bit_ns
            && self.filter.includes(only)
            && self.since_ns <= start
        {
            return Decoded {
                byte: only.byte,
                framing_error: false,
            };
        }
        let sample = |bit: u64| !self.low(line, start + (2 * bit + 1) * self.bit_ns / 2);
        let byte = (0..8).fold(0, |byte, bit| byte | u8::from(sample(bit + 1)) << bit);
        Decoded {
            byte,
            framing_error: !sample(BITS - 1),
        }
    }
}
