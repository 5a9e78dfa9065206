//! Baud rate of a USART.

use embassy_stm32::pac::usart::Usart;
use embassy_stm32::pac::usart::vals::Over8;

/// Sets the divider for this clock (section 30.3.4): clock over baud rate, with 16 samples a
/// bit, or 8 where the clock is too slow for 16, as for 2 Mbaud at 16 MHz. That needs
/// the USART to be off.
pub fn set_divider(usart: Usart, clock_mhz: u32, baud: u32) {
    let baud = baud.max(1);
    let divider = (clock_mhz * 1_000_000 + baud / 2) / baud;
    // The least is one clock a sample, the largest that of the register.
    let value = if divider < 16 {
        let divider = divider.max(8);
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
