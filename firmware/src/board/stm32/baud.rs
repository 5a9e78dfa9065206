//! Baud rate of a USART.

use armbridge_servo::port::BAUD_RATES;
use embassy_stm32::pac::usart::Usart;
use embassy_stm32::pac::usart::vals::Over8;

/// Fastest rate of [`BAUD_RATES`] that a clock makes within 1.5 %, and all below it: 3 M at 42 MHz,
/// 4 M at 84 MHz.
pub const fn baud_max(clock_mhz: u32) -> u32 {
    let (mut fastest, mut index) = (0, 0);
    while index < BAUD_RATES.len() {
        let baud = BAUD_RATES[index];
        let made = clock_mhz * 1_000_000 / divider(clock_mhz, baud);
        if made.abs_diff(baud) * 200 > baud * 3 {
            break;
        }
        if baud > fastest {
            fastest = baud;
        }
        index += 1;
    }
    fastest
}

/// Clocks of a bit, to the nearest; not less than one for each of 8 samples.
const fn divider(clock_mhz: u32, baud: u32) -> u32 {
    let divider = (clock_mhz * 1_000_000 + baud / 2) / baud;
    if divider < 8 { 8 } else { divider }
}

/// Sets the divider for this clock (section 30.3.4): clock over baud rate, with 16 samples a
/// bit, or 8 where the clock is too slow for 16, as for 2 Mbaud at 16 MHz. That needs
/// the USART to be off.
pub fn set_divider(usart: Usart, clock_mhz: u32, baud: u32) {
    let divider = divider(clock_mhz, baud.max(1));
    // The least is one clock a sample, the largest that of the register.
    let value = if divider < 16 {
        // With 8 samples the fraction has three bits, and the fourth is 0.
        (divider & !7) << 1 | divider & 7
    } else {
        divider.min(0xFFFF)
    };
    let over8 = if divider < 16 {
        Over8::OVERSAMPLING8
    } else {
        Over8::OVERSAMPLING16
    };
    if usart.cr1().read().over8() != over8 {
        usart.cr1().modify(|w| {
            w.set_ue(false);
        });
        usart.cr1().modify(|w| w.set_over8(over8));
        usart.cr1().modify(|w| w.set_ue(true));
    }
    usart.brr().write(|w| w.0 = value);
}
