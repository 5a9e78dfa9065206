//! Reset and clock control (section 7): oscillators, PLL, switch, prescalers, clock gates
//! and the flags of the last reset.
//!
//! Clocks are computed from the registers as written. Oscillators need their start-up time;
//! a crystal that is not there never becomes ready, and one that fails while the clock
//! security system watches it leaves the chip on the internal oscillator with an NMI.

use crate::time::Time;

/// Internal oscillator in Hz.
pub const HSI_HZ: u32 = 16_000_000;
/// Start-up of the crystal: typical (data sheet, table 31).
const HSE_START: Time = Time::from_us(2_000);
/// Start-up of the internal oscillator: typical (table 33).
const HSI_START: Time = Time::from_us(3);
/// Lock of the PLL: the most that table 36 gives.
const PLL_LOCK: Time = Time::from_us(200);
/// Start-up of the low-speed oscillator (table 34).
const LSI_START: Time = Time::from_us(15);

const CR_HSION: u32 = 1;
const CR_HSEON: u32 = 1 << 16;
const CR_HSEBYP: u32 = 1 << 18;
const CR_CSSON: u32 = 1 << 19;
const CR_PLLON: u32 = 1 << 24;
/// Word of DCKCFGR2, and its choice of the clock of USB (RM0390, section 6.3.28).
const DCKCFGR2: usize = 0x94 / 4;
const CK48MSEL: u32 = 1 << 27;
const CSR_LSION: u32 = 1;
const CIR_CSSF: u32 = 1 << 7;
/// Cause flags in CSR (section 7.3.21).
const CSR_FLAGS: u32 = 0xFE00_0000;

/// Why the chip was reset last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reset {
    /// Power came.
    PowerUp,
    /// The supply fell below the level in the option bytes.
    BrownOut,
    /// The reset pin.
    Pin,
    /// The independent watchdog.
    Watchdog,
    /// The program.
    Software,
}

impl Reset {
    /// Its flags in CSR: each internal reset drives the pin too.
    fn flags(self) -> u32 {
        let pin = 1 << 26;
        match self {
            Self::PowerUp => pin | 1 << 25 | 1 << 27,
            Self::BrownOut => pin | 1 << 25,
            Self::Pin => pin,
            Self::Watchdog => pin | 1 << 29,
            Self::Software => pin | 1 << 28,
        }
    }
}

/// Circuit at the chip's pins of the high-speed oscillator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crystal {
    /// Frequency in Hz.
    pub hz: u32,
    /// A clock from outside, for which the chip's own oscillator must be bypassed.
    pub is_external: bool,
}

/// Clocks in Hz.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Clocks {
    /// Of the core, AHB and memory.
    pub core_hz: u32,
    /// Of peripherals on APB1.
    pub apb1_hz: u32,
    /// Of peripherals on APB2.
    pub apb2_hz: u32,
    /// Of timers on APB1.
    pub timer1_hz: u32,
    /// Of timers on APB2.
    pub timer2_hz: u32,
    /// Of USB; 0 without PLL.
    pub usb_hz: u32,
}

/// A peripheral's bit in an enable register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gate {
    /// Offset of the register.
    pub offset: u32,
    /// The bit.
    pub bit: u32,
}

/// An oscillator that needs time to start.
#[derive(Clone, Copy, Debug, Default)]
struct Oscillator {
    ready_at: Option<Time>,
}

impl Oscillator {
    fn switch(&mut self, is_on: bool, now: Time, start: Time) {
        match (is_on, self.ready_at) {
            (true, None) => self.ready_at = Some(now + start),
            (false, _) => self.ready_at = None,
            (true, Some(_)) => {}
        }
    }

    fn is_ready(self, now: Time) -> bool {
        self.ready_at.is_some_and(|at| at <= now)
    }
}

/// The block.
#[derive(Clone, Debug)]
pub struct Rcc {
    /// The crystal, if it swings.
    crystal: Option<Crystal>,
    control: u32,
    pll: u32,
    configuration: u32,
    interrupts: u32,
    status: u32,
    /// Registers without a function here but to be read back: resets, gates, and others.
    others: [u32; 0x98 / 4],
    hsi: Oscillator,
    hse: Oscillator,
    lock: Oscillator,
    lsi: Oscillator,
    clocks: Clocks,
    is_nmi: bool,
}

