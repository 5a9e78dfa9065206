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

mod outside;

use core::future::Future;
use core::hint::black_box;
use core::panic::PanicInfo;
use core::pin::pin;
use core::task::{Context, Waker};

use armbridge_board::bridge::transparent_port::PortEnd;
use armbridge_board::bridge::{Bridge, BridgeEnd, Channels, LinkEnd, LinkPort};
use armbridge_board::lockstep::{TimeGrant, TimeRequest};
use armbridge_board::store::Store;
use armbridge_firmware::crash::memory;
use armbridge_firmware::crash::record::CrashRecord;
use armbridge_firmware::port::{Buffers, LineError};
use armbridge_firmware::stop;
use armbridge_firmware::tasks::{self, RealTimeLoop, Signals};
use armbridge_link::frame::{Decoder, Encoder, Message};
use armbridge_link::message::{self, End, Stack};
use armbridge_servo::bus::{Bus, LineAfter};
use armbridge_servo::serial_bus::SerialBus;
use armbridge_servo::{morpheus, protocol1};
// Its critical section is what `Signals` needs.
use cortex_m as _;
use outside::{AnyBus, AnyPort, Direction, Flash, Outside};

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
#[expect(clippy::inline_always, reason = "each loop has a call of its own")]
#[inline(always)]
fn planted() {
    if cfg!(feature = "no-panic-planted") {
        black_box([0_u8; 4][any::<usize>()]);
    }
}

static BUS: Buffers = Buffers::new();
static SIGNALS: Signals = Signals::new();

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
