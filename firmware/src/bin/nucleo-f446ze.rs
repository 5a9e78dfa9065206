//! Firmware for the Nucleo-F446ZE. See
//! [`armbridge_firmware::board::nucleo_f446ze`]. Built, not run on hardware.
#![no_std]
#![no_main]

#[cortex_m_rt::entry]
fn main() -> ! {
    armbridge_firmware::board::stm32::start::run()
}
