//! The loops of the bridge, the same on every board.
//!
//! [`real_time`] runs in an interrupt executor above everything but the
//! handlers that move single bytes; [`link`] and [`client`] run in thread mode.
//! They share only the channels behind [`Bridge`], [`LinkPort`] and [`PortEnd`],
//! and [`News`].
//!
//! # Nothing keeps the tick waiting
//!
//! Whatever runs below the tick is interrupted by it. It could only wait for what
//! they share, and there it never waits:
//!
//! * Channels are lock-free queues for one writer and one reader. A full one
//!   refuses, an empty one says so. How many orders a turn takes is bounded by their
//!   size, so a flood on the link costs the tick no more than that.
//! * A critical section masks all interrupts, on a single core, so that its length
//!   is the only delay; nobody is interrupted who holds one. The longest are: a line
//!   of the log copied to RTT, which drops what does not fit instead of waiting for
//!   a reader; a packet of 64 bytes copied to the USB controller; a look at the
//!   timers of two tasks. Each is some hundred instructions, a few µs at 168 MHz.
//! * Above the tick are the handlers of bus bytes and alarm, and a byte comes at
//!   most every 5 µs (2 Mbaud).
//!
//! Should it wait all the same, the watchdog is not fed.

use crate::end::memory;
use armbridge_shared::bridge::gateway::{ClientLine, PortEnd};
use armbridge_shared::bridge::{Bridge, LinkPort, Progress, QueueWatch};
use armbridge_shared::link::frame;
use armbridge_shared::link::message::{Mode, Stack, StopSource};
use armbridge_shared::servo::port::SetBaud;
use armbridge_shared::store::Store;
use core::convert::Infallible;
use core::future::{Future, poll_fn};
use core::pin::{Pin, pin};
use core::task::Poll;
use embassy_futures::select::{Either, Either3, select, select3};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embedded_hal::digital::OutputPin;
use embedded_hal_nb::serial;
use embedded_storage::nor_flash::NorFlash;

use crate::settings;

/// What the real-time loop needs of a board, beside the bus.
pub trait RealTime {
    /// Time since boot in µs; never goes back.
    fn now_us(&self) -> u64;

    /// Starts measuring how long something takes.
    fn start_stopwatch(&mut self);

    /// Time since [`Self::start_stopwatch`] in ns; wrong beyond 4 s.
    fn stopwatch_ns(&self) -> u32;

    /// Waits for bus activity (a byte, the end of a transmission) or until
    /// `until_us`, whichever is first. May return early. Fewer bytes than
    /// `bytes_wanted` need not end the wait, and none need where that is `None`.
    fn wait(&mut self, until_us: u64, bytes_wanted: Option<usize>) -> impl Future<Output = ()>;

    /// A tick went well: the watchdog may live on.
    fn tick_was_good(&mut self);

    /// Whether the emergency stop's switch is open, or its wire broken. Asked in
    /// every turn of the real-time loop, and so in every tick.
    fn is_stop_pressed(&mut self) -> bool;
}

/// What the real-time loop tells the rest, latest value only.
#[derive(Default)]
pub struct News {
    /// There is a frame to send.
    pub ran: Signal<CriticalSectionRawMutex, ()>,
    /// There are bytes for the client of the transparent port, or there is room for
    /// its.
    pub served: Signal<CriticalSectionRawMutex, ()>,
    /// The mode has changed.
    pub mode: Signal<CriticalSectionRawMutex, Mode>,
}

impl News {
    /// Nothing new.
    pub const fn new() -> Self {
        Self {
            ran: Signal::new(),
            served: Signal::new(),
            mode: Signal::new(),
        }
    }
}

