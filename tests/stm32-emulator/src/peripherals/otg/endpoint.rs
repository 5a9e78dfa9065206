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

/// What both directions have.
#[derive(Clone, Debug, Default)]
struct Control {
    word: u32,
    /// USBAEP cannot be cleared: that of endpoint 0.
    is_fixed: bool,
}

impl Control {
    fn is_set(&self, bit: u32) -> bool {
        self.word & bit != 0
    }

    fn set(&mut self, bit: u32, is_set: bool) {
        if is_set {
            self.word |= bit;
        } else {
            self.word &= !bit;
        }
    }

    /// A write; true if it disables the endpoint.
    fn write(&mut self, value: u32) -> bool {
        self.word = self.word & !HELD | value & HELD;
        self.set(USBAEP, self.is_set(USBAEP) || self.is_fixed);
        if value & SNAK != 0 {
            self.set(NAKSTS, true);
        }
        if value & CNAK != 0 {
            self.set(NAKSTS, false);
        }
        if value & SD0PID != 0 {
            self.set(DPID, false);
        }
        if value & SD1PID != 0 {
            self.set(DPID, true);
        }
        if value & EPDIS != 0 && self.is_set(EPENA) {
            self.set(EPENA, false);
            return true;
        }
        // An endpoint is disabled by EPDIS alone.
        if value & EPENA != 0 && value & EPDIS == 0 {
            self.set(EPENA, true);
        }
        false
    }

    fn bus_reset(&mut self) {
        self.word &= !(USBAEP | EPENA | STALL);
        self.word |= NAKSTS;
        self.set(USBAEP, self.is_fixed);
    }
}

/// An IN endpoint.
#[derive(Clone, Debug, Default)]
pub struct InEndpoint {
    control: Control,
    /// Interrupts raised and not cleared.
    pub interrupts: u32,
    /// Transfer size register.
    pub size: u32,
    /// Bytes written to its FIFO.
    pub fifo: Vec<u8>,
}

impl InEndpoint {
    /// Its control register.
    pub fn control(&self) -> u32 {
        self.control.word
    }

    /// Writes its control register.
    pub fn write(&mut self, value: u32) {
        if self.control.write(value) {
            self.interrupts |= EPDISD;
        }
    }

    /// See [`super::Otg::bus_reset`].
    pub fn bus_reset(&mut self) {
        self.control.bus_reset();
    }

    /// Endpoint 0, which is always active.
    pub fn control_endpoint() -> Self {
        let control = Control {
            word: USBAEP,
            is_fixed: true,
        };
        Self {
            control,
            ..Self::default()
        }
    }

    /// A SETUP packet came: its data stage begins with DATA1.
    pub fn setup(&mut self) {
        self.control.set(STALL, false);
        self.control.set(NAKSTS, true);
        self.control.set(DPID, true);
    }

    fn len(&self) -> usize {
        (self.size & 0x7_FFFF) as usize
    }

    /// See [`super::Otg::is_in_ready`].
    pub fn is_ready(&self) -> bool {
        self.control.is_set(USBAEP)
            && (self.control.is_set(STALL)
                || self.control.is_set(EPENA)
                    && !self.control.is_set(NAKSTS)
                    && self.fifo.len() >= self.len())
    }

    /// See [`super::Otg::input`].
    pub fn input(&mut self) -> Answer {
        if !self.control.is_set(USBAEP) {
            return Answer::Silence;
        }
        if self.control.is_set(STALL) {
            return Answer::Stall;
        }
        if !self.is_ready() {
            return Answer::Nak;
        }
        let data = self.fifo[..self.len()].to_vec();
        // Words that the packet did not fill are gone with it.
        self.fifo.clear();
        let toggle = self.control.is_set(DPID);
        self.control.set(DPID, !toggle);
        self.control.set(EPENA, false);
        self.size = 0;
        self.interrupts |= XFRC;
        Answer::Data(data, toggle)
    }
}

/// An OUT endpoint.
#[derive(Clone, Debug, Default)]
pub struct OutEndpoint {
    control: Control,
    /// Interrupts raised and not cleared.
    pub interrupts: u32,
    /// Transfer size register.
    pub size: u32,
}

impl OutEndpoint {
    /// Its control register.
    pub fn control(&self) -> u32 {
        self.control.word
    }

    /// Writes its control register.
    pub fn write(&mut self, value: u32) {
        if self.control.write(value) {
            self.interrupts |= EPDISD;
        }
    }

    /// See [`super::Otg::bus_reset`].
    pub fn bus_reset(&mut self) {
        self.control.bus_reset();
    }

    /// Endpoint 0, which is always active.
    pub fn control_endpoint() -> Self {
        let control = Control {
            word: USBAEP,
            is_fixed: true,
        };
        Self {
            control,
            ..Self::default()
        }
    }

    /// A SETUP packet came.
    pub fn setup(&mut self) {
        self.control.set(STALL, false);
        self.control.set(NAKSTS, true);
        self.control.set(DPID, true);
    }

    fn packets(&self) -> u32 {
        self.size >> 19 & 0x3FF
    }

    /// Whether an OUT transaction would be taken or stalled.
    pub fn is_ready(&self) -> bool {
        self.control.is_set(USBAEP) && (self.control.is_set(STALL) || !self.control.is_set(NAKSTS))
    }

    /// The answer to an OUT transaction, whether the packet is new, and whether the transfer
    /// is done with it. The transfer stays enabled: the driver clears NAK for the next one.
    pub fn out(&mut self, len: usize, toggle: bool) -> (Answer, bool, bool) {
        if !self.control.is_set(USBAEP) {
            return (Answer::Silence, false, false);
        }
        if self.control.is_set(STALL) {
            return (Answer::Stall, false, false);
        }
        if self.control.is_set(NAKSTS) {
            return (Answer::Nak, false, false);
        }
        if self.control.is_set(DPID) != toggle {
            // The host repeats what was taken: acknowledged, and dropped.
            return (Answer::Ack, false, false);
        }
        self.control.set(DPID, !toggle);
        let left = self.packets().saturating_sub(1);
        let room = (self.size & 0x7_FFFF).saturating_sub(len as u32);
        self.size = self.size & 0xE000_0000 | left << 19 | room;
        let is_done = left == 0 || len < (self.control.word & 0x7FF) as usize;
        if is_done {
            self.control.set(NAKSTS, true);
        }
        (Answer::Ack, true, is_done)
    }
}
