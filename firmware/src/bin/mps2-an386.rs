//! Firmware for QEMU's `mps2-an386`. See [`armbridge_firmware::board`] for the
//! machine and how to run it.
#![no_std]
#![no_main]

use armbridge_board::bridge::transparent_port::PortEnd;
use armbridge_board::bridge::{Bridge, BridgeEnd, Channels, LinkPort};
use armbridge_board::store::Store;
use armbridge_firmware::board::mps2_an386::bus::BusLine;
use armbridge_firmware::board::mps2_an386::crash::reset_cause;
use armbridge_firmware::board::mps2_an386::flash::{self, Flash};
use armbridge_firmware::board::mps2_an386::interrupt::{self, Irq, REST};
use armbridge_firmware::board::mps2_an386::link::{NoChanges, Stream};
use armbridge_firmware::board::mps2_an386::real_time::{self, Board};
use armbridge_firmware::board::mps2_an386::semihosting::Arguments;
use armbridge_firmware::board::mps2_an386::supply::SupplyPin;
use armbridge_firmware::board::mps2_an386::{
    BUS, CLIENT, LINK, clock, fault_injection, lockstep, watchdog,
};
use armbridge_firmware::crash::{self, memory};
use armbridge_firmware::tasks::{self, RealTimeLoop, Signals};
use armbridge_firmware::{image_crc, settings, stack, stack_guard};
use armbridge_link::message::{BoardReport, Settings};
use static_cell::{ConstStaticCell, StaticCell};

static CHANNELS: ConstStaticCell<Channels> = ConstStaticCell::new(Channels::new());
static BRIDGE: StaticCell<BoardBridge> = StaticCell::new();
static PORT: StaticCell<LinkPort<'static>> = StaticCell::new();
static STORE: StaticCell<Store<Flash>> = StaticCell::new();
static SIGNALS: Signals = Signals::new();

/// The bridge on this board's bus.
type BoardBridge = Bridge<'static, BusLine>;

defmt::timestamp!("{=u64:us}", clock::now_us());

#[cortex_m_rt::entry]
fn main() -> ! {
    let arguments = Arguments::get();
    let in_lockstep = arguments.has("lockstep");
    clock::start(in_lockstep, arguments.number("slow=").unwrap_or(1));
    if !in_lockstep {
        crash::stop_first();
    }
    stack::paint();
    start(&arguments);
    loop {
        cortex_m::asm::wfi();
    }
}

/// Starts all tasks, after the stop sequence and before the executors run. Not inlined:
/// the frame of an inlined function is on the stack as long as the program runs.
///
/// # Panics
/// Never: `main` calls it once, so that each cell is still full or empty as it must be
/// and each task has its place. It takes nothing from bus or link, and motors are off;
/// `bin/no-panic` shows that nothing from outside leads to a panic later.
/// On a panic the handler stops the motors and resets.
#[inline(never)]
fn start(arguments: &Arguments) {
    let in_lockstep = clock::is_lockstep();
    let report = memory::begin(reset_cause());
    fault_injection::prepare(arguments, report.last_end.cause);
    for uart in [&LINK, &BUS, &CLIENT] {
        uart.enable();
    }
    if let Some(mut core) = cortex_m::Peripherals::take() {
        // From 0x1000_0000, where the RAM of code begins on this board but nothing is used.
        stack_guard::enable::<28>(&mut core.MPU);
        interrupt::enable(&mut core.NVIC);
    }
    defmt::info!(
        "mps2-an386, version {=str}, time is {=str}",
        env!("CARGO_PKG_VERSION"),
        if in_lockstep { "granted" } else { "real" }
    );
    memory::log(&report);
    let store = STORE.init(Store::new(flash::take().expect("taken once")));
    let (settings, from) = settings::open(store);
    let report = BoardReport {
        settings: from,
        image: Some(image_crc::compute()),
        ..report
    };
    if !in_lockstep {
        watchdog::start();
    }

    let (tick_end, link_end, client_end) = CHANNELS.take().split();
    let watch = tick_end.watch();
    let bridge = build(tick_end, &settings);
    // The tick first: it must be waiting when lockstep begins.
    let supply = SupplyPin::take();
    real_time::start_tick(RealTimeLoop::new(bridge, watch, Board, supply, &SIGNALS));
    let spawner = REST.start(Irq::Rest);
    spawner.spawn(log_mode().expect("spawned once"));
    let port = PORT.init_with(|| LinkPort::new(link_end, report, settings));
    if in_lockstep {
        spawner.spawn(run_lockstep(port, client_end, store).expect("spawned once"));
    } else {
        spawner.spawn(serve_link(port, store).expect("spawned once"));
        spawner.spawn(serve_client(client_end).expect("spawned once"));
    }
}

/// Builds the bridge in its static cell. Not inlined: a copy is on the stack until it
/// is moved.
///
/// # Panics
/// Never: `settings::open` has built a controller for saved settings, and every test of
/// the bench builds the one for the defaults. Called once, by [`start`].
#[inline(never)]
fn build(end: BridgeEnd<'static>, settings: &Settings) -> &'static mut BoardBridge {
    BRIDGE.init_with(|| {
        let bridge = Bridge::new(BusLine::default(), end, clock::now_us(), settings);
        bridge.unwrap_or_else(|_| panic!("the settings have no controller"))
    })
}

#[embassy_executor::task]
async fn serve_link(port: &'static mut LinkPort<'static>, store: &'static mut Store<Flash>) -> ! {
    let mut watch = stack::Watch::default();
    let watch = || watch.sample(clock::now_us(), stack::measure);
    tasks::link(port, Stream(&LINK), Stream(&LINK), store, watch, &SIGNALS).await
}

#[embassy_executor::task]
async fn serve_client(client: PortEnd<'static>) -> ! {
    let stream = Stream(&CLIENT);
    tasks::client(client, stream, stream, NoChanges, real_time::wake, &SIGNALS).await
}

#[embassy_executor::task]
async fn run_lockstep(
    port: &'static mut LinkPort<'static>,
    client: PortEnd<'static>,
    store: &'static mut Store<Flash>,
) -> ! {
    lockstep::run(port, client, store).await
}

#[embassy_executor::task]
async fn log_mode() -> ! {
    loop {
        defmt::info!("mode: {}", SIGNALS.mode.wait().await);
    }
}
