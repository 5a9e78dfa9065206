//! The servo bus: USART3, its DMA streams and pins, for [`half_duplex`].
//!
//! [`half_duplex`]: crate::board::stm32::half_duplex

use super::{PCLK1_MHZ, time};
use crate::board::stm32::half_duplex::{HalfDuplex, HalfDuplexBus, Stream, Wiring};
use crate::board::stm32::oscillator::{INTERNAL_MHZ, fall_back};
use crate::board::stm32::polled_bus::{PolledBus, set_divider};
use crate::crash::memory;
use embassy_stm32::interrupt;
use embassy_stm32::interrupt::{InterruptExt, Priority};
use embassy_stm32::pac::gpio::Gpio;
use embassy_stm32::pac::gpio::vals::{Moder, Ospeedr, Pupdr};
use embassy_stm32::pac::usart::Usart;
use embassy_stm32::pac::{DMA1, GPIOB, GPIOC, RCC, USART3};

/// PB10 and PB11 are USART3 as alternate function 7 (data sheet, table 9).
const TX_PIN: usize = 10;
const RX_PIN: usize = 11;
const USART3_FUNCTION: u8 = 7;
/// Direction pin: PC6.
const DIRECTION_PIN: usize = 6;

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
        set_divider(USART3, PCLK1_MHZ, baud);
    }
}

static PORT: HalfDuplex<Usart3> = HalfDuplex::new();

/// Starts the bus, at the clocks of [`super::config`].
pub fn start() -> Line {
    set_up(PCLK1_MHZ);
    PORT.start();
    interrupt::USART3.set_priority(Priority::P0);
    // SAFETY: its handler is in place, and no critical section that masks less
    // than all interrupts is in use.
    unsafe { interrupt::USART3.enable() };
    HalfDuplexBus::new(&PORT, time::clock())
}

/// Sets the number of bytes that wakes the tick; see [`HalfDuplex::wake_after`].
pub fn wake_after(bytes: Option<usize>) -> bool {
    PORT.wake_after(bytes)
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
    fall_back();
    set_up(INTERNAL_MHZ);
    PolledBus::new(memory::baud())
}

/// Sets up port and pins without DMA and interrupts, the line released; the port's clock is
/// `clock_mhz`. At 42 and at 16 MHz 1 Mbaud is exact.
fn set_up(clock_mhz: u32) {
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
    set_divider(USART3, clock_mhz, memory::baud());
    // Zero in the others of CR1 and in CR2 is 8N1. TE sends an idle frame first.
    USART3.cr1().modify(|w| {
        w.set_ue(true);
        w.set_te(true);
        w.set_re(true);
    });

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
