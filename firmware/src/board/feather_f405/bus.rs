//! The servo bus: USART3, its DMA streams and pins, for [`half_duplex`].
//!
//! [`half_duplex`]: crate::board::stm32::half_duplex

use super::{CORE_MHZ, PCLK1_MHZ, time};
use crate::board::stm32::half_duplex::{HalfDuplex, HalfDuplexBus, Stream, Wiring};
use crate::board::stm32::polled_bus::{PolledBus, set_divider};
use crate::crash::memory;
use embassy_stm32::interrupt;
use embassy_stm32::interrupt::{InterruptExt, Priority};
use embassy_stm32::pac::gpio::Gpio;
use embassy_stm32::pac::gpio::vals::{Moder, Ospeedr, Pupdr};
use embassy_stm32::pac::rcc::vals::Sw;
use embassy_stm32::pac::usart::Usart;
use embassy_stm32::pac::{DMA1, GPIOB, GPIOC, RCC, USART3};

/// PB10 and PB11 are USART3 as alternate function 7 (data sheet, table 9).
const TX_PIN: usize = 10;
const RX_PIN: usize = 11;
const USART3_FUNCTION: u8 = 7;
/// Direction pin: PC6.
const DIRECTION_PIN: usize = 6;
/// Core, APB1 and all else after a reset run at the internal oscillator's
/// 16 MHz (section 7.2.2).
const RESET_MHZ: u32 = 16;

/// The bus of this board.
pub type Line = HalfDuplexBus<Usart3>;

/// USART3 and what belongs to it. Channel 4 of streams 1 and 3 is its (section 10.3.3, table 42).
pub struct Usart3;

impl Wiring for Usart3 {
    const USART: Usart = USART3;
    const RX: Stream = Stream {
        dma: DMA1,
        number: 1,
        channel: 4,
    };
    const TX: Stream = Stream {
        dma: DMA1,
        number: 3,
        channel: 4,
    };
    const DIRECTION: (Gpio, usize) = (GPIOC, DIRECTION_PIN);

    /// Keeps it for the stop sequence after a reset, too.
    fn set_baud(baud: u32) {
        memory::set_baud(baud);
        set_divider_for(baud);
    }
}

static PORT: HalfDuplex<Usart3> = HalfDuplex::new();

/// Starts the bus, at the clocks in force.
pub fn start() -> Line {
    set_up();
    PORT.start();
    interrupt::USART3.set_priority(Priority::P0);
    // SAFETY: its handler is in place, and no critical section that masks less
    // than all interrupts is in use.
    unsafe { interrupt::USART3.enable() };
    HalfDuplexBus::new(&PORT, time::clock())
}

/// Sets the number of bytes that wakes the tick; see [`HalfDuplex::expect`].
pub fn expect(bytes: Option<usize>) -> bool {
    PORT.expect(bytes)
}

/// One handler for all of the port's interrupts.
#[embassy_stm32::interrupt]
fn USART3() {
    if PORT.on_interrupt() {
        time::wake();
    }
}

/// Takes the port over from its present owner, for the stop sequence.
pub fn polled() -> PolledBus<Usart3> {
    set_up();
    let (core_mhz, usart_mhz) = if runs_at_full_speed() {
        (CORE_MHZ, PCLK1_MHZ)
    } else {
        (RESET_MHZ, RESET_MHZ)
    };
    PolledBus::new(core_mhz, usart_mhz, memory::baud())
}

/// Sets up port and pins without DMA and interrupts, the line released.
fn set_up() {
    RCC.ahb1enr().modify(|w| {
        w.set_gpioben(true);
        w.set_gpiocen(true);
        w.set_dma1en(true);
    });
    RCC.apb1enr().modify(|w| w.set_usart3en(true));
    // Reading back makes sure that the clocks are on (section 7.2.13).
    let _ = (RCC.ahb1enr().read(), RCC.apb1enr().read());

    Usart3::drive(false);
    GPIOC
        .moder()
        .modify(|w| w.set_moder(DIRECTION_PIN, Moder::OUTPUT));

    USART3.cr1().write(|w| w.set_ue(false));
    Usart3::stop_dma();
    // Zero in CR1 and CR2 is 8N1. TE sends an idle frame first.
    USART3.cr1().write(|w| {
        w.set_ue(true);
        w.set_te(true);
        w.set_re(true);
    });
    set_divider_for(memory::baud());

    for pin in [TX_PIN, RX_PIN] {
        GPIOB
            .afr(pin / 8)
            .modify(|w| w.set_afr(pin % 8, USART3_FUNCTION));
        // A bit is 1 µs: edges of the second speed, 10 ns, suffice.
        GPIOB
            .ospeedr()
            .modify(|w| w.set_ospeedr(pin, Ospeedr::MEDIUM_SPEED));
        // The receive buffer is off while sending: its output floats, so the pin has a pull-up.
        GPIOB.pupdr().modify(|w| w.set_pupdr(pin, Pupdr::PULL_UP));
        GPIOB.moder().modify(|w| w.set_moder(pin, Moder::ALTERNATE));
    }
}

/// Sets the divider for the clocks in force. At 42 and at 16 MHz it is exact for 1 Mbaud.
fn set_divider_for(baud: u32) {
    let clock_mhz = if runs_at_full_speed() {
        PCLK1_MHZ
    } else {
        RESET_MHZ
    };
    set_divider(USART3, clock_mhz, baud);
}

/// Whether the core runs at [`CORE_MHZ`].
fn runs_at_full_speed() -> bool {
    RCC.cfgr().read().sws() == Sw::PLL1_P
}