/// The tick, for ever.
///
/// The bridge is borrowed: a future keeps what it is given twice, as its argument
/// and as its variable, and this one would be built on the stack first.
/// `watch` is that of the bridge's end of the queues.
pub async fn real_time<S, D, B>(
    bridge: &mut Bridge<'_, S, D>,
    mut watch: QueueWatch<'_>,
    mut board: B,
    news: &News,
) -> !
where
    S: serial::Read<u8> + serial::Write<u8> + SetBaud,
    D: OutputPin,
    B: RealTime,
{
    let mut mode = None;
    loop {
        if board.is_stop_pressed() {
            bridge.emergency_stop(StopSource::Pin);
        }
        let progress = poll(bridge, board.now_us());
        memory::set_tick(bridge.tick());
        match progress {
            // Torque is off and the bus makes progress: no doubt in that.
            Ok(Progress::Searching) => board.tick_was_good(),
            Ok(Progress::Served) => {}
            Ok(Progress::Sampled) => {
                board.start_stopwatch();
                decide(bridge);
                let compute_ns = board.stopwatch_ns();
                if publish(bridge, compute_ns) {
                    board.tick_was_good();
                }
            }
            Err(nb::Error::WouldBlock) => {
                if watch.has_link_news() {
                    news.ran.signal(());
                }
                if watch.has_client_news() {
                    news.served.signal(());
                }
                if mode != Some(bridge.mode()) {
                    mode = Some(bridge.mode());
                    news.mode.signal(bridge.mode());
                }
                board.wait(bridge.wake_at_us(), bridge.bytes_wanted()).await;
            }
            Err(nb::Error::Other(never)) => match never {},
        }
    }
}

// The three parts of a turn are functions of their own. Merged into the loop they
// share one frame of 5 kB, and its addresses, some 490, are computed and spilled at
// every poll, whatever that comes to do.

