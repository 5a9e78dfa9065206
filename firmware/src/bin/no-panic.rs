//! An image that links only if no panic can be reached from what the bus, the
//! host or the client of the transparent port sends.
//!
//! It is never run. It holds the loops of [`armbridge_firmware::tasks`] with
//! everything below them (the tick and its master, the link with the design of
//! gains, the transparent port), the interrupt's side of the buffers, the stop
//! sequence, and all codecs. Bytes, times and readiness come from
//! [`black_box`], so that the optimiser must assume any value; state between
//! two calls passes through it too. The panic handler calls a function
//! that does not exist: if the optimiser leaves a single path to it, the linker
//! fails.
//!
//! `cargo verify --only no-panic` builds it, names the panics if there
//! are any, and checks that planted ones are found. Features:
//!
//! | feature            | image                                                |
//! |--------------------|------------------------------------------------------|
//! | `no-panic`         | as above                                             |
//! | `no-panic-locate`  | with a handler, so that it links and can be inspected |
//! | `no-panic-planted` | with a panic in each of the three loops              |
//!
//! The profile is that of the boards' images, in which sums wrap: that none
//! overflows is for the tests, which check it. Not in here are the drivers of a
//! board, the panics of its start (executors, clocks), which come before the first
//! byte, and what the storage library does with a flash that can be read.
#![no_std]
#![no_main]

use core::convert::Infallible;
use core::future::{Future, poll_fn};
use core::hint::black_box;
use core::panic::PanicInfo;
use core::pin::pin;
use core::task::{Context, Poll, Waker};

use armbridge_firmware::crash::memory;
use armbridge_firmware::crash::record::CrashRecord;
use armbridge_firmware::port::{Buffers, LineError};
use armbridge_firmware::stop::{self, PolledUart};
use armbridge_firmware::tasks::{
    self, FromClient, FromHost, LineChanges, RealTime, RealTimeLoop, Signals, ToHost,
};
use armbridge_shared::bridge::gateway::{ClientLine, PortEnd};
use armbridge_shared::bridge::{Bridge, BridgeEnd, Channels, LinkEnd, LinkPort};
use armbridge_shared::link::frame::{Decoder, Encoder, Message};
use armbridge_shared::link::message::{self, End, Stack, StopSource};
use armbridge_shared::lockstep::{TimeGrant, TimeRequest};
use armbridge_shared::servo::bus::{Bus, LineAfter, Received, Transmission};
use armbridge_shared::servo::port::SetBaud;
use armbridge_shared::servo::serial_bus::SerialBus;
use armbridge_shared::servo::{morpheus, protocol1};
use armbridge_shared::store::Store;
// Its critical section is what `Signals` needs.
use cortex_m as _;
use embedded_hal::digital::{ErrorType, OutputPin};
use embedded_hal_nb::serial::{self, ErrorKind};
use embedded_storage::nor_flash::{self, NorFlash, NorFlashErrorKind, ReadNorFlash};

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    unsafe extern "C" {
        /// Defined nowhere.
        safe fn a_panic_can_be_reached() -> !;
    }
    if cfg!(feature = "no-panic-locate") {
        loop {
            black_box(info);
        }
    }
    a_panic_can_be_reached()
}

/// An arbitrary value.
fn any<T: Default>() -> T {
    black_box(T::default())
}

/// Panics depending on an input, if the feature is enabled.
fn planted() {
    if cfg!(feature = "no-panic-planted") {
        black_box([0_u8; 4][any::<usize>()]);
    }
}

static BUS: Buffers = Buffers::new();
static SIGNALS: Signals = Signals::new();

/// A servo bus.
struct AnyBus([u8; 64]);

impl Bus for AnyBus {
    const RELEASES_BY_ITSELF: bool = true;

    fn set_baud(&mut self, baud: u32) {
        black_box(baud);
    }

    fn send(&mut self, bytes: &[u8], after: LineAfter) {
        black_box((bytes, after));
    }

    fn send_delay_us(&self) -> u32 {
        any()
    }

    fn transmission(&mut self) -> Transmission {
        black_box(Transmission::Waiting)
    }

