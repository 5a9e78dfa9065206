//! Clocks and flags from registers as programs write them.

use super::*;

const READY: Time = Time::from_us(10_000);

const CRYSTAL: Crystal = Crystal {
    hz: 12_000_000,
    is_external: false,
};

/// The Feather's clocks, from 12 MHz.
fn at_full_speed(crystal: Option<Crystal>) -> Rcc {
    let mut rcc = Rcc::new(crystal);
    let pll = 7 << 24 | 1 << 22 | 168 << 6 | 6;
    for (us, offset, value) in [
        (10, 0x00, 0x83 | CR_HSEON),
        (5_000, 0x04, pll),
        (5_000, 0x00, 0x83 | CR_HSEON | CR_PLLON | CR_CSSON),
        (6_000, 0x08, 2 | 5 << 10 | 4 << 13),
    ] {
        assert_eq!(rcc.write(Time::from_us(us), offset, value), Some(()));
    }
    rcc
}

#[test]
fn clocks_follow_from_the_registers() {
    let rcc = at_full_speed(Some(CRYSTAL));
    let clocks = rcc.clocks();
    assert_eq!((clocks.core_hz, clocks.usb_hz), (168_000_000, 48_000_000));
    assert_eq!((clocks.apb1_hz, clocks.timer1_hz), (42_000_000, 84_000_000));
    assert_eq!(clocks.apb2_hz, 84_000_000);
    assert_eq!(rcc.read(READY, 0x08).map(|word| word >> 2 & 3), Some(2));
}

#[test]
fn without_a_crystal_the_chip_stays_on_its_own_oscillator() {
    let rcc = at_full_speed(None);
    assert_eq!(rcc.clocks().core_hz, HSI_HZ);
    assert_eq!(rcc.read(READY, 0).map(|word| word >> 17 & 1), Some(0));
    // Nor with a clock from outside, unless its oscillator is bypassed.
    let rcc = at_full_speed(Some(Crystal {
        is_external: true,
        ..CRYSTAL
    }));
    assert_eq!(rcc.clocks().core_hz, HSI_HZ);
}

#[test]
fn a_crystal_that_fails_is_reported_by_an_nmi() {
    let mut rcc = at_full_speed(Some(CRYSTAL));
    rcc.fail_crystal(READY);
    assert!(rcc.is_nmi() && rcc.clocks().core_hz == HSI_HZ);
    assert_eq!(rcc.write(READY, 0x0C, 1 << 23), Some(()));
    assert!(!rcc.is_nmi());
}

#[test]
fn flags_of_resets_stay_until_they_are_cleared() {
    let mut rcc = Rcc::new(None);
    assert_eq!(rcc.write(READY, 0x74, 1 << 24), Some(()));
    rcc.reset(READY, Reset::Watchdog);
    assert_eq!(rcc.read(READY, 0x74), Some(0x2400_0000));
    rcc.reset(READY, Reset::Pin);
    assert_eq!(rcc.read(READY, 0x74), Some(0x2400_0000));
}
