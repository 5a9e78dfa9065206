//! The servo bus of the chosen board: its port for the tick, and the same for the stop
//! sequence.

use super::baud::set_divider;
use super::clock_tree::INTERNAL_MHZ;
use super::half_duplex::{HalfDuplex, HalfDuplexBus};
use super::oscillator::fall_back;
use super::polled_bus::PolledBus;
use super::time;
use super::wiring::Wiring;
use crate::board::Chosen;
use crate::crash::memory;
use embassy_stm32::interrupt::{InterruptExt, Priority};
use embassy_stm32::pac::gpio::vals::Pupdr;

/// The bus of this board.
pub type Line = HalfDuplexBus<Chosen>;

static PORT: HalfDuplex<Chosen> = HalfDuplex::new();

/// Starts the bus, at the clocks of [`super::clock_tree`].
pub fn start() -> Line {
    set_up(Chosen::USART_MHZ);
    PORT.start();
    let interrupt = Chosen::USART_INTERRUPT;
    interrupt.set_priority(Priority::P0);
    // SAFETY: its handler is in place, and no critical section that masks less
    // than all interrupts is in use.
    unsafe { interrupt.enable() };
    HalfDuplexBus::new(&PORT, time::clock())
}

/// Sets the number of bytes that wakes the tick; see [`HalfDuplex::wake_after`].
pub fn wake_after(bytes: Option<usize>) -> bool {
    PORT.wake_after(bytes)
}

/// Handles all of the port's interrupts.
pub fn on_interrupt() {
    if PORT.on_interrupt() {
        time::wake();
    }
}

/// Takes the port over from its present owner, for the stop sequence.
pub fn polled() -> PolledBus<Chosen> {
    fall_back();
    set_up(INTERNAL_MHZ);
    PolledBus::new(memory::baud())
}

/// Sets up port and pins without DMA and interrupts, the line released; the port's clock is
/// `clock_mhz`. At 84, 42 and 16 MHz 1 Mbaud is exact.
fn set_up(clock_mhz: u32) {
    Chosen::enable_clocks();
    Chosen::DIRECTION.make_output(false);

    let usart = Chosen::USART;
    usart.cr1().write(|w| w.set_ue(false));
    Chosen::RX.stop();
    Chosen::TX.stop();
    usart.cr3().write(|_| {});
    set_divider(usart, clock_mhz, memory::baud());
    // Zero in the others of CR1 and in CR2 is 8N1. TE sends an idle frame first.
    usart.cr1().modify(|w| {
        w.set_ue(true);
        w.set_te(true);
        w.set_re(true);
    });

    let [tx, rx] = Chosen::USART_PINS;
    tx.connect(Chosen::USART_FUNCTION, Pupdr::PULL_UP);
    rx.connect(Chosen::USART_FUNCTION, Chosen::RX_PULL);
}