impl Rcc {
    /// After power-up, with this crystal.
    pub fn new(crystal: Option<Crystal>) -> Self {
        let mut rcc = Self {
            crystal,
            control: 0,
            pll: 0,
            configuration: 0,
            interrupts: 0,
            status: 0,
            others: [0; 0x98 / 4],
            hsi: Oscillator::default(),
            hse: Oscillator::default(),
            lock: Oscillator::default(),
            lsi: Oscillator::default(),
            clocks: Clocks::default(),
            is_nmi: false,
        };
        rcc.reset(Time::ZERO, Reset::PowerUp);
        rcc
    }

    /// Registers as after a reset for this reason (section 7.3); flags of earlier resets stay
    /// until they are cleared, except at power-up.
    pub fn reset(&mut self, now: Time, cause: Reset) {
        let kept = match cause {
            Reset::PowerUp => 0,
            _ => self.status & CSR_FLAGS,
        };
        self.control = 0x83;
        self.pll = 0x2400_3010;
        self.configuration = 0;
        self.interrupts = 0;
        self.status = kept | cause.flags();
        self.others = [0; 0x98 / 4];
        self.others[0x30 / 4] = 0x0010_0000;
        self.hsi.ready_at = Some(now);
        self.hse.ready_at = None;
        self.lock.ready_at = None;
        self.lsi.ready_at = None;
        self.is_nmi = false;
        self.update(now);
    }

    /// The clocks in force.
    pub fn clocks(&self) -> Clocks {
        self.clocks
    }

    /// Whether the peripheral behind a gate has a clock.
    pub fn is_enabled(&self, gate: Gate) -> bool {
        self.others[gate.offset as usize / 4] >> gate.bit & 1 != 0
    }

    /// Whether the security system's NMI is pending.
    pub fn is_nmi(&self) -> bool {
        self.is_nmi
    }

    /// The crystal stops.
    pub fn fail_crystal(&mut self, now: Time) {
        self.crystal = None;
        let was_used = self.hse.is_ready(now);
        if was_used && self.control & CR_CSSON != 0 {
            // Section 7.2.7: the oscillator is switched off, and the PLL that it fed.
            self.control &= !(CR_HSEON | CR_CSSON);
            self.hse.ready_at = None;
            if self.pll >> 22 & 1 != 0 {
                self.control &= !CR_PLLON;
                self.lock.ready_at = None;
            }
            self.configuration &= !3;
            self.control |= CR_HSION;
            self.hsi.switch(true, now, Time::ZERO);
            self.interrupts |= CIR_CSSF;
            self.is_nmi = true;
        }
        self.update(now);
    }

    /// A crystal swings again when it is started next.
    pub fn mend_crystal(&mut self, crystal: Crystal) {
        self.crystal = Some(crystal);
    }

    /// Reads a register.
    pub fn read(&self, now: Time, offset: u32) -> Option<u32> {
        let ready = |is_ready: bool, bit: u32| u32::from(is_ready) << bit;
        Some(match offset {
            0x00 => {
                self.control
                    | ready(self.hsi.is_ready(now), 1)
                    | ready(self.is_hse_ready(now), 17)
                    | ready(self.is_pll_ready(now), 25)
            }
            0x04 => self.pll,
            0x08 => self.configuration | self.switched(now) << 2,
            0x0C => self.interrupts,
            0x74 => self.status | ready(self.lsi.is_ready(now), 1),
            0x10..0x98 => self.others[offset as usize / 4],
            _ => return None,
        })
    }

    /// Writes a register; `None` if there is none.
    pub fn write(&mut self, now: Time, offset: u32, value: u32) -> Option<()> {
        match offset {
            0x00 => {
                self.control = value & !(1 << 1 | 1 << 17 | 1 << 25);
                self.hsi.switch(value & CR_HSION != 0, now, HSI_START);
                self.hse.switch(value & CR_HSEON != 0, now, HSE_START);
                self.lock.switch(value & CR_PLLON != 0, now, PLL_LOCK);
            }
            0x04 => self.pll = value,
            0x08 => self.configuration = value & !0xC,
            0x0C => {
                // Flags are cleared by bits 16 to 23.
                self.interrupts = self.interrupts & 0xFF & !(value >> 16) | value & 0x7F00;
                self.is_nmi &= self.interrupts & CIR_CSSF != 0;
            }
            0x74 => {
                self.status = self.status & CSR_FLAGS | value & CSR_LSION;
                if value >> 24 & 1 != 0 {
                    self.status &= !CSR_FLAGS;
                }
                self.lsi.switch(value & CSR_LSION != 0, now, LSI_START);
            }
            0x10..0x98 => self.others[offset as usize / 4] = value,
            _ => return None,
        }
        self.update(now);
        Some(())
    }

