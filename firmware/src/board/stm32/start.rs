//! The program of a board with an STM32F4: stop sequence, clocks, settings, bus, tick, USB.

use super::crash::reset_cause;
use super::flash::{self, Sectors};
use super::time::{self, Board};
use super::usb::{Changes, FromSerial, FromUsb, Ports, ToSerial, ToUsb};
use super::wiring::Wiring;
use super::{bus, clock_tree, oscillator, usb, voltage_detector, watchdog};
use crate::board::Chosen;
use crate::crash::{self, WATCHDOG_US, memory};
use crate::tasks::{self, RealTimeLoop, Signals};
use crate::{image_crc, settings, stack, stack_guard};
use armbridge_board::bridge::transparent_port::PortEnd;
use armbridge_board::bridge::{Bridge, BridgeEnd, Channels, LinkPort};
use armbridge_board::store::Store;
use armbridge_link::message::{BoardReport, Mode, Settings};
use defmt_rtt as _;
use embassy_executor::{Executor, Spawner};
use embassy_futures::select::{Either, select};
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_time::Timer;
use embassy_usb::UsbDevice;
use static_cell::{ConstStaticCell, StaticCell};

static CHANNELS: ConstStaticCell<Channels> = ConstStaticCell::new(Channels::new());
static BRIDGE: StaticCell<BoardBridge> = StaticCell::new();
static PORT: StaticCell<LinkPort<'static>> = StaticCell::new();
static STORE: StaticCell<Store<Sectors>> = StaticCell::new();
static THREAD: StaticCell<Executor> = StaticCell::new();
static SIGNALS: Signals = Signals::new();

/// The bridge on this board's bus.
type BoardBridge = Bridge<'static, bus::Line>;

defmt::timestamp!("{=u64:us}", time::now_us());

/// Runs the program; call it first after reset.
pub fn run() -> ! {
    crash::stop_first();
    stack::paint();
    THREAD.init(Executor::new()).run(start)
}

/// Starts all tasks, after the stop sequence and before the executors run. Not inlined:
/// the frame of an inlined function is on the stack as long as the program runs.
///
/// # Panics
/// Never: [`run`] calls it once, so that each cell is still full or empty as it must be
/// and each task has its place. It takes nothing from bus or link, and motors are off;
/// `bin/no-panic` shows that nothing from outside leads to a panic later, but for the asserts
/// of the USB driver ([`usb`]).
/// On a panic the handler stops the motors and resets.
#[inline(never)]
fn start(thread: Spawner) {
    let report = memory::begin(reset_cause());

    watchdog::start(watchdog::BOOT_US);
    let has_crystal = oscillator::start(Chosen::CRYSTAL);
    let chip = embassy_stm32::init(clock_tree::config::<Chosen>(has_crystal));
    flash::accelerate();
    voltage_detector::enable();
    if has_crystal {
        oscillator::watch();
    }
    time::start();
    if let Some(mut core) = cortex_m::Peripherals::take() {
        // Below RAM are the ROM loader and the option bytes, and 32 kB that nothing reads.
        stack_guard::enable::<15>(&mut core.MPU);
        core.DCB.enable_trace();
        core.DWT.enable_cycle_counter();
    }
    defmt::info!(
        "{=str}, version {=str}",
        Chosen::NAME,
        env!("CARGO_PKG_VERSION")
    );
    memory::log(&report);
    if !has_crystal {
        defmt::error!("the crystal does not oscillate: no motor is driven");
    }
    let store = STORE.init(Store::new(Sectors::new(chip.FLASH)));
    let (settings, from) = settings::open(store);
    let report = BoardReport {
        settings: from,
        image: Some(image_crc::compute()),
        ..report
    };

    let bus = bus::start();
    // Embassy's timer, for tasks in thread mode only.
    interrupt::TIM2.set_priority(Priority::P3);
    interrupt::OTG_FS.set_priority(Priority::P3);

    watchdog::start(WATCHDOG_US);
    let (tick_end, link_end, client_end) = CHANNELS.take().split();
    let board = Board::new(has_crystal);
    let watch = tick_end.watch();
    let bridge = build(bus, tick_end, &settings);
    let supply = Chosen::SUPPLY;
    supply.make_output(false);
    time::start_tick(RealTimeLoop::new(bridge, watch, board, supply, &SIGNALS));

    let Ports {
        device,
        from_host,
        to_host,
        from_client,
        to_client,
        changes,
    } = usb::start(chip.USB_OTG_FS, chip.PA12, chip.PA11);
    Chosen::LIGHT.make_output(false);
    let port = PORT.init_with(|| LinkPort::new(link_end, report, settings));
    thread.spawn(run_usb(device).expect("spawned once"));
    thread.spawn(serve_link(port, from_host, to_host, store).expect("spawned once"));
    thread.spawn(serve_client(client_end, from_client, to_client, changes).expect("spawned once"));
    thread.spawn(show_mode().expect("spawned once"));
}

/// Builds the bridge in its static cell. Not inlined: a copy is on the stack until it
/// is moved.
///
/// # Panics
/// Never: `settings::open` has built a controller for saved settings, and every test of
/// the bench builds the one for the defaults. Called once, by [`start`].
#[inline(never)]
fn build(bus: bus::Line, end: BridgeEnd<'static>, settings: &Settings) -> &'static mut BoardBridge {
    BRIDGE.init_with(|| {
        let bridge = Bridge::new(bus, end, time::now_us(), settings);
        bridge.unwrap_or_else(|_| panic!("the settings have no controller"))
    })
}

#[embassy_executor::task]
async fn run_usb(device: UsbDevice<'static, usb::Otg>) -> ! {
    usb::run(device).await
}

#[embassy_executor::task]
async fn serve_link(
    port: &'static mut LinkPort<'static>,
    from_host: FromUsb,
    to_host: ToUsb,
    store: &'static mut Store<Sectors>,
) -> ! {
    let mut watch = stack::Watch::default();
    let watch = || watch.sample(time::now_us(), stack::measure);
    tasks::link(port, from_host, to_host, store, watch, &SIGNALS).await
}

#[embassy_executor::task]
async fn serve_client(
    client: PortEnd<'static>,
    from_client: FromSerial,
    to_client: ToSerial,
    changes: Changes,
) -> ! {
    tasks::client(
        client,
        from_client,
        to_client,
        changes,
        time::wake,
        &SIGNALS,
    )
    .await
}

/// Logs the mode and shows it by a light: it blinks fast during the search, slowly when
/// idle or when the bus is lent, in between after a fault; it is steady with torque on.
#[embassy_executor::task]
async fn show_mode() -> ! {
    let mut mode = Mode::Boot;
    let mut is_lit = false;
    loop {
        let half_period_ms = match mode {
            Mode::Boot => 50,
            Mode::Fault(_) => 150,
            Mode::Idle
            | Mode::Passthrough
            | Mode::MotorCheck
            | Mode::Armed
            | Mode::Running(_)
            | Mode::Degraded(_) => 500,
        };
        is_lit = mode.is_armed() || !is_lit;
        Chosen::LIGHT.set(is_lit);
        match select(SIGNALS.mode.wait(), Timer::after_millis(half_period_ms)).await {
            Either::First(new) => {
                mode = new;
                defmt::info!("mode: {}", mode);
            }
            Either::Second(()) => {}
        }
    }
}
