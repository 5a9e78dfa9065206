//! The system around the processor: memory, peripherals, and what is connected to them.
//!
//! | module   | contents                                                     |
//! |----------|--------------------------------------------------------------|
//! | [`map`]  | addresses: which block, which clock gate, which interrupt    |
//! | `access` | reads and writes of the processor                            |
//! | `events` | what blocks do by themselves: bytes, DMA, USB, interrupts    |

mod access;
mod events;
pub mod map;

use std::collections::{BTreeMap, BTreeSet};

use crate::chip::Board;
use crate::line::Line;
use crate::peripherals::dma::Dma;
use crate::peripherals::exti::Exti;
use crate::peripherals::flash::Flash;
use crate::peripherals::gpio::{Edge, Gpio};
use crate::peripherals::iwdg::{Iwdg, NOMINAL_HZ};
use crate::peripherals::otg::Otg;
use crate::peripherals::pwr::Pwr;
use crate::peripherals::rcc::{Rcc, Reset};
use crate::peripherals::timer::Timer;
use crate::peripherals::usart::{Received, Usart};
use crate::time::Time;
use crate::usb_host::UsbHost;

/// An access that the emulator does not model, or that a chip would ignore.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Unmodelled {
    /// No block or register that is known here.
    Address(u32),
    /// The clock of the block is off.
    NoClock(u32),
}

/// Faults of the servo bus between board and servos.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BusFaults {
    /// Bytes that the board sent while its buffer did not drive the line.
    pub undriven: u32,
    /// Bytes of servos that came while the board drove the line.
    pub collisions: u32,
    /// Times at which the board stopped driving within a byte.
    pub cut: u32,
}

/// The system.
#[derive(Clone, Debug)]
pub struct System<L> {
    /// Wiring.
    pub board: Board,
    /// Line of the servo bus.
    pub line: L,
    /// Host at the USB cable.
    pub usb: UsbHost,
    /// Supply of the chip in mV.
    pub supply_mv: u32,
    /// Core and other clocks.
    pub rcc: Rcc,
    /// Pins.
    pub gpio: Gpio,
    /// Flash.
    pub flash: Flash,
    /// Watchdog.
    pub iwdg: Iwdg,
    /// The USB block.
    pub otg: Otg,
    /// SRAM from `0x2000_0000`.
    pub sram: Vec<u8>,
    ccm: Vec<u8>,
    usarts: [Usart; 6],
    timers: [Timer; 4],
    dma: [Dma; 2],
    pwr: Pwr,
    exti: Exti,
    /// Registers that are only stored: DBGMCU, SYSCFG.
    stored: BTreeMap<u32, u32>,
    unmodelled: BTreeSet<Unmodelled>,
    bus_faults: BusFaults,
    edges_seen: usize,
    received: Vec<Received>,
    now: Time,
    /// Duration of a cycle of the core.
    cycle: Time,
    /// Cycles of the core since the last reset, for the flash's prefetch.
    cycles: u64,
    /// Cycles for which the instruction in progress waited.
    stall: u64,
    /// A register was accessed since blocks were last served.
    is_touched: bool,
    next: Time,
}

impl<L: Line> System<L> {
    /// A board that is powered now, with erased flash.
    pub fn new(board: Board, line: L, usb: UsbHost) -> Self {
        let mut gpio = Gpio::new(&[board.direction, board.supply]);
        // The stop switch is closed.
        gpio.drive(Time::ZERO, board.stop, Some(false));
        let mut system = Self {
            rcc: Rcc::new(Some(board.crystal)),
            gpio,
            flash: Flash::new(board.chip.flash),
            iwdg: Iwdg::new(NOMINAL_HZ),
            otg: Otg::with_id(board.chip.otg_id),
            sram: vec![0; board.chip.sram],
            ccm: vec![0; board.chip.ccm],
            usarts: Default::default(),
            timers: timers(),
            dma: Default::default(),
            pwr: Pwr::default(),
            exti: Exti::default(),
            stored: BTreeMap::new(),
            unmodelled: BTreeSet::new(),
            bus_faults: BusFaults::default(),
            edges_seen: 0,
            received: Vec::new(),
            now: Time::ZERO,
            cycle: Time::ZERO,
            cycles: 0,
            stall: 0,
            is_touched: true,
            next: Time::ZERO,
            board,
            line,
            usb,
            supply_mv: 3_300,
        };
        system.update_clocks();
        system
    }