    fn release(&mut self) {
        black_box(());
    }

    fn received(&mut self) -> Received<'_> {
        let bytes = black_box(&self.0);
        Received {
            bytes: bytes.get(..any()).unwrap_or(bytes),
            error: black_box(Some(ErrorKind::Noise)),
        }
    }
}

/// A serial port.
struct AnyPort;

impl serial::ErrorType for AnyPort {
    type Error = ErrorKind;
}

impl serial::Read<u8> for AnyPort {
    fn read(&mut self) -> nb::Result<u8, ErrorKind> {
        black_box(Err(nb::Error::WouldBlock))
    }
}

impl serial::Write<u8> for AnyPort {
    fn write(&mut self, byte: u8) -> nb::Result<(), ErrorKind> {
        black_box(byte);
        black_box(Err(nb::Error::WouldBlock))
    }

    fn flush(&mut self) -> nb::Result<(), ErrorKind> {
        black_box(Err(nb::Error::WouldBlock))
    }
}

impl SetBaud for AnyPort {
    fn set_baud(&mut self, baud: u32) {
        black_box(baud);
    }
}

/// Uses a bus made of a serial port and a pin.
fn serial_bus() {
    let mut bus = SerialBus::new(AnyPort, Direction);
    while any() {
        let bus = black_box(&mut bus);
        bus.send(black_box(&[0; 64]), LineAfter::Released);
        black_box(bus.transmission());
        black_box(bus.received());
    }
}

/// Direction pin of the bus.
struct Direction;

impl ErrorType for Direction {
    type Error = Infallible;
}

impl OutputPin for Direction {
    fn set_low(&mut self) -> Result<(), Infallible> {
        black_box(false);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        black_box(true);
        Ok(())
    }
}

/// A flash that fails. The compiler cannot follow the data flow of the storage library;
/// the fuzz target `store` checks that no content of a flash makes it panic.
struct Flash;

impl nor_flash::ErrorType for Flash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, _offset: u32, _bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        Err(NorFlashErrorKind::Other)
    }

    fn capacity(&self) -> usize {
        2 * Self::ERASE_SIZE
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = 1 << 17;

    fn erase(&mut self, _from: u32, _to: u32) -> Result<(), NorFlashErrorKind> {
        Err(NorFlashErrorKind::Other)
    }

    fn write(&mut self, _offset: u32, _bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        Err(NorFlashErrorKind::Other)
    }
}

/// Future that uses `input` at an arbitrary time and returns an arbitrary value. Not an
/// `async` block, which panics when it is polled after its end.
fn sometime<W, T: Default>(mut input: W) -> impl Future<Output = T> {
    poll_fn(move |_| {
        black_box(&mut input);
        planted();
        if any() {
            Poll::Ready(any())
        } else {
            Poll::Pending
        }
    })
}

/// Board, host and client.
struct Outside;

impl RealTime for Outside {
    fn now_us(&self) -> u64 {
        any()
    }

    fn start_stopwatch(&mut self) {
        black_box(());
    }

    fn stopwatch_ns(&self) -> u32 {
        any()
    }

    fn note_good_tick(&mut self) {
        black_box(());
    }

    fn stop_source(&mut self) -> Option<StopSource> {
        planted();
        any::<bool>().then_some(StopSource::Pin)
    }
}

impl FromHost for Outside {
    fn read(&mut self, buffer: &mut [u8]) -> impl Future<Output = usize> {
        sometime(buffer)
    }
}

impl ToHost for Outside {
    fn write(&mut self, bytes: &[u8]) -> impl Future<Output = usize> {
        sometime(bytes)
    }
}

impl FromClient for Outside {
    fn line(&self) -> ClientLine {
        any()
    }
}

impl LineChanges for Outside {
    fn changed(&mut self) -> impl Future<Output = ()> {
        sometime(())
    }
}

impl PolledUart for Outside {
    fn set_baud(&mut self, baud: u32) {
        black_box(baud);
    }

    fn drive(&mut self, on: bool) {
        black_box(on);
    }

