//! USART (section 30): a byte at a time, with the duration of its bits.
//!
//! A byte that is written moves to the shift register, takes ten bits there, and is on the
//! line from the beginning of its start bit; TC is raised at the end of the last stop bit.
//! Enabling the transmitter sends an idle frame first. Received bytes come from the line
//! with the time of their stop bit; one that is not read before the next is lost, and
//! ORE says so. IDLE is raised a frame after the last of them.

use crate::time::Time;

const SR_FE: u32 = 1 << 1;
const SR_NE: u32 = 1 << 2;
const SR_ORE: u32 = 1 << 3;
const SR_IDLE: u32 = 1 << 4;
const SR_RXNE: u32 = 1 << 5;
const SR_TC: u32 = 1 << 6;
const SR_TXE: u32 = 1 << 7;
/// Flags that a read of SR and then of DR clears.
const SR_READ: u32 = SR_FE | SR_NE | SR_ORE | SR_IDLE;

const CR1_RE: u32 = 1 << 2;
const CR1_TE: u32 = 1 << 3;
const CR1_IDLEIE: u32 = 1 << 4;
const CR1_RXNEIE: u32 = 1 << 5;
const CR1_TCIE: u32 = 1 << 6;
const CR1_TXEIE: u32 = 1 << 7;
const CR1_OVER8: u32 = 1 << 15;
const CR1_UE: u32 = 1 << 13;
const CR3_EIE: u32 = 1;
const CR3_DMAR: u32 = 1 << 6;
const CR3_DMAT: u32 = 1 << 7;

/// Bits of a frame: start, eight, stop.
const FRAME_BITS: u64 = 10;

/// A byte from the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Received {
    /// When its stop bit is sampled.
    pub at: Time,
    /// The byte.
    pub byte: u8,
    /// The stop bit was low.
    pub framing_error: bool,
    /// Samples of a bit disagreed.
    pub noise: bool,
}

/// A byte that goes to the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sent {
    /// Begin of its start bit.
    pub at: Time,
    /// End of its stop bit.
    pub end: Time,
    /// The byte.
    pub byte: u8,
    /// Bits per second.
    pub baud: u32,
}

/// Content of the shift register.
#[derive(Clone, Copy, Debug)]
struct Shift {
    end: Time,
    is_byte: bool,
}

/// The block.
#[derive(Clone, Debug)]
pub struct Usart {
    clock_hz: u32,
    status: u32,
    divider: u32,
    control: [u32; 3],
    guard: u32,
    /// Written, not yet in the shift register.
    waiting: Option<u8>,
    shift: Option<Shift>,
    /// Last received byte.
    data: u8,
    /// SR was read, which is half of clearing its flags.
    is_status_read: bool,
    idle_at: Option<Time>,
    /// Bytes that began to be sent, for the line.
    sent: Vec<Sent>,
    /// Times at which a transmission was complete.
    completed: Vec<Time>,
    overruns: u32,
}

impl Default for Usart {
    fn default() -> Self {
        Self {
            clock_hz: 0,
            status: SR_TXE | SR_TC,
            divider: 0,
            control: [0; 3],
            guard: 0,
            waiting: None,
            shift: None,
            data: 0,
            is_status_read: false,
            idle_at: None,
            sent: Vec::new(),
            completed: Vec::new(),
            overruns: 0,
        }
    }
}

impl Usart {
    /// Sets its clock.
    pub fn set_clock(&mut self, hz: u32) {
        self.clock_hz = hz;
    }

    /// Rate in bits per second; 0 before it is set.
    pub fn baud(&self) -> u32 {
        let divider = match self.control[0] & CR1_OVER8 {
            0 => self.divider,
            // Section 30.3.4: the fraction has three bits, of eighths.
            _ => (self.divider >> 4) * 8 + (self.divider & 7),
        };
        self.clock_hz
            .checked_div(divider)
            .filter(|_| self.control[0] & CR1_UE != 0)
            .unwrap_or(0)
    }

    fn bits(&self, count: u64) -> Time {
        Time::periods(count, self.baud())
    }

    fn is_on(&self, bit: u32) -> bool {
        self.control[0] & (CR1_UE | bit) == CR1_UE | bit
    }

