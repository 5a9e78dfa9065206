//! Firmware for the Adafruit Feather STM32F405 Express. See
//! [`armbridge_firmware::board::feather_f405`]. Built, not run on hardware.
#![no_std]
#![no_main]

#[cortex_m_rt::entry]
fn main() -> ! {
    armbridge_firmware::board::stm32::start::run()
}
