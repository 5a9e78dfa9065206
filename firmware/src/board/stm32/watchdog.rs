//! The independent watchdog (reference manual, section 21): it counts on an oscillator of its
//! own, nominally 32 kHz and 17 to 47 kHz in fact, and nothing stops it once it is started.
//!
//! It runs from the end of the first stop sequence on: [`BOOT_US`] bounds the boot, which may wait for a
//! crystal and erase two sectors of flash; the bridge then has
//! [`WATCHDOG_US`](crate::crash::WATCHDOG_US).

use embassy_stm32::pac::IWDG;
use embassy_stm32::pac::iwdg::vals::{Key, Pr};

/// Nominal frequency in Hz.
const LSI_HZ: u64 = 32_000;
/// Largest reload value, of 12 bits.
const RELOAD_MAX: u64 = 0xFFF;
/// Period for the boot in µs: the longest there is, 22 s at 47 kHz. Erasing two sectors takes
/// 4 s at most (data sheet, flash memory programming).
pub const BOOT_US: u32 = 32_000_000;

/// Starts the watchdog, or changes its period, and feeds it.
pub fn start(period_us: u32) {
    // Rounded up: it must outlast the longest tick.
    let counts = (u64::from(period_us) * LSI_HZ).div_ceil(1_000_000);
    // Divided by 4, 8, .. 256: by the least at which the counts fit.
    let shift = (0..6).find(|shift| counts.div_ceil(4 << shift) <= RELOAD_MAX);
    let shift = shift.unwrap_or(6);
    // It counts from the reload value to 0.
    let reload = (counts.div_ceil(4 << shift))
        .saturating_sub(1)
        .min(RELOAD_MAX);
    IWDG.kr().write(|w| w.set_key(Key::ENABLE));
    IWDG.pr().write(|w| w.set_pr(Pr::from_bits(shift)));
    IWDG.rlr().write(|w| w.set_rl(reload as u16));
    IWDG.kr().write(|w| w.set_key(Key::START));
    feed();
}

/// Feeds it, for one more period; without effect if it is not running.
pub fn feed() {
    IWDG.kr().write(|w| w.set_key(Key::RESET));
}
