//! Addresses (section 2.3), clock gates (section 7.3), interrupts (table 62) and DMA
//! requests (tables 42 and 43).

use crate::peripherals::gpio::Pin;
use crate::peripherals::rcc::Gate;

/// A block of registers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Block {
    /// TIM2 to TIM5, from 0.
    Timer(usize),
    /// USART1 to USART6, from 0.
    Usart(usize),
    /// GPIOA to GPIOI, from 0.
    Gpio(usize),
    /// DMA1 and DMA2, from 0.
    Dma(usize),
    /// Clocks.
    Rcc,
    /// Interface of the flash.
    Flash,
    /// Power control.
    Pwr,
    /// External interrupts.
    Exti,
    /// Watchdog.
    Iwdg,
    /// USB.
    Otg,
    /// Registers that are only stored.
    Stored,
}

const AHB1: u32 = 0x30;
const AHB2: u32 = 0x34;
const APB1: u32 = 0x40;
const APB2: u32 = 0x44;

/// First address, length, block, and its clock gate.
const BLOCKS: &[(u32, u32, Block, Option<Gate>)] = &[
    (0x4000_0000, 0x400, Block::Timer(0), gate(APB1, 0)),
    (0x4000_0400, 0x400, Block::Timer(1), gate(APB1, 1)),
    (0x4000_0800, 0x400, Block::Timer(2), gate(APB1, 2)),
    (0x4000_0C00, 0x400, Block::Timer(3), gate(APB1, 3)),
    (0x4000_3000, 0x400, Block::Iwdg, None),
    (0x4000_4400, 0x400, Block::Usart(1), gate(APB1, 17)),
    (0x4000_4800, 0x400, Block::Usart(2), gate(APB1, 18)),
    (0x4000_4C00, 0x400, Block::Usart(3), gate(APB1, 19)),
    (0x4000_5000, 0x400, Block::Usart(4), gate(APB1, 20)),
    (0x4000_7000, 0x400, Block::Pwr, gate(APB1, 28)),
    (0x4001_1000, 0x400, Block::Usart(0), gate(APB2, 4)),
    (0x4001_1400, 0x400, Block::Usart(5), gate(APB2, 5)),
    (0x4001_3800, 0x400, Block::Stored, gate(APB2, 14)),
    (0x4001_3C00, 0x400, Block::Exti, None),
    (0x4002_0000, 0x400, Block::Gpio(0), gate(AHB1, 0)),
    (0x4002_0400, 0x400, Block::Gpio(1), gate(AHB1, 1)),
    (0x4002_0800, 0x400, Block::Gpio(2), gate(AHB1, 2)),
    (0x4002_0C00, 0x400, Block::Gpio(3), gate(AHB1, 3)),
    (0x4002_1000, 0x400, Block::Gpio(4), gate(AHB1, 4)),
    (0x4002_1400, 0x400, Block::Gpio(5), gate(AHB1, 5)),
    (0x4002_1800, 0x400, Block::Gpio(6), gate(AHB1, 6)),
    (0x4002_1C00, 0x400, Block::Gpio(7), gate(AHB1, 7)),
    (0x4002_2000, 0x400, Block::Gpio(8), gate(AHB1, 8)),
    (0x4002_3800, 0x400, Block::Rcc, None),
    (0x4002_3C00, 0x400, Block::Flash, None),
    (0x4002_6000, 0x400, Block::Dma(0), gate(AHB1, 21)),
    (0x4002_6400, 0x400, Block::Dma(1), gate(AHB1, 22)),
    (0x5000_0000, 0x4_0000, Block::Otg, gate(AHB2, 7)),
    (0xE004_2000, 0x400, Block::Stored, None),
];

#[expect(clippy::unnecessary_wraps, reason = "it fills a column of the table")]
const fn gate(offset: u32, bit: u32) -> Option<Gate> {
    Some(Gate { offset, bit })
}

/// The block at an address, the offset in it, and its clock gate.
pub fn block_at(address: u32) -> Option<(Block, u32, Option<Gate>)> {
    let after = BLOCKS.partition_point(|(first, ..)| *first <= address);
    let (first, len, block, gate) = *BLOCKS.get(after.checked_sub(1)?)?;
    (address - first < len).then_some((block, address - first, gate))
}

/// Address of the data register of a USART.
pub fn data_register(usart: usize) -> u32 {
    let first = BLOCKS
        .iter()
        .find(|(_, _, block, _)| *block == Block::Usart(usart))
        .map_or(0, |(first, ..)| *first);
    first + 4
}

/// Interrupts of TIM2 to TIM5.
pub const TIMERS: [u16; 4] = [28, 29, 30, 50];
/// Interrupts of USART1 to USART6.
pub const USARTS: [u16; 6] = [37, 38, 39, 52, 53, 71];
/// Interrupts of the streams of DMA1 and DMA2.
pub const DMA: [[u16; 8]; 2] = [
    [11, 12, 13, 14, 15, 16, 17, 47],
    [56, 57, 58, 59, 60, 68, 69, 70],
];
/// Interrupt of the voltage detector, by external interrupt line 16.
pub const PVD: u16 = 1;
/// Line of the voltage detector.
pub const PVD_LINE: u32 = 16;
/// D+ and its alternate function (data sheet, table 9).
pub const USB_PLUS: (Pin, u32) = (Pin::new('A', 12), 10);
/// Interrupt of USB.
pub const OTG: u16 = 67;

/// Controller, stream and channel that can serve a USART's receiver.
pub const RECEIVE: [&[(usize, usize, u32)]; 6] = [
    &[(1, 2, 4), (1, 5, 4)],
    &[(0, 5, 4)],
    &[(0, 1, 4)],
    &[(0, 2, 4)],
    &[(0, 0, 4)],
    &[(1, 1, 5), (1, 2, 5)],
];
/// The same for its transmitter.
pub const TRANSMIT: [&[(usize, usize, u32)]; 6] = [
    &[(1, 7, 4)],
    &[(0, 6, 4)],
    &[(0, 3, 4), (0, 4, 7)],
    &[(0, 4, 4)],
    &[(0, 7, 4)],
    &[(1, 6, 5), (1, 7, 5)],
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_in_order_and_found() {
        assert!(BLOCKS.is_sorted_by_key(|(first, ..)| *first));
        let found = block_at(0x4000_4804).map(|(block, offset, _)| (block, offset));
        assert_eq!(found, Some((Block::Usart(2), 4)));
        assert_eq!(data_register(2), 0x4000_4804);
        assert_eq!(block_at(0x4000_2000), None);
        assert_eq!(
            block_at(0x5000_1004).map(|(_, offset, _)| offset),
            Some(0x1004)
        );
    }
}
