//! The real-time loop: the stop switch, the tick, the servos' supply, and feeding of the
//! watchdog.
//!
//! It is a state machine in an interrupt handler. A board calls [`RealTimeLoop::run`] at each
//! of three kinds of events, and nothing else advances the tick:
//!
//! | event                                  | in a tick with Morpheus servos at 1 kHz     |
//! |----------------------------------------|---------------------------------------------|
//! | the alarm at [`Wait::until_us`]        | the period begins; CYCLE is due; time-out of the replies |
//! | [`Wait::bytes`] bytes from the bus, or an error of its receiver | the replies are complete |
//! | bytes from the client of the transparent port | none                                 |
//!
//! There is no executor and no queue of timers between an event and the tick, and an alarm
//! replaces the one before. A call without an event does no harm.

use super::signals::Signals;
use crate::crash::memory;
use armbridge_board::bridge::supply_relay::SupplyPermission;
use armbridge_board::bridge::{Bridge, Progress, QueueWatch};
use armbridge_link::message::{Mode, StopSource};
use armbridge_servo::bus::Bus;
use core::convert::Infallible;
use embedded_hal::digital::OutputPin;

/// Services of a board for the real-time loop, beside the bus.
pub trait RealTime {
    /// Time since boot in µs; never goes back.
    fn now_us(&self) -> u64;

    /// Starts the stopwatch.
    fn start_stopwatch(&mut self);

    /// Time since [`Self::start_stopwatch`] in ns; too short beyond 0.2 s.
    fn stopwatch_ns(&self) -> u32;

    /// Feeds the watchdog after a good tick.
    fn note_good_tick(&mut self);

    /// The source of an emergency stop, for as long as there is one: the stop switch is open,
    /// or its wire broken, or the board cannot keep time. Read in every iteration of the
    /// real-time loop, and so in every tick.
    fn stop_source(&mut self) -> Option<StopSource>;
}

/// Condition of the next run: a time, or a number of bytes from the bus, whichever is first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wait {
    /// Latest time, in µs.
    pub until_us: u64,
    /// Number of received bytes, if any: fewer need not end the wait.
    pub bytes: Option<usize>,
}

/// See the [module](self).
pub struct RealTimeLoop<'a, L, B, P> {
    bridge: &'a mut Bridge<'a, L>,
    watch: QueueWatch<'a>,
    board: B,
    supply: P,
    signals: &'a Signals,
    /// The mode as signalled last.
    mode: Option<Mode>,
}

impl<'a, L, B, P> RealTimeLoop<'a, L, B, P>
where
    L: Bus,
    B: RealTime,
    P: OutputPin<Error = Infallible>,
{
    /// A loop that has not run yet. `watch` is that of the bridge's end of the queues;
    /// `supply` is high while servos may have power.
    pub fn new(
        bridge: &'a mut Bridge<'a, L>,
        watch: QueueWatch<'a>,
        board: B,
        supply: P,
        signals: &'a Signals,
    ) -> Self {
        Self {
            bridge,
            watch,
            board,
            supply,
            signals,
            mode: None,
        }
    }

    /// Runs until there is nothing to do but wait. Never blocks; a call ends, because each
    /// iteration ends a transaction or a step of one.
    pub fn run(&mut self) -> Wait {
        loop {
            let Self {
                bridge,
                board,
                supply,
                ..
            } = self;
            let stop = board.stop_source();
            if let Some(source) = stop {
                bridge.emergency_stop(source);
            }
            let progress = poll(bridge, board.now_us());
            // A fault that the host clears while the switch is open is back in the next iteration.
            let permission = match bridge.supply() {
                SupplyPermission::On if stop.is_none() => SupplyPermission::On,
                _ => SupplyPermission::Off,
            };
            let Ok(()) = supply.set_state(permission.into());
            memory::set_tick(bridge.tick());
            match progress {
                // Torque is off and the bus makes progress: counts as a good tick.
                Ok(Progress::Searching) => board.note_good_tick(),
                Ok(Progress::Served) => {}
                Ok(Progress::Sampled) => {
                    board.start_stopwatch();
                    decide(bridge);
                    let compute_ns = board.stopwatch_ns();
                    if publish(bridge, compute_ns) {
                        board.note_good_tick();
                    }
                }
                Err(nb::Error::WouldBlock) => {
                    self.notify();
                    return Wait {
                        until_us: self.bridge.wake_at_us(),
                        bytes: self.bridge.bytes_wanted(),
                    };
                }
                Err(nb::Error::Other(never)) => match never {},
            }
        }
    }

    /// Signals to the loops in thread mode what has changed for them.
    fn notify(&mut self) {
        if self.watch.has_link_activity() {
            self.signals.frame_ready.signal(());
        }
        if self.watch.has_client_activity() {
            self.signals.client_bytes.signal(());
        }
        let mode = self.bridge.mode();
        if self.mode != Some(mode) {
            self.mode = Some(mode);
            self.signals.mode.signal(mode);
        }
    }
}