    fn is_hse_ready(&self, now: Time) -> bool {
        self.hse_hz(now).is_some()
    }

    /// Frequency from the crystal in Hz, once it has started.
    fn hse_hz(&self, now: Time) -> Option<u32> {
        let is_bypassed = self.control & CR_HSEBYP != 0;
        let crystal = self
            .crystal
            .filter(|crystal| crystal.is_external == is_bypassed)?;
        self.hse.is_ready(now).then_some(crystal.hz)
    }

    fn is_pll_ready(&self, now: Time) -> bool {
        self.lock.is_ready(now) && self.pll_hz(now).is_some()
    }

    /// Source of the system clock: 0 the internal oscillator, 1 the crystal, 2 the PLL. A
    /// switch waits for its source (section 7.2.6).
    fn switched(&self, now: Time) -> u32 {
        match self.configuration & 3 {
            1 if self.is_hse_ready(now) => 1,
            2 if self.is_pll_ready(now) => 2,
            _ => 0,
        }
    }

    /// Output of the PLL's oscillator in Hz, if it has an input.
    fn pll_hz(&self, now: Time) -> Option<u32> {
        let source = match self.pll >> 22 & 1 {
            0 => self.hsi.is_ready(now).then_some(HSI_HZ),
            _ => self.hse_hz(now),
        }?;
        let (divider, factor) = (self.pll & 0x3F, self.pll >> 6 & 0x1FF);
        (divider >= 2).then(|| source / divider * factor)
    }

    /// Computes the clocks again.
    pub fn update(&mut self, now: Time) {
        let pll_hz = self.pll_hz(now).filter(|_| self.lock.is_ready(now));
        let system_hz = match (self.switched(now), pll_hz) {
            (1, _) => self.hse_hz(now).unwrap_or(HSI_HZ),
            (2, Some(pll_hz)) => pll_hz / (2 * (self.pll >> 16 & 3) + 2),
            _ => HSI_HZ,
        };
        let core_hz = system_hz >> ahb_shift(self.configuration >> 4 & 0xF);
        let apb = |field: u32| apb_shift(self.configuration >> field & 7);
        let bus = |field| core_hz >> apb(field);
        // Section 7.2: timers run at twice the bus's clock unless that is undivided.
        let timer = |field| bus(field) << u32::from(apb(field) != 0);
        // The F446 can take the clock of USB from another PLL, which is not modelled.
        let is_from_pll = self.others[DCKCFGR2] & CK48MSEL == 0;
        let usb_hz = pll_hz.filter(|_| is_from_pll);
        self.clocks = Clocks {
            core_hz,
            apb1_hz: bus(10),
            apb2_hz: bus(13),
            timer1_hz: timer(10),
            timer2_hz: timer(13),
            usb_hz: usb_hz.map_or(0, |hz| hz / (self.pll >> 24 & 0xF).max(1)),
        };
    }

    /// Time of the next change that happens by itself: an oscillator is ready.
    pub fn next(&self, now: Time) -> Time {
        [self.hsi, self.hse, self.lock, self.lsi]
            .iter()
            .filter_map(|oscillator| oscillator.ready_at)
            .filter(|at| *at > now)
            .min()
            .unwrap_or(Time::NEVER)
    }
}

/// Prescaler of AHB as a shift (HPRE, section 7.3.3).
fn ahb_shift(field: u32) -> u32 {
    match field {
        0..=7 => 0,
        8..=11 => field - 7,
        _ => field - 6,
    }
}

/// Prescaler of an APB as a shift (PPRE).
fn apb_shift(field: u32) -> u32 {
    field.saturating_sub(3)
}

#[cfg(test)]
mod tests;
