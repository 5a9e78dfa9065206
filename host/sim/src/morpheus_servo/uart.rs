//! The serial port of the microcontroller, between the wire and the program.
//!
//! The receiver holds two complete bytes and a third in its shift register; the next
//! start bit overwrites the third. The transmitter buffers one byte behind the one on
//! the wire, and starts a byte only on a tick of its bit clock, which runs from the
//! set-up of the port.

/// The serial port; times are in processor cycles.
#[derive(Debug, Clone)]
pub(super) struct Uart {
    /// Start of the bit clock.
    epoch: u64,
    /// Length of one bit.
    bit: u64,
    received: [u8; 2],
    held: usize,
    shifted_in: Option<u8>,
    overruns: u32,
    /// Start of the newest byte in the transmitter.
    start: u64,
    /// Its end.
    end: u64,
    /// A byte was sent since the flag below was last cleared.
    sent: bool,
    /// Transmitter-empty flag, not yet cleared.
    ran_empty: bool,
}

impl Uart {
    pub(super) fn new(now: u64, divisor: u8) -> Self {
        let mut uart = Self {
            epoch: 0,
            bit: 1,
            received: [0; 2],
            held: 0,
            shifted_in: None,
            overruns: 0,
            start: 0,
            end: 0,
            sent: false,
            ran_empty: false,
        };
        uart.set_up(now, divisor);
        uart
    }

    /// Sets the rate: 2 000 000 / (divisor + 1) baud.
    pub(super) fn set_up(&mut self, now: u64, divisor: u8) {
        self.epoch = now;
        self.bit = 8 * (u64::from(divisor) + 1);
    }

    pub(super) fn bit(&self) -> u64 {
        self.bit
    }

    pub(super) fn overruns(&self) -> u32 {
        self.overruns
    }

    /// Processes a start bit.
    pub(super) fn start_bit(&mut self) {
        if self.shifted_in.take().is_some() {
            self.overruns += 1;
        }
    }

    /// Stores a byte, when its stop bit is sampled.
    pub(super) fn arrived(&mut self, byte: u8) {
        match self.received.get_mut(self.held) {
            Some(place) => {
                *place = byte;
                self.held += 1;
            }
            None => self.shifted_in = Some(byte),
        }
    }

    /// Whether the next start bit overwrites a byte.
    pub(super) fn is_full(&self) -> bool {
        self.shifted_in.is_some()
    }

    pub(super) fn has_byte(&self) -> bool {
        self.held > 0
    }

    pub(super) fn take(&mut self) -> Option<u8> {
        if self.held == 0 {
            return None;
        }
        let byte = self.received[0];
        self.received[0] = self.received[1];
        self.held -= 1;
        if let Some(next) = self.shifted_in.take() {
            self.arrived(next);
        }
        Some(byte)
    }

    /// Whether there is room for another byte to send.
    pub(super) fn can_send(&self, now: u64) -> bool {
        now >= self.start
    }

    /// Sends a byte; returns the start of its start bit.
    pub(super) fn send(&mut self, now: u64) -> u64 {
        self.ran_empty = self.ran_empty(now);
        self.start = if now > self.end {
            self.epoch + (now - self.epoch).next_multiple_of(self.bit)
        } else {
            self.end
        };
        self.end = self.start + 10 * self.bit;
        self.sent = true;
        self.start
    }

    /// State of the transmitter-empty flag.
    pub(super) fn ran_empty(&self, now: u64) -> bool {
        self.ran_empty || (self.sent && now >= self.end)
    }

    /// End of the newest byte sent; the next one does not begin before.
    pub(super) fn sent_until(&self) -> u64 {
        self.end
    }

    pub(super) fn clear_ran_empty(&mut self, now: u64) {
        self.ran_empty = false;
        self.sent &= now < self.end;
    }
}