    /// Receives a byte from the line.
    pub fn receive(&mut self, byte: Received) {
        if !self.is_on(CR1_RE) {
            return;
        }
        self.idle_at = Some(byte.at + self.bits(FRAME_BITS));
        if self.status & SR_RXNE != 0 {
            self.status |= SR_ORE;
            self.overruns += 1;
            return;
        }
        self.data = byte.byte;
        self.status |= SR_RXNE;
        if byte.framing_error {
            self.status |= SR_FE;
        }
        if byte.noise {
            self.status |= SR_NE;
        }
    }

    /// Executes its events up to `now`.
    pub fn advance(&mut self, now: Time) {
        while let Some(shift) = self.shift.filter(|shift| shift.end <= now) {
            self.shift = None;
            if self.waiting.is_some() {
                self.load(shift.end);
            } else if shift.is_byte {
                self.status |= SR_TC;
                self.completed.push(shift.end);
            }
        }
        if self.idle_at.is_some_and(|at| at <= now) {
            self.idle_at = None;
            self.status |= SR_IDLE;
        }
    }

    /// Moves the waiting byte to the shift register.
    fn load(&mut self, now: Time) {
        if self.shift.is_some() || !self.is_on(CR1_TE) || self.baud() == 0 {
            return;
        }
        let Some(byte) = self.waiting.take() else {
            return;
        };
        self.status |= SR_TXE;
        let end = now + self.bits(FRAME_BITS);
        self.shift = Some(Shift { end, is_byte: true });
        self.sent.push(Sent {
            at: now,
            end,
            byte,
            baud: self.baud(),
        });
    }

    /// Whether its interrupt line is high.
    pub fn is_interrupt(&self) -> bool {
        let [control, _, third] = self.control;
        let pairs = [
            (CR1_RXNEIE, SR_RXNE | SR_ORE),
            (CR1_TXEIE, SR_TXE),
            (CR1_TCIE, SR_TC),
            (CR1_IDLEIE, SR_IDLE),
        ];
        let normal = pairs
            .iter()
            .any(|(enable, flags)| control & enable != 0 && self.status & flags != 0);
        let errors = SR_FE | SR_NE | SR_ORE;
        normal || third & (CR3_EIE | CR3_DMAR) == CR3_EIE | CR3_DMAR && self.status & errors != 0
    }

    /// Whether it asks the DMA to take a byte.
    pub fn wants_read(&self) -> bool {
        self.control[2] & CR3_DMAR != 0 && self.status & SR_RXNE != 0
    }

    /// Whether it asks the DMA for a byte.
    pub fn wants_write(&self) -> bool {
        self.control[2] & CR3_DMAT != 0 && self.status & SR_TXE != 0 && self.is_on(CR1_TE)
    }

    /// Time of its next event.
    pub fn next(&self) -> Time {
        let shift = self.shift.map_or(Time::NEVER, |shift| shift.end);
        shift.min(self.idle_at.unwrap_or(Time::NEVER))
    }

    /// Takes the bytes that began to be sent.
    pub fn take_sent(&mut self) -> Vec<Sent> {
        std::mem::take(&mut self.sent)
    }

    /// Whether there are any of them.
    pub fn has_sent(&self) -> bool {
        !self.sent.is_empty()
    }

    /// Whether a byte is on the line at this time.
    pub fn is_sending(&self, at: Time) -> bool {
        self.shift
            .is_some_and(|shift| shift.is_byte && at < shift.end)
    }

    /// As after a reset, with what a test asks of it later.
    #[must_use]
    pub fn kept_after_reset(&self) -> Self {
        Self {
            clock_hz: self.clock_hz,
            completed: self.completed.clone(),
            overruns: self.overruns,
            ..Self::default()
        }
    }

    /// Ends of transmissions so far.
    pub fn completed(&self) -> &[Time] {
        &self.completed
    }

    /// Received bytes that were lost since the one before was not read.
    pub fn overruns(&self) -> u32 {
        self.overruns
    }

