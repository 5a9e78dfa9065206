//! Adafruit Feather STM32F405 Express: STM32F405RG, 168 MHz Cortex-M4F.
//!
//! **Built, not run on hardware.** Section numbers are those of the STM32F405
//! reference manual, RM0090.
//!
//! | pin  | Feather | is                | wired to                               |
//! |------|---------|-------------------|----------------------------------------|
//! | PB10 | TX      | USART3 TX         | input of the buffer that drives DATA   |
//! | PB11 | RX      | USART3 RX         | output of the buffer that listens to DATA |
//! | PC6  | D6      | direction, high to send | enables of both buffers, 10 kΩ to ground |
//! | PB8  | D9      | emergency stop, pulled up | normally closed switch to ground |
//! | PC3  | D11     | servos' supply, high is on ([`supply`]) | driver of a relay, 10 kΩ to ground |
//! | PC1  | D13     | red LED           | on the board                           |
//! | PA11, PA12 | USB | link and port ([`usb`]) | on the board                      |
//!
//! The buffer is a 74HCT126 with an inverter or a 74HCT241 at 5 V: HC, as in the servo's manual,
//! asks for a higher level than a pin of 3.3 V gives. While the processor is in reset all its pins float: the resistor at
//! PC6 then keeps the line free.
//!
//! | priority | handler                                                   |
//! |----------|-----------------------------------------------------------|
//! | 0        | the bus (USART3): some 35 instructions, four times in a tick of 1 ms; a supply that sags (PVD), which ends the program |
//! | 1        | the tick (TIM5): three times in it                        |
//! | 3        | USB (`OTG_FS`); embassy's timer (TIM2), for the LED         |
//! | thread   | link, log over RTT, LED                                   |
//!
//! The bus is above the tick because a servo may speak 45 µs after the last stop bit, and
//! the tick computes for longer: the handler lowers the direction pin. Its bytes need no core,
//! DMA1 moves them by streams 1 and 3 ([`half_duplex`]). USB is below the tick because the length
//! of its handler depends on the host, and a packet that waits is held by the controller.
//!
//! [`half_duplex`]: crate::board::stm32::half_duplex
//!
//! # Settings
//!
//! Settings are stored in the last two sectors of the chip's flash; see [`flash`]. Boot
//! prepares them after the stop sequence and before the watchdog has its short period,
//! since erasing a sector takes 1 to 2 s.
//!
//! # Stop
//!
//! Every failure ends in the stop sequence on the bus, sent by polling: a
//! panic and a hard fault send it and reset; after any reset, the watchdog's
//! included, it is the first action of the program. [`crate::crash`] has the
//! times. The output for the servos' supply goes low before that; during a reset it floats,
//! which is off as well.
//!
//! The emergency stop is a switch between D9 and ground that is closed in normal
//! use: pressed, or with a wire broken or unplugged, it is open and the pin is
//! pulled up, by 30 to 50 kΩ in the chip (data sheet, section 5.3.16). It is polled
//! at least every [`time::STOP_LOOK_US`]. Without a switch: a wire from D9 to GND.
//!
//! # Watchdog
//!
//! The independent [watchdog](crate::board::stm32::watchdog) runs from the end of the
//! first stop sequence on, with a long period for the boot. Then it is fed by the tick alone, at the end of each
//! good tick and of each step of bring-up. It cannot be stopped; a program halted by a debugger is
//! reset by it. See [`WATCHDOG_US`](crate::crash::WATCHDOG_US).

pub mod bus;
pub mod crash;
pub mod flash;
pub mod supply;
pub mod time;
pub mod usb;

use embassy_stm32::Config;
use embassy_stm32::rcc::{
    AHBPrescaler, APBPrescaler, Hse, HseMode, Pll, PllMul, PllPDiv, PllPreDiv, PllQDiv, PllSource,
    Sysclk,
};
use embassy_stm32::time::Hertz;

/// Clock of the core in MHz, once [`config`] is in force.
pub const CORE_MHZ: u32 = 168;
/// Clock of APB1 and of USART3 on it, in MHz. Its timers run at twice that.
pub const PCLK1_MHZ: u32 = 42;

/// Clocks: the greatest the chip allows (section 7.2), 48 MHz for USB exactly. Without the
/// crystal they are as inaccurate as the internal oscillator, which feeds them then.
pub fn config(has_crystal: bool) -> Config {
    let mut config = Config::default();
    let rcc = &mut config.rcc;
    rcc.hse = has_crystal.then_some(Hse {
        freq: Hertz::mhz(12),
        mode: HseMode::Oscillator,
    });
    // 12 MHz / 6 = 16 MHz / 8 = 2 MHz, the input that section 7.3.2 recommends.
    let (source, divider) = if has_crystal {
        (PllSource::HSE, PllPreDiv::DIV6)
    } else {
        (PllSource::HSI, PllPreDiv::DIV8)
    };
    rcc.pll_src = source;
    rcc.pll = Some(Pll {
        prediv: divider,
        // 2 MHz * 168 = 336 MHz.
        mul: PllMul::MUL168,
        // 336 MHz / 2 = 168 MHz for the core.
        divp: Some(PllPDiv::DIV2),
        // 336 MHz / 7 = 48 MHz for USB.
        divq: Some(PllQDiv::DIV7),
        divr: None,
    });
    rcc.sys = Sysclk::PLL1_P;
    rcc.ahb_pre = AHBPrescaler::DIV1;
    // 42 MHz, the limit of APB1, on which USART3 is; 84 MHz, that of APB2.
    rcc.apb1_pre = APBPrescaler::DIV4;
    rcc.apb2_pre = APBPrescaler::DIV2;
    config
}
