//! Chips and boards: what the emulator has to know of either.

use crate::peripherals::gpio::Pin;

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
}

/// The USART that drives the bus, by its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Port(pub usize);

/// How a board is wired.
#[derive(Clone, Copy, Debug)]
pub struct Board {
    /// Its chip.
    pub chip: Chip,
    /// Its crystal in Hz.
    pub crystal_hz: u32,
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
        crystal_hz: 12_000_000,
        bus: Port(3),
        direction: Pin::new('C', 6),
        stop: Pin::new('B', 8),
        supply: Pin::new('C', 3),
    };
}