    /// Reads a register.
    pub fn read(&mut self, now: Time, offset: u32) -> Option<u32> {
        self.advance(now);
        Some(match offset {
            0x00 => {
                self.is_status_read = true;
                self.status
            }
            0x04 => self.take_data().into(),
            0x08 => self.divider,
            0x0C..=0x14 => self.control[(offset as usize - 0x0C) / 4],
            0x18 => self.guard,
            _ => return None,
        })
    }

    /// Takes the received byte, as a read of DR does.
    pub fn take_data(&mut self) -> u8 {
        self.status &= !SR_RXNE;
        if self.is_status_read {
            self.status &= !SR_READ;
            self.is_status_read = false;
        }
        self.data
    }

    /// Writes a register; `None` if there is none.
    pub fn write(&mut self, now: Time, offset: u32, value: u32) -> Option<()> {
        self.advance(now);
        match offset {
            // RXNE and TC are cleared by writing 0.
            0x00 => self.status &= value | !(SR_RXNE | SR_TC),
            0x04 => self.put_data(now, value as u8),
            0x08 => self.divider = value & 0xFFFF,
            0x0C => {
                let was_sending = self.is_on(CR1_TE);
                self.control[0] = value;
                if value & CR1_UE == 0 {
                    // Section 30.6.4: the present byte is cut off.
                    self.shift = None;
                    self.waiting = None;
                    self.status |= SR_TXE | SR_TC;
                } else if self.is_on(CR1_TE) && !was_sending {
                    let end = now + self.bits(FRAME_BITS);
                    self.shift = Some(Shift {
                        end,
                        is_byte: false,
                    });
                }
            }
            0x10 | 0x14 => self.control[(offset as usize - 0x0C) / 4] = value,
            0x18 => self.guard = value,
            _ => return None,
        }
        Some(())
    }

    /// Takes a byte to send, as a write of DR does.
    pub fn put_data(&mut self, now: Time, byte: u8) {
        if self.is_status_read {
            self.status &= !SR_TC;
            self.is_status_read = false;
        }
        if !self.is_on(CR1_TE) {
            return;
        }
        // A byte that still waits is overwritten.
        self.waiting = Some(byte);
        self.status &= !SR_TXE;
        self.load(now);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A port at 1 Mbaud, its idle frame sent.
    fn port() -> Usart {
        let mut port = Usart::default();
        port.set_clock(42_000_000);
        let on = CR1_UE | CR1_TE | CR1_RE;
        for (offset, value) in [(0x08, 42), (0x0C, on)] {
            assert_eq!(port.write(Time::ZERO, offset, value), Some(()));
        }
        port.advance(Time::from_us(10));
        port
    }

    #[test]
    fn two_bytes_leave_back_to_back_and_then_the_transmission_is_complete() {
        let mut port = port();
        let at = Time::from_us;
        // Reading SR, then writing DR, clears TC.
        assert_eq!(port.read(at(20), 0).map(|s| s & SR_TC), Some(SR_TC));
        assert_eq!(port.write(at(20), 4, 0xAA), Some(()));
        assert_eq!(port.write(at(21), 4, 0x55), Some(()));
        assert_eq!(port.read(at(39), 0).map(|s| s & SR_TC), Some(0));
        port.advance(at(40));
        let sent: Vec<_> = port.take_sent().iter().map(|s| (s.at, s.byte)).collect();
        assert_eq!(sent, [(at(20), 0xAA), (at(30), 0x55)]);
        assert_eq!(port.completed(), [at(40)]);
    }

    #[test]
    fn a_byte_that_is_not_read_in_time_is_lost() {
        let mut port = port();
        for (us, byte) in [(30, 1), (40, 2)] {
            port.receive(Received {
                at: Time::from_us(us),
                byte,
                framing_error: false,
                noise: false,
            });
        }
        let status = port.read(Time::from_us(41), 0).unwrap();
        assert_eq!(status & (SR_ORE | SR_RXNE), SR_ORE | SR_RXNE);
        assert_eq!(port.read(Time::from_us(41), 4), Some(1));
        assert_eq!(port.read(Time::from_us(41), 0).map(|s| s & SR_ORE), Some(0));
        port.advance(Time::from_us(50));
        assert_eq!(
            port.read(Time::from_us(51), 0).map(|s| s & SR_IDLE),
            Some(SR_IDLE)
        );
    }
}