/// [`Bridge::poll`].
#[inline(never)]
fn poll<S, D>(bridge: &mut Bridge<'_, S, D>, now_us: u64) -> nb::Result<Progress, Infallible>
where
    S: serial::Read<u8> + serial::Write<u8> + SetBaud,
    D: OutputPin,
{
    bridge.poll(now_us)
}

/// [`Bridge::decide`].
#[inline(never)]
fn decide<S, D>(bridge: &mut Bridge<'_, S, D>)
where
    S: serial::Read<u8> + serial::Write<u8> + SetBaud,
    D: OutputPin,
{
    bridge.decide();
}

/// [`Bridge::publish`].
#[inline(never)]
fn publish<S, D>(bridge: &mut Bridge<'_, S, D>, compute_ns: u32) -> bool
where
    S: serial::Read<u8> + serial::Write<u8> + SetBaud,
    D: OutputPin,
{
    bridge.publish(compute_ns)
}

/// `future` if `condition` holds; never otherwise. No `async` block does as well:
/// it panics when it is asked once more after its end, and the compiler cannot
/// see that nobody does.
fn when<F: Future>(condition: bool, mut future: Pin<&mut F>) -> impl Future<Output = F::Output> {
    poll_fn(move |context| {
        if condition {
            future.as_mut().poll(context)
        } else {
            Poll::Pending
        }
    })
}

/// Bytes from the host.
pub trait FromHost {
    /// Waits for bytes, returns how many. May be dropped at any time without
    /// loss: what it did not report was not taken.
    fn read(&mut self, buffer: &mut [u8]) -> impl Future<Output = usize>;
}

/// Bytes to the host.
pub trait ToHost {
    /// Waits until some of `bytes` can be sent, returns how many were. May be
    /// dropped at any time: what it did not report was not sent.
    fn write(&mut self, bytes: &[u8]) -> impl Future<Output = usize>;
}

/// Bytes from the client of the transparent port.
pub trait FromClient: FromHost {
    /// What it has set its port to.
    fn line(&self) -> ClientLine;
}

/// When the client sets its port to something else.
pub trait LineChanges {
    /// Waits for it.
    fn changed(&mut self) -> impl Future<Output = ()>;
}

/// Moves bytes between a client and the transparent port, for ever. `wake` makes
/// the real-time loop look at what has come.
pub async fn client(
    mut port: PortEnd<'_>,
    mut from_client: impl FromClient,
    mut to_client: impl ToHost,
    mut changes: impl LineChanges,
    wake: impl Fn(),
    news: &News,
) -> ! {
    const CHUNK: usize = 64;
    let mut received = [0; CHUNK];
    let mut answer = heapless::Vec::<u8, CHUNK>::new();
    loop {
        port.set_line(from_client.line());
        while !answer.is_full()
            && let Some(byte) = port.transmit()
        {
            // There is room.
            let _ = answer.push(byte);
        }
        // A USB packet comes whole or not at all: the client waits until there is
        // room for the longest.
        let has_room = port.room() >= CHUNK;
        let is_silent = answer.is_empty();
        let happened = {
            let input = pin!(from_client.read(&mut received));
            let served = pin!(news.served.wait());
            let output = pin!(to_client.write(&answer));
            let output = select(when(is_silent, served), when(!is_silent, output));
            select3(when(has_room, input), output, changes.changed()).await
        };
        match happened {
            Either3::First(len) => {
                port.receive(received.get(..len).unwrap_or(&received));
                wake();
            }
            Either3::Second(Either::First(())) => {}
            Either3::Second(Either::Second(len)) => {
                let left = answer.len().saturating_sub(len);
                answer.rotate_right(left);
                answer.truncate(left);
            }
            Either3::Third(()) => {
                port.set_line(from_client.line());
                wake();
            }
        }
    }
}

/// Moves bytes between the host and `port`, for ever, and settings to `store`; both
/// are borrowed as the bridge is in [`real_time`]. A host that does not read delays
/// nothing but this loop; it still hears what the host says. Now and then `watch` is
/// asked how much stack was used.
pub async fn link(
    port: &mut LinkPort<'_>,
    mut from_host: impl FromHost,
    mut to_host: impl ToHost,
    store: &mut Store<impl NorFlash>,
    mut watch: impl FnMut() -> Option<Stack>,
    news: &News,
) -> ! {
    let mut frame = [0; frame::MAX];
    let mut pending = 0..0;
    let mut received = [0; 64];
    loop {
        if let Some(stack) = watch() {
            port.set_stack(stack);
        }
        settings::keep(port, store);
        if pending.is_empty() {
            pending = 0..next_frame(port, &mut frame);
        }
        let bytes = frame.get(pending.clone()).unwrap_or_default();
        let is_silent = bytes.is_empty();
        let happened = {
            let ran = pin!(news.ran.wait());
            let output = pin!(to_host.write(bytes));
            let output = select(when(is_silent, ran), when(!is_silent, output));
            select(from_host.read(&mut received), output).await
        };
        match happened {
            Either::First(len) => receive(port, received.get(..len).unwrap_or(&received)),
            Either::Second(Either::First(())) => {}
            Either::Second(Either::Second(len)) => pending.start += len,
        }
    }
}

// Functions of their own, as the parts of the tick are: a command that designs gains
// and a save take some kB of stack each, but not at the same time.

/// [`LinkPort::receive`].
#[inline(never)]
fn receive(port: &mut LinkPort<'_>, bytes: &[u8]) {
    port.receive(bytes);
}

/// Puts the next frame for the host into `frame`; its length, 0 if there is none.
#[inline(never)]
fn next_frame(port: &mut LinkPort<'_>, frame: &mut [u8; frame::MAX]) -> usize {
    let Some(next) = port.transmit() else {
        return 0;
    };
    let len = next.len().min(frame.len());
    frame[..len].copy_from_slice(&next[..len]);
    len
}

#[cfg(test)]
mod tests {
    use super::*;
    use armbridge_shared::bridge::Channels;
    use armbridge_shared::link::message::{Fault, Settings};
    use embassy_futures::poll_once;

    /// A bus that takes every byte, and nobody answers.
    struct Nobody;

    impl embedded_hal_nb::serial::ErrorType for Nobody {
        type Error = embedded_hal_nb::serial::ErrorKind;
    }

    impl serial::Read<u8> for Nobody {
        fn read(&mut self) -> nb::Result<u8, Self::Error> {
            Err(nb::Error::WouldBlock)
        }
    }

    impl serial::Write<u8> for Nobody {
        fn write(&mut self, _byte: u8) -> nb::Result<(), Self::Error> {
            Ok(())
        }

        fn flush(&mut self) -> nb::Result<(), Self::Error> {
            Ok(())
        }
    }

    impl SetBaud for Nobody {
        fn set_baud(&mut self, _baud: u32) {}
    }

    impl embedded_hal::digital::ErrorType for Nobody {
        type Error = Infallible;
    }

    impl OutputPin for Nobody {
        fn set_low(&mut self) -> Result<(), Infallible> {
            Ok(())
        }

        fn set_high(&mut self) -> Result<(), Infallible> {
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

        async fn wait(&mut self, _until_us: u64, _bytes_wanted: Option<usize>) {
            core::future::pending::<()>().await;
        }

        fn tick_was_good(&mut self) {}

        fn is_stop_pressed(&mut self) -> bool {
            self.0
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
            let bridge = Bridge::new(Nobody, Nobody, end, 0, &Settings::default());
            let Ok(mut bridge) = bridge else {
                panic!("the default settings have no controller");
            };
            let news = News::new();
            let _ = poll_once(real_time(&mut bridge, watch, Switch(is_pressed), &news));
            assert_eq!(news.mode.try_take(), Some(mode));
        }
    }
}
