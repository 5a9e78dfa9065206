//! Chips and boards: what the emulator has to know of either.

use crate::peripherals::gpio::Pin;
use crate::peripherals::rcc::Crystal;

/// A chip.
#[derive(Clone, Copy, Debug)]
pub struct Chip {
    /// Bytes of flash.
    pub flash: usize,
    /// Bytes of SRAM from `0x2000_0000`.
    pub sram: usize,
    /// Bytes of core-coupled memory from `0x1000_0000`.
    pub ccm: usize,
    /// Number of interrupts.
    pub interrupts: u16,
    /// Identifier of the device (`DBGMCU_IDCODE`).
    pub id_code: u32,
    /// Identifier of the USB core (register CID).
    pub otg_id: u32,
}

impl Chip {
    /// STM32F405RG.
    pub const F405: Self = Self {
        flash: 1_024 * 1_024,
        sram: 128 * 1_024,
        ccm: 64 * 1_024,
        interrupts: 82,
        id_code: 0x1007_6413,
        otg_id: 0x1200,
    };

    /// STM32F446ZE (RM0390).
    pub const F446: Self = Self {
        flash: 512 * 1_024,
        sram: 128 * 1_024,
        ccm: 0,
        interrupts: 97,
        id_code: 0x1000_6421,
        otg_id: 0x2000,
    };
}

/// The USART that drives the bus, by its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Port(pub usize);

/// Wiring of a board.
#[derive(Clone, Copy, Debug)]
pub struct Board {
    /// Its chip.
    pub chip: Chip,
    /// Its crystal.
    pub crystal: Crystal,
    /// The servo bus.
    pub bus: Port,
    /// Enables of the bus's buffers, high to send.
    pub direction: Pin,
    /// Input of the emergency stop: closed to ground in normal use.
    pub stop: Pin,
    /// Output for the relay of the servos' supply.
    pub supply: Pin,
}

impl Board {
    /// Adafruit Feather STM32F405 Express, wired as the firmware's module says.
    pub const FEATHER_F405: Self = Self {
        chip: Chip::F405,
        crystal: Crystal {
            hz: 12_000_000,
            is_external: false,
        },
        bus: Port(3),
        direction: Pin::new('C', 2),
        stop: Pin::new('B', 8),
        supply: Pin::new('C', 3),
    };

    /// Nucleo-F446ZE, wired as the firmware's module says.
    pub const NUCLEO_F446ZE: Self = Self {
        chip: Chip::F446,
        crystal: Crystal {
            hz: 8_000_000,
            is_external: true,
        },
        bus: Port(6),
        direction: Pin::new('F', 15),
        stop: Pin::new('D', 15),
        supply: Pin::new('A', 7),
    };
}
