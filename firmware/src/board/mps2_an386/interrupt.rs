//! Interrupts: numbers, priorities, vectors.
//!
//! | priority | handler                                                   |
//! |----------|-----------------------------------------------------------|
//! | 0        | bus bytes and alarm: a few instructions each              |
//! | 1        | the tick                                                  |
//! | 2        | bytes of link and transparent port                        |
//! | 3        | link, log: what is thread mode on a real board            |
//! | thread   | sleep                                                     |
//!
//! Link, port and log cannot delay the tick, for the reasons given for the
//! real board in [`crate::tasks`], with one exception: a line of the log stops the core, in
//! a critical section, until the host has written it.
//!
//! QEMU takes WFE, by which embassy's thread-mode executor sleeps, for a no-op
//! and would use a whole core of the host. WFI does sleep, but must not be
//! executed after the interrupt it is to wait for; an interrupt executor of the
//! lowest priority makes interrupts the only wake-up source.

use super::{BUS, CLIENT, LINK, real_time};
use cortex_m::interrupt::InterruptNumber;
use cortex_m::peripheral::NVIC;
use embassy_executor::InterruptExecutor;

/// Interrupts of this machine that are used.
#[derive(Clone, Copy, Debug)]
#[repr(u16)]
pub enum Irq {
    /// Link, byte received.
    LinkRx = 0,
    /// Link, transmitter free.
    LinkTx = 1,
    /// Bus, byte received.
    BusRx = 2,
    /// Bus, transmitter free.
    BusTx = 3,
    /// Transparent port, byte received.
    ClientRx = 4,
    /// Transparent port, transmitter free.
    ClientTx = 5,
    /// TIMER1.
    Alarm = 9,
    /// Software interrupt of the executor of all other tasks.
    Rest = 30,
    /// Software interrupt of the tick.
    Tick = 31,
}

/// External interrupts of the machine.
const COUNT: usize = 32;

// SAFETY: the numbers are those of QEMU's mps2-an386, all below `COUNT`.
unsafe impl InterruptNumber for Irq {
    fn number(self) -> u16 {
        self as u16
    }
}

/// Executor of all other tasks.
pub static REST: InterruptExecutor = InterruptExecutor::new();

/// Sets priorities and unmasks interrupts, except for those of the tick and of the executor,
/// which unmask theirs when they start.
pub fn enable(nvic: &mut NVIC) {
    let priorities = [
        (Irq::BusRx, 0),
        (Irq::BusTx, 0),
        (Irq::Alarm, 0),
        (Irq::Tick, 1),
        (Irq::LinkRx, 2),
        (Irq::LinkTx, 2),
        (Irq::ClientRx, 2),
        (Irq::ClientTx, 2),
        (Irq::Rest, 3),
    ];
    for (irq, priority) in priorities {
        // SAFETY: no critical section relies on priorities, they mask all
        // interrupts; and nothing is enabled yet.
        unsafe { nvic.set_priority(irq, priority) };
        if !matches!(irq, Irq::Tick | Irq::Rest) {
            // SAFETY: as above, and the handler is in place.
            unsafe { NVIC::unmask(irq) };
        }
    }
}

extern "C" fn link_rx() {
    LINK.on_receive();
}

extern "C" fn link_tx() {
    LINK.on_transmit();
}

extern "C" fn bus_rx() {
    BUS.on_receive();
    real_time::on_bus_activity();
}

extern "C" fn bus_tx() {
    BUS.on_transmit();
}

extern "C" fn client_rx() {
    CLIENT.on_receive();
}

extern "C" fn client_tx() {
    CLIENT.on_transmit();
}

extern "C" fn alarm() {
    real_time::on_alarm();
}

extern "C" fn tick() {
    real_time::on_tick();
}

extern "C" fn rest() {
    // SAFETY: this is the executor's interrupt handler, and the interrupt is
    // only let through by `REST.start`.
    unsafe { REST.on_interrupt() };
}

unsafe extern "C" {
    /// The handler of exceptions without one of their own, from cortex-m-rt.
    fn DefaultHandler();
}

/// The vector table's part for external interrupts.
// SAFETY: the section is where cortex-m-rt's linker script expects exactly
// this: an array of handlers by interrupt number, named so.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
static __INTERRUPTS: [unsafe extern "C" fn(); COUNT] = {
    let mut vectors: [unsafe extern "C" fn(); COUNT] = [DefaultHandler; COUNT];
    vectors[Irq::LinkRx as usize] = link_rx;
    vectors[Irq::LinkTx as usize] = link_tx;
    vectors[Irq::BusRx as usize] = bus_rx;
    vectors[Irq::BusTx as usize] = bus_tx;
    vectors[Irq::ClientRx as usize] = client_rx;
    vectors[Irq::ClientTx as usize] = client_tx;
    vectors[Irq::Alarm as usize] = alarm;
    vectors[Irq::Rest as usize] = rest;
    vectors[Irq::Tick as usize] = tick;
    vectors
};