// The three parts of an iteration are separate functions. Merged into the loop they
// share one frame of 5 kB, and its addresses, some 490, are computed and spilled at
// every poll, whichever part runs.

/// [`Bridge::poll`].
#[inline(never)]
fn poll(bridge: &mut Bridge<'_, impl Bus>, now_us: u64) -> nb::Result<Progress, Infallible> {
    bridge.poll(now_us)
}

/// [`Bridge::decide`].
#[inline(never)]
fn decide(bridge: &mut Bridge<'_, impl Bus>) {
    bridge.decide();
}

/// [`Bridge::publish`].
#[inline(never)]
fn publish(bridge: &mut Bridge<'_, impl Bus>, compute_ns: u32) -> bool {
    bridge.publish(compute_ns)
}

#[cfg(test)]
mod tests {
    use super::*;
    use armbridge_board::bridge::Channels;
    use armbridge_link::message::{Fault, Settings};
    use armbridge_servo::port::SetBaud;
    use armbridge_servo::serial_bus::SerialBus;
    use core::cell::Cell;
    use embedded_hal_nb::serial;

    /// A bus without servos: it takes every byte and returns none.
    struct EmptyBus;

    impl embedded_hal_nb::serial::ErrorType for EmptyBus {
        type Error = embedded_hal_nb::serial::ErrorKind;
    }

    impl serial::Read<u8> for EmptyBus {
        fn read(&mut self) -> nb::Result<u8, Self::Error> {
            Err(nb::Error::WouldBlock)
        }
    }

    impl serial::Write<u8> for EmptyBus {
        fn write(&mut self, _byte: u8) -> nb::Result<(), Self::Error> {
            Ok(())
        }

        fn flush(&mut self) -> nb::Result<(), Self::Error> {
            Ok(())
        }
    }

    impl SetBaud for EmptyBus {
        fn set_baud(&mut self, _baud: u32) {}
    }

    impl embedded_hal::digital::ErrorType for EmptyBus {
        type Error = Infallible;
    }

    impl OutputPin for EmptyBus {
        fn set_low(&mut self) -> Result<(), Infallible> {
            Ok(())
        }

        fn set_high(&mut self) -> Result<(), Infallible> {
            Ok(())
        }
    }

    /// An output, and what it was set to last.
    struct Output<'a>(&'a Cell<Option<bool>>);

    impl embedded_hal::digital::ErrorType for Output<'_> {
        type Error = Infallible;
    }

    impl OutputPin for Output<'_> {
        fn set_low(&mut self) -> Result<(), Infallible> {
            self.0.set(Some(false));
            Ok(())
        }

        fn set_high(&mut self) -> Result<(), Infallible> {
            self.0.set(Some(true));
            Ok(())
        }
    }

    /// Time that stands still; the switch is pressed or not.
    struct Switch(bool);

    impl RealTime for Switch {
        fn now_us(&self) -> u64 {
            0
        }

        fn start_stopwatch(&mut self) {}

        fn stopwatch_ns(&self) -> u32 {
            0
        }

        fn note_good_tick(&mut self) {}

        fn stop_source(&mut self) -> Option<StopSource> {
            self.0.then_some(StopSource::Pin)
        }
    }

    #[test]
    fn the_stop_switch_is_heeded_before_anything_is_waited_for() {
        for (is_pressed, mode) in [
            (false, Mode::Boot),
            (true, Mode::Fault(Fault::EmergencyStop(StopSource::Pin))),
        ] {
            let mut channels = Channels::new();
            let (end, ..) = channels.split();
            let watch = end.watch();
            let bus = SerialBus::new(EmptyBus, EmptyBus);
            let bridge = Bridge::new(bus, end, 0, &Settings::default());
            let Ok(mut bridge) = bridge else {
                panic!("the default settings have no controller");
            };
            let signals = Signals::new();
            let is_powered = Cell::new(None);
            let supply = Output(&is_powered);
            let switch = Switch(is_pressed);
            RealTimeLoop::new(&mut bridge, watch, switch, supply, &signals).run();
            assert_eq!(signals.mode.try_take(), Some(mode));
            assert_eq!(is_powered.get(), Some(!is_pressed));
        }
    }
}
