//! The Feather's own image, unmodified, executed instruction by instruction on an emulated
//! STM32F405: from reset through USB enumeration to an arm that is held, and into each
//! failure. No hardware: what the chip's blocks do is what their manual says.

mod boot;
mod drive;
mod faults;
mod robustness;
mod usb;

use armbridge_client::Host;
use armbridge_sim::Bench;
use armbridge_sim::plant::Plant;
use armbridge_stm32_emulator::chip::Board;
use armbridge_stm32_emulator::time::Time;
use armbridge_stm32_emulator::usb_host::State;
use armbridge_tests::board_image::{BoardRun, image};
use armbridge_tests::plant;

/// Time in which the board is on USB after a reset, in ms.
const ON_USB_MS: u64 = 150;

/// The Feather with Morpheus servos and an arm near upright, its power still off.
fn feather<H: Host>(host: H) -> BoardRun<H>
where
    H::Error: std::fmt::Debug,
{
    let bench = Bench::new(Plant::new(plant([0.02, -0.02], true), 1));
    BoardRun::new(Board::FEATHER_F405, &image("feather-f405"), bench, host)
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
