//! The boards' own images, unmodified, executed instruction by instruction on emulated
//! chips: from reset through USB enumeration to an arm that is held, and into each
//! failure. No hardware: what the chip's blocks do is what their manual says.

/// Makes a test of each of these functions on each board, `FUNCTION::BOARD`.
macro_rules! on_each_board {
    ($($function:ident,)*) => { $(
        mod $function {
            #[test]
            #[ignore = "needs the firmware image: run `cargo verify`"]
            fn feather() {
                super::$function(super::super::FEATHER);
            }

            #[test]
            #[ignore = "needs the firmware image: run `cargo verify`"]
            fn nucleo() {
                super::$function(super::super::NUCLEO);
            }
        }
    )* };
}

mod boot;
mod drive;
mod faults;
mod robustness;
mod served;
mod setup;
mod usb;

use armbridge_client::Host;
use armbridge_sim::Bench;
use armbridge_sim::plant::Plant;
use armbridge_stm32_emulator::chip::Board;
use armbridge_stm32_emulator::time::Time;
use armbridge_stm32_emulator::usb_host::State;
use armbridge_tests::board_image::{BoardRun, image};
use armbridge_tests::plant;

/// Length of a large sector of flash.
const SECTOR: usize = 128 * 1_024;
/// Time in which the board is on USB after a reset, in ms.
const ON_USB_MS: u64 = 150;

/// A board under test.
#[derive(Clone, Copy, Debug)]
struct TestBoard {
    /// Name of its image.
    image: &'static str,
    wiring: Board,
}

const FEATHER: TestBoard = TestBoard {
    image: "feather-f405",
    wiring: Board::FEATHER_F405,
};
const NUCLEO: TestBoard = TestBoard {
    image: "nucleo-f446ze",
    wiring: Board::NUCLEO_F446ZE,
};

impl TestBoard {
    /// It with Morpheus servos, an arm near upright and this host, its power still off.
    fn with<H: Host>(self, host: H) -> BoardRun<H>
    where
        H::Error: std::fmt::Debug,
    {
        let bench = Bench::new(Plant::new(plant([0.02, -0.02], true), 1));
        self.on(bench, host)
    }

    /// It on this bench.
    fn on<H: Host>(self, bench: Bench, host: H) -> BoardRun<H>
    where
        H::Error: std::fmt::Debug,
    {
        BoardRun::new(self.wiring, &image(self.image), bench, host)
    }
}

/// The two sectors of flash for settings.
fn settings_sectors<H>(run: &mut BoardRun<H>) -> [&mut [u8]; 2] {
    let flash = run.machine.system.flash.bytes_mut();
    let (_, settings) = flash.split_at_mut(flash.len() - 2 * SECTOR);
    settings.split_at_mut(SECTOR).into()
}

/// Executes until the host has configured the board.
fn until_configured<H: Host>(run: &mut BoardRun<H>, within_ms: u64)
where
    H::Error: std::fmt::Debug,
{
    let latest_ms = run.machine.now().as_us() / 1_000 + within_ms;
    let is_configured = run.run_until(latest_ms, |run| {
        run.machine.system.usb.state() == State::Configured
    });
    let changes = run.machine.system.usb.changes();
    assert!(is_configured, "{changes:?}");
}

/// `us` microseconds.
const fn us(us: u64) -> Time {
    Time::from_us(us)
}
