//! Clocks: the greatest that all chips of the family allow without over-drive, and 48 MHz for
//! USB exactly (section 7.2).
//!
//! | clock       | MHz | from                                              |
//! |-------------|-----|---------------------------------------------------|
//! | PLL's input | 2   | the crystal divided, as section 7.3.2 recommends  |
//! | PLL         | 336 | times 168                                         |
//! | core        | 168 | divided by 2                                      |
//! | USB         | 48  | divided by 7                                      |
//! | APB1        | 42  | core divided by 4, its limit; its timers have 84  |
//! | APB2        | 84  | core divided by 2, its limit                      |

use super::wiring::{Crystal, Wiring};
use embassy_stm32::Config;
use embassy_stm32::rcc::{
    AHBPrescaler, APBPrescaler, Hse, HseMode, Pll, PllMul, PllPDiv, PllPreDiv, PllQDiv, PllSource,
    Sysclk,
};
use embassy_stm32::time::Hertz;

/// Clock of the core in MHz, once [`config`] is in force.
pub const CORE_MHZ: u32 = 168;
/// Clock of APB1 in MHz.
pub const PCLK1_MHZ: u32 = 42;
/// Clock of APB2 in MHz.
pub const PCLK2_MHZ: u32 = 84;
/// The internal oscillator in MHz: the chip runs on it from a reset on.
pub const INTERNAL_MHZ: u32 = 16;

/// Clocks of a board. Without the crystal they are as inaccurate as the internal oscillator,
/// which feeds them then.
pub fn config<W: Wiring>(has_crystal: bool) -> Config {
    const { assert!(W::CRYSTAL_MHZ.is_multiple_of(2) && W::CRYSTAL_MHZ <= 26) };
    let mut config = Config::default();
    let rcc = &mut config.rcc;
    rcc.hse = has_crystal.then_some(Hse {
        freq: Hertz::mhz(W::CRYSTAL_MHZ),
        mode: match W::CRYSTAL {
            Crystal::Resonator => HseMode::Oscillator,
            Crystal::External => HseMode::Bypass,
        },
    });
    let (source, mhz) = if has_crystal {
        (PllSource::HSE, W::CRYSTAL_MHZ)
    } else {
        (PllSource::HSI, INTERNAL_MHZ)
    };
    rcc.pll_src = source;
    rcc.pll = Some(Pll {
        prediv: PllPreDiv::from_bits((mhz / 2) as u8),
        mul: PllMul::MUL168,
        divp: Some(PllPDiv::DIV2),
        divq: Some(PllQDiv::DIV7),
        divr: None,
    });
    rcc.sys = Sysclk::PLL1_P;
    rcc.ahb_pre = AHBPrescaler::DIV1;
    rcc.apb1_pre = APBPrescaler::DIV4;
    rcc.apb2_pre = APBPrescaler::DIV2;
    config
}
