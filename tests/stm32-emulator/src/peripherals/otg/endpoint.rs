//! Endpoints: what writes of their control register do, and how they answer the host.

use super::Answer;

const EPENA: u32 = 1 << 31;
const EPDIS: u32 = 1 << 30;
const SD1PID: u32 = 1 << 29;
const SD0PID: u32 = 1 << 28;
const SNAK: u32 = 1 << 27;
const CNAK: u32 = 1 << 26;
const STALL: u32 = 1 << 21;
const NAKSTS: u32 = 1 << 17;
const DPID: u32 = 1 << 16;
const USBAEP: u32 = 1 << 15;

/// Transfer completed.
pub const XFRC: u32 = 1;
/// Endpoint disabled.
const EPDISD: u32 = 1 << 1;
/// SETUP phase done, of an OUT endpoint.
pub const STUP: u32 = 1 << 3;
/// Transmit FIFO empty, of an IN endpoint.
pub const TXFE: u32 = 1 << 7;

/// Fields of a control register that hold what is written.
const HELD: u32 = 0x7FF | USBAEP | 3 << 18 | 1 << 20 | STALL | 0xF << 22;

/// An endpoint of one direction.
#[derive(Clone, Debug, Default)]
pub struct Endpoint {
    control: u32,
    /// USBAEP cannot be cleared: that of endpoint 0.
    is_fixed: bool,
    /// Interrupts raised and not cleared.
    pub interrupts: u32,
    /// Transfer size register.
    pub size: u32,
    /// Bytes written to its FIFO; an OUT endpoint has none.
    pub fifo: Vec<u8>,
}

impl Endpoint {
    /// Endpoint 0, which is always active.
    pub fn zero() -> Self {
        Self {
            control: USBAEP,
            is_fixed: true,
            ..Self::default()
        }
    }

    /// Its control register.
    pub fn control(&self) -> u32 {
        self.control
    }

    fn is_set(&self, bit: u32) -> bool {
        self.control & bit != 0
    }

    fn set(&mut self, bit: u32, is_set: bool) {
        if is_set {
            self.control |= bit;
        } else {
            self.control &= !bit;
        }
    }

    /// Writes its control register.
    pub fn write(&mut self, value: u32) {
        self.control = self.control & !HELD | value & HELD;
        self.set(USBAEP, self.is_set(USBAEP) || self.is_fixed);
        for (bit, field, is_set) in [
            (SNAK, NAKSTS, true),
            (CNAK, NAKSTS, false),
            (SD0PID, DPID, false),
            (SD1PID, DPID, true),
        ] {
            if value & bit != 0 {
                self.set(field, is_set);
            }
        }
        // An endpoint is disabled by EPDIS alone.
        if value & EPDIS == 0 {
            self.set(EPENA, self.is_set(EPENA) || value & EPENA != 0);
        } else if self.is_set(EPENA) {
            self.set(EPENA, false);
            self.interrupts |= EPDISD;
        }
    }

    /// See [`super::Otg::bus_reset`].
    pub fn bus_reset(&mut self) {
        self.control &= !(USBAEP | EPENA | STALL);
        self.set(NAKSTS, true);
        self.set(USBAEP, self.is_fixed);
    }

    /// A SETUP packet came: what follows begins with DATA1.
    pub fn setup(&mut self) {
        self.set(STALL, false);
        self.set(NAKSTS, true);
        self.set(DPID, true);
    }

    /// Bytes of the transfer.
    fn len(&self) -> usize {
        (self.size & 0x7_FFFF) as usize
    }

    /// Whether an OUT transaction would be taken or stalled.
    pub fn is_out_ready(&self) -> bool {
        self.is_set(USBAEP) && (self.is_set(STALL) || !self.is_set(NAKSTS))
    }

    /// Whether an IN transaction would get data or a stall.
    pub fn is_in_ready(&self) -> bool {
        let has_packet = self.is_set(EPENA) && self.fifo.len() >= self.len();
        self.is_out_ready() && (self.is_set(STALL) || has_packet)
    }

    /// The answer to an IN transaction; the host acknowledges the data.
    pub fn input(&mut self) -> Answer {
        if !self.is_set(USBAEP) {
            return Answer::Silence;
        }
        if self.is_set(STALL) {
            return Answer::Stall;
        }
        if !self.is_in_ready() {
            return Answer::Nak;
        }
        let data = self.fifo[..self.len()].to_vec();
        // Words that the packet did not fill are gone with it.
        self.fifo.clear();
        let toggle = self.is_set(DPID);
        self.set(DPID, !toggle);
        self.set(EPENA, false);
        self.size = 0;
        self.interrupts |= XFRC;
        Answer::Data(data, toggle)
    }

    /// The answer to an OUT transaction, whether the packet is new, and whether the transfer
    /// is done with it. The transfer stays enabled: the driver clears NAK for the next one.
    pub fn output(&mut self, len: usize, toggle: bool) -> (Answer, bool, bool) {
        if !self.is_set(USBAEP) {
            return (Answer::Silence, false, false);
        }
        if self.is_set(STALL) {
            return (Answer::Stall, false, false);
        }
        if self.is_set(NAKSTS) {
            return (Answer::Nak, false, false);
        }
        if self.is_set(DPID) != toggle {
            // The host repeats what was taken: acknowledged, and dropped.
            return (Answer::Ack, false, false);
        }
        self.set(DPID, !toggle);
        let left = (self.size >> 19 & 0x3FF).saturating_sub(1);
        let room = self.len().saturating_sub(len) as u32;
        self.size = self.size & 0xE000_0000 | left << 19 | room;
        let is_done = left == 0 || len < (self.control & 0x7FF) as usize;
        if is_done {
            self.set(NAKSTS, true);
        }
        (Answer::Ack, true, is_done)
    }
}