    fn send(&mut self, byte: u8) {
        black_box(byte);
    }

    fn flush(&mut self) {
        black_box(());
    }

    fn pause_us(&mut self, us: u32) {
        black_box(us);
    }
}

/// Encodes and decodes messages of one direction.
fn messages<M: Message>() {
    let (mut decoder, mut encoder) = (Decoder::default(), Encoder::default());
    while any() {
        if let Some(Ok(received)) = black_box(&mut decoder).push::<M>(any()) {
            black_box(black_box(&mut encoder).encode(&received.message));
        }
    }
}

/// Encodes and decodes servo packets of both protocols.
fn packets() {
    use morpheus::frame as m;
    use protocol1::frame as p;
    let mut parsers = (
        m::Parser::<{ m::FRAME_MAX }>::new(),
        p::Parser::<{ p::FRAME_MAX }>::new(),
    );
    while any() {
        let (morpheus, protocol1) = black_box(&mut parsers);
        if let Some(Ok(frame)) = morpheus.push(any()) {
            black_box(frame.encode::<{ m::FRAME_MAX }>());
        }
        if let Some(Ok(frame)) = protocol1.push(any()) {
            black_box(frame.encode::<{ p::FRAME_MAX }>());
        }
    }
}

/// Lockstep messages of an emulated board and its bench.
fn grants() {
    black_box(TimeGrant::from_bytes(any()).to_bytes());
    black_box(TimeRequest::from_bytes(any()).to_bytes());
}

/// Accesses retained memory with arbitrary contents.
fn kept() {
    black_box(memory::begin(black_box(End::PowerUp)));
    memory::keep(any());
    black_box((memory::baud(), memory::is_kept(), memory::tick()));
    black_box(CrashRecord::from_words(&any()).map(CrashRecord::to_words));
}

/// Runs the functions of a UART's interrupt handlers.
fn interrupts() {
    while any() {
        let bus = black_box(&BUS);
        bus.received(any());
        bus.report_error(black_box(LineError::Noise));
        black_box((bus.next_to_send(), bus.take_error()));
    }
}

/// Polls `future` repeatedly, with arbitrary contents each time.
fn poll_repeatedly<T>(future: impl Future<Output = T>) {
    let mut future = pin!(future);
    let mut context = Context::from_waker(Waker::noop());
    while any() {
        let _ = black_box(&mut future).as_mut().poll(&mut context);
    }
}

// Each loop is a separate function, so that a panic in it can be distinguished from one
// in another.

#[inline(never)]
fn tick(end: BridgeEnd<'_>) {
    let watch = end.watch();
    if let Ok(mut bridge) = Bridge::new(AnyBus([0; 64]), end, any(), &any()) {
        let mut tick = RealTimeLoop::new(&mut bridge, watch, Outside, Direction, &SIGNALS);
        while any() {
            black_box(black_box(&mut tick).run());
        }
    }
}

#[inline(never)]
fn link(end: LinkEnd<'_>) {
    let mut port = LinkPort::new(end, any(), any());
    let watch = || {
        any::<bool>().then(|| Stack {
            used: any(),
            size: any(),
        })
    };
    poll_repeatedly(tasks::link(
        &mut port,
        Outside,
        Outside,
        &mut Store::new(Flash),
        watch,
        &SIGNALS,
    ));
}

#[inline(never)]
fn client(end: PortEnd<'_>) {
    poll_repeatedly(tasks::client(
        end,
        Outside,
        Outside,
        Outside,
        || (),
        &SIGNALS,
    ));
}

/// Entry at which the linker begins.
// SAFETY: the name is the one by which the linker finds an entry; nothing else in
// this image has it, and nothing runs it.
#[unsafe(no_mangle)]
extern "C" fn _start() {
    stop::send(&mut Outside, any());
    interrupts();
    serial_bus();
    packets();
    messages::<message::ToBoard>();
    messages::<message::ToHost>();
    grants();
    kept();
    let mut channels = Channels::new();
    let (tick_end, link_end, client_end) = black_box(&mut channels).split();
    tick(tick_end);
    link(link_end);
    client(client_end);
}
