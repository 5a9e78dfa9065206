//! Firmware for the Adafruit Feather STM32F405 Express. See
//! [`armbridge_firmware::board`] for pins, priorities, stop and watchdog.
//! Built, not run on hardware.
#![no_std]
#![no_main]

use armbridge_firmware::board::feather_f405::bus::{BusLine, Direction};
use armbridge_firmware::board::feather_f405::end::reset_cause;
use armbridge_firmware::board::feather_f405::flash::Sectors;
use armbridge_firmware::board::feather_f405::time::{self, Board};
use armbridge_firmware::board::feather_f405::usb::{
    Changes, FromSerial, FromUsb, Ports, ToSerial, ToUsb,
};
use armbridge_firmware::board::feather_f405::{bus, config, usb};
use armbridge_firmware::end::{self, WATCHDOG_US, memory};
use armbridge_firmware::image;
use armbridge_firmware::port::Port;
use armbridge_firmware::run::{self, News};
use armbridge_firmware::settings;
use armbridge_firmware::stack;
use armbridge_shared::bridge::gateway::PortEnd;
use armbridge_shared::bridge::{Bridge, BridgeEnd, Channels, LinkPort};
use armbridge_shared::link::message::{BoardReport, Mode, Settings};
use armbridge_shared::store::Store;
use defmt_rtt as _;
use embassy_executor::{Executor, InterruptExecutor};
use embassy_futures::select::{Either, select};
use embassy_stm32::gpio::{Input, Level, Output, Pull, Speed};
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_stm32::peripherals::USB_OTG_FS;
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_time::Timer;
use embassy_usb::UsbDevice;
use static_cell::StaticCell;

static CHANNELS: StaticCell<Channels> = StaticCell::new();
static TICK: InterruptExecutor = InterruptExecutor::new();
static THREAD: StaticCell<Executor> = StaticCell::new();
static NEWS: News = News::new();

defmt::timestamp!("{=u64:us}", time::now_us());

#[cortex_m_rt::entry]
fn main() -> ! {
    end::stop_first();
    stack::paint();
    let report = memory::begin(reset_cause());

    let chip = embassy_stm32::init(config());
    if let Some(mut core) = cortex_m::Peripherals::take() {
        core.DCB.enable_trace();
        core.DWT.enable_cycle_counter();
    }
    defmt::info!("feather-f405, version {=str}", env!("CARGO_PKG_VERSION"));
    memory::log(&report);
    let mut store = Store::new(Sectors::new(chip.FLASH));
    let (settings, from) = settings::open(&mut store);
    let report = BoardReport {
        settings: from,
        image: Some(image::measure()),
        ..report
    };

    bus::enable();
    interrupt::USART3.set_priority(Priority::P0);
    interrupt::UART5.set_priority(Priority::P1);
    interrupt::OTG_FS.set_priority(Priority::P3);
    // SAFETY: its handler is in place, and no critical section that masks less
    // than all interrupts is in use.
    unsafe { interrupt::USART3.enable() };

    let mut watchdog = IndependentWatchdog::new(chip.IWDG, WATCHDOG_US);
    watchdog.unleash();
    let (bridge, link, client) = CHANNELS.init(Channels::new()).split();
    // Each of the tasks is spawned once, so there is always room for it.
    let spawner = TICK.start(interrupt::UART5);
    let board = Board::new(watchdog, Input::new(chip.PB8, Pull::Up));
    spawner.spawn(tick(bridge, board, settings).expect("spawned once"));

    let Ports {
        device,
        from_host,
        to_host,
        from_client,
        to_client,
        changes,
    } = usb::start(chip.USB_OTG_FS, chip.PA12, chip.PA11);
    let light = Output::new(chip.PC1, Level::Low, Speed::Low);
    THREAD.init(Executor::new()).run(|thread| {
        thread.spawn(run_usb(device).expect("spawned once"));
        thread.spawn(
            talk(
                LinkPort::new(link, report, settings),
                from_host,
                to_host,
                store,
            )
            .expect("spawned once"),
        );
        thread.spawn(pass(client, from_client, to_client, changes).expect("spawned once"));
        thread.spawn(show_mode(light).expect("spawned once"));
    })
}

#[embassy_stm32::interrupt]
fn UART5() {
    // SAFETY: this is the executor's interrupt handler, and the interrupt is
    // only let through by `TICK.start`.
    unsafe { TICK.on_interrupt() };
}

#[embassy_executor::task]
async fn tick(end: BridgeEnd<'static>, board: Board, settings: Settings) -> ! {
    let Ok(bridge) = Bridge::new(Port(BusLine), Direction, end, time::now_us(), &settings) else {
        // Saved settings have been tried before, and the defaults are a constant:
        // every test of the bench builds the same.
        panic!("the settings have no controller");
    };
    run::real_time(bridge, board, &NEWS).await
}

#[embassy_executor::task]
async fn run_usb(mut device: UsbDevice<'static, embassy_stm32::usb::Driver<'static, USB_OTG_FS>>) {
    device.run().await;
}

#[embassy_executor::task]
async fn talk(
    port: LinkPort<'static>,
    from_host: FromUsb,
    to_host: ToUsb,
    store: Store<Sectors>,
) -> ! {
    let mut watch = stack::Watch::default();
    let watch = || watch.look(time::now_us(), stack::measure);
    run::link(port, from_host, to_host, watch, store, &NEWS).await
}

#[embassy_executor::task]
async fn pass(
    client: PortEnd<'static>,
    from_client: FromSerial,
    to_client: ToSerial,
    changes: Changes,
) -> ! {
    let wake = || bus::ACTIVITY.signal(());
    run::client(client, from_client, to_client, changes, wake, &NEWS).await
}

/// Logs the mode and shows it: quick while searching, slow when idle or when the
/// bus is somebody else's, steady with torque on, in between after a fault.
#[embassy_executor::task]
async fn show_mode(mut light: Output<'static>) -> ! {
    let mut mode = Mode::Boot;
    loop {
        let half_period_ms = match mode {
            Mode::Boot => 50,
            Mode::Fault(_) => 150,
            Mode::Idle | Mode::Passthrough | Mode::Armed | Mode::Running(_) | Mode::Degraded(_) => {
                500
            }
        };
        if mode.is_armed() {
            light.set_high();
        } else {
            light.toggle();
        }
        match select(NEWS.mode.wait(), Timer::after_millis(half_period_ms)).await {
            Either::First(new) => {
                mode = new;
                defmt::info!("mode: {}", mode);
            }
            Either::Second(()) => {}
        }
    }
}