    /// All blocks as after a reset; memory keeps its contents unless power was gone.
    pub fn reset(&mut self, cause: Reset) {
        self.rcc.reset(self.now, cause);
        self.gpio.reset(self.now);
        self.flash.reset();
        self.iwdg = Iwdg::new(self.iwdg.lsi_hz);
        self.otg = Otg::with_id(self.board.chip.otg_id);
        let completed = |usart: &Usart| usart.kept_after_reset();
        self.usarts = std::array::from_fn(|index| completed(&self.usarts[index]));
        self.timers = timers();
        self.dma = Default::default();
        self.pwr = Pwr::default();
        self.exti = Exti::default();
        self.stored.clear();
        if cause == Reset::PowerUp {
            self.sram.fill(0xA5);
            self.ccm.fill(0xA5);
        }
        self.cycles = 0;
        self.stall = 0;
        self.is_touched = true;
        self.update_clocks();
    }

    /// The present time.
    pub fn now(&self) -> Time {
        self.now
    }

    /// Accesses that are not modelled, or that a chip would ignore.
    pub fn unmodelled(&self) -> impl Iterator<Item = Unmodelled> {
        self.unmodelled.iter().copied()
    }

    /// Faults of the bus so far.
    pub fn bus_faults(&self) -> BusFaults {
        self.bus_faults
    }

    /// The USART of the bus.
    pub fn bus_port(&self) -> &Usart {
        &self.usarts[self.board.bus.0 - 1]
    }

    /// TIM2 to TIM5 by its number.
    pub fn timer(&self, number: usize) -> &Timer {
        &self.timers[number - 2]
    }

    /// Changes of the direction pin and of the supply's output so far.
    pub fn edges(&self) -> &[Edge] {
        self.gpio.edges()
    }

    /// Has all blocks served before the next instruction: something outside has changed.
    pub fn touch(&mut self) {
        self.is_touched = true;
    }

    /// Lets the core's cycles pass.
    pub(crate) fn pass(&mut self, cycles: u32) -> u32 {
        let cycles = cycles + std::mem::take(&mut self.stall) as u32;
        self.cycles += u64::from(cycles);
        self.now += self.cycle.times(cycles.into());
        cycles
    }

    /// Jumps to a later time while the core sleeps; returns the cycles of it.
    pub(crate) fn jump(&mut self, to: Time) -> u32 {
        let cycles = (to - self.now).count(self.rcc.clocks().core_hz);
        self.cycles += cycles;
        self.now = to;
        cycles as u32
    }

    /// Time of the next event of any block.
    pub(crate) fn next(&self) -> Time {
        self.next
    }

    /// Whether blocks have to be served now.
    pub(crate) fn is_due(&self) -> bool {
        self.is_touched || self.now >= self.next
    }

    fn update_clocks(&mut self) {
        self.rcc.update(self.now);
        let clocks = self.rcc.clocks();
        self.cycle = Time::periods(1, clocks.core_hz);
        for timer in &mut self.timers {
            timer.set_clock(self.now, clocks.timer1_hz);
        }
        for (index, usart) in self.usarts.iter_mut().enumerate() {
            // USART1 and USART6 are on APB2.
            usart.set_clock(if matches!(index, 0 | 5) {
                clocks.apb2_hz
            } else {
                clocks.apb1_hz
            });
        }
    }
}

/// TIM2 to TIM5.
fn timers() -> [Timer; 4] {
    [32, 16, 16, 32].map(Timer::new)
}
