//! Time and tick: the clock on TIM5, the tick in its interrupt handler, the stopwatch on the
//! cycle counter.
//!
//! TIM5 is for the tick alone; tasks in thread mode wait with embassy's timers, on TIM2. What
//! else starts the tick, the bus and a client, makes TIM5's interrupt pending.

use super::clock::Clock;
use super::clock_tree::{CORE_MHZ, PCLK1_MHZ};
use super::pin::Pin;
use super::wiring::Wiring;
use super::{bus, watchdog};
use crate::board::Chosen;
use crate::handler_cell::HandlerCell;
use crate::tasks::{RealTime, RealTimeLoop};
use armbridge_link::message::StopSource;
use cortex_m::peripheral::DWT;
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_stm32::pac::{RCC, TIM5};

/// Longest interval between polls of the emergency stop, in µs.
pub const STOP_LOOK_US: u32 = 1_000;

/// The tick of this board.
pub type Tick = RealTimeLoop<'static, bus::Line, Board, Pin>;

static CLOCK: Clock = Clock::new(TIM5);
static TICK: HandlerCell<Tick> = HandlerCell::new();

/// Starts the clock, at the clocks of [`super::clock_tree`].
pub fn start() {
    RCC.apb1enr().modify(|w| w.set_tim5en(true));
    // Reading back makes sure that the clock is on (section 7.2.13).
    let _ = RCC.apb1enr().read();
    // APB1 is divided.
    CLOCK.start(2 * PCLK1_MHZ as u16);
}

/// The clock of the tick.
pub fn clock() -> &'static Clock {
    &CLOCK
}

/// Time since [`start`] in µs.
pub fn now_us() -> u64 {
    CLOCK.now_us()
}

/// Starts the tick, which runs at once.
pub fn start_tick(tick: Tick) {
    TICK.put(tick);
    interrupt::TIM5.set_priority(Priority::P1);
    wake();
    // SAFETY: its handler is in place and its state too, and no critical section that masks
    // less than all interrupts is in use.
    unsafe { interrupt::TIM5.enable() };
}

/// Lets the tick run as soon as priorities permit.
pub fn wake() {
    interrupt::TIM5.pend();
}

/// The tick's interrupt handler.
#[embassy_stm32::interrupt]
fn TIM5() {
    CLOCK.clear_alarm();
    let Some(wait) = TICK.with(RealTimeLoop::run) else {
        return;
    };
    // What has come since the tick looked starts it again.
    if bus::wake_after(wait.bytes) || !CLOCK.set_alarm(wait.until_us, STOP_LOOK_US) {
        wake();
    }
}

/// The board for the real-time loop.
pub struct Board {
    has_crystal: bool,
    begun: u32,
}

impl Board {
    /// A board whose watchdog is running, and its cycle counter too.
    pub fn new(has_crystal: bool) -> Self {
        Chosen::STOP.make_pulled_up();
        Self {
            has_crystal,
            begun: 0,
        }
    }
}

impl RealTime for Board {
    fn now_us(&self) -> u64 {
        now_us()
    }

    fn start_stopwatch(&mut self) {
        self.begun = DWT::cycle_count();
    }

    fn stopwatch_ns(&self) -> u32 {
        let cycles = DWT::cycle_count().wrapping_sub(self.begun);
        // In 32 bits, which the processor divides: right up to 0.2 s.
        const { assert!(CORE_MHZ.is_multiple_of(8)) };
        cycles.saturating_mul(1000 / 8) / (CORE_MHZ / 8)
    }

    fn note_good_tick(&mut self) {
        watchdog::feed();
    }

    fn stop_source(&mut self) -> Option<StopSource> {
        if Chosen::STOP.is_high() {
            Some(StopSource::Pin)
        } else if self.has_crystal {
            None
        } else {
            Some(StopSource::Crystal)
        }
    }
}
