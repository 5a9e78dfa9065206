//! Reads and writes of the processor, and of the DMA.

use super::map::{Block, block_at};
use super::{System, Unmodelled};
use crate::line::Line;
use crate::memory::{BusError, Memory, Width};
use crate::peripherals::flash;

/// SRAM.
const SRAM: u32 = 0x2000_0000;
/// Core-coupled memory, which only the core reaches.
const CCM: u32 = 0x1000_0000;
/// The ROM boot loader: 30 kB. Its contents are not known here; it reads as its own
/// addresses, which are no program.
const ROM: std::ops::Range<u32> = 0x1FFF_0000..0x1FFF_7800;
/// Unique identifier of the chip (section 39.1), flash size.
const IDENTIFIER: std::ops::Range<u32> = 0x1FFF_7A10..0x1FFF_7A24;
/// Identifier of an emulated chip: X, Y, wafer, lot in ASCII.
const UNIQUE: [u8; 12] = *b"\x2A\0\x17\x0041Q3810 ";

fn len(width: Width) -> usize {
    match width {
        Width::Byte => 1,
        Width::Half => 2,
        Width::Word => 4,
    }
}

fn load(bytes: &[u8], offset: usize, width: Width) -> Option<u32> {
    let bytes = bytes.get(offset..offset + len(width))?;
    Some(
        bytes
            .iter()
            .rev()
            .fold(0, |word, byte| word << 8 | u32::from(*byte)),
    )
}

fn store(bytes: &mut [u8], offset: usize, width: Width, value: u32) -> Option<()> {
    let bytes = bytes.get_mut(offset..offset + len(width))?;
    for (byte, new) in bytes.iter_mut().zip(value.to_le_bytes()) {
        *byte = new;
    }
    Some(())
}

impl<L: Line> System<L> {
    /// Offset in flash, which is at its address and, by the boot pins, at 0 too.
    fn flash_offset(&self, address: u32) -> Option<u32> {
        let len = self.flash.bytes().len() as u32;
        let offset = address.wrapping_sub(flash::BASE);
        if offset < len {
            Some(offset)
        } else {
            (address < len).then_some(address)
        }
    }

    /// A read of flash waits for an erase or a write in progress.
    fn wait_for_flash(&mut self) {
        let busy = self.flash.busy_until();
        if busy > self.now {
            let hz = self.rcc.clocks().core_hz;
            self.stall += (busy - self.now).count(hz) + 1;
        }
    }

    pub(super) fn read_block(&mut self, address: u32) -> Option<u32> {
        let Some((block, offset, gate)) = block_at(address) else {
            self.unmodelled.insert(Unmodelled::Address(address));
            return None;
        };
        if gate.is_some_and(|gate| !self.rcc.is_enabled(gate)) {
            self.unmodelled.insert(Unmodelled::NoClock(address));
            return Some(0);
        }
        let now = self.now;
        // Timers, pins and clocks are as they were after a read.
        self.is_touched |= matches!(block, Block::Usart(_) | Block::Otg | Block::Dma(_));
        let value = match block {
            Block::Timer(index) => self.timers[index].read(now, offset),
            Block::Usart(index) => self.usarts[index].read(now, offset),
            Block::Gpio(port) => self.gpio.read(port, offset),
            Block::Dma(index) => self.dma[index].read(offset),
            Block::Rcc => self.rcc.read(now, offset),
            Block::Flash => self.flash.read(now, offset),
            Block::Pwr => self.pwr.read(offset, self.supply_mv),
            Block::Exti => self.exti.read(offset),
            Block::Iwdg => self.iwdg.read(offset),
            Block::Otg => self.otg.read(offset),
            Block::Stored => Some(match address {
                0xE004_2000 => self.board.chip.id_code,
                _ => self.stored.get(&address).copied().unwrap_or(0),
            }),
        };
        if value.is_none() {
            self.unmodelled.insert(Unmodelled::Address(address));
        }
        Some(value.unwrap_or(0))
    }

    pub(super) fn write_block(&mut self, address: u32, value: u32) -> Option<()> {
        let Some((block, offset, gate)) = block_at(address) else {
            self.unmodelled.insert(Unmodelled::Address(address));
            return None;
        };
        if gate.is_some_and(|gate| !self.rcc.is_enabled(gate)) {
            self.unmodelled.insert(Unmodelled::NoClock(address));
            return Some(());
        }
        let now = self.now;
        self.is_touched = true;
        let done = match block {
            Block::Timer(index) => self.timers[index].write(now, offset, value),
            Block::Usart(index) => self.usarts[index].write(now, offset, value),
            Block::Gpio(port) => self.gpio.write(now, port, offset, value),
            Block::Dma(index) => self.dma[index].write(offset, value),
            Block::Rcc => {
                let done = self.rcc.write(now, offset, value);
                self.update_clocks();
                done
            }
            Block::Flash => self.flash.write(now, offset, value),
            Block::Pwr => self.pwr.write(offset, value),
            Block::Exti => self.exti.write(offset, value),
            Block::Iwdg => self.iwdg.write(now, offset, value),
            Block::Otg => self.otg.write(offset, value),
            Block::Stored => {
                self.stored.insert(address, value);
                Some(())
            }
        };
        if done.is_none() {
            self.unmodelled.insert(Unmodelled::Address(address));
        }
        Some(())
    }

    /// Reads memory for the DMA, which does not reach core-coupled memory.
    pub(super) fn dma_read(&self, address: u32) -> Option<u8> {
        let offset = address.wrapping_sub(SRAM) as usize;
        let flash = self.flash_offset(address).map(|offset| offset as usize);
        let sram = self.sram.get(offset);
        sram.or_else(|| self.flash.bytes().get(flash?)).copied()
    }

    /// Writes memory for the DMA.
    pub(super) fn dma_write(&mut self, address: u32, byte: u8) -> Option<()> {
        *self.sram.get_mut(address.wrapping_sub(SRAM) as usize)? = byte;
        Some(())
    }
}

/// A register of 32 bits from which `width` is read at `address`.
fn part(word: u32, address: u32, width: Width) -> u32 {
    let word = word >> (8 * (address & 3));
    match width {
        Width::Byte => word & 0xFF,
        Width::Half => word & 0xFFFF,
        Width::Word => word,
    }
}

impl<L: Line> Memory for System<L> {
    #[inline]
    fn read(&mut self, address: u32, width: Width) -> Result<u32, BusError> {
        let sram = address.wrapping_sub(SRAM) as usize;
        if let Some(value) = load(&self.sram, sram, width) {
            return Ok(value);
        }
        if let Some(offset) = self.flash_offset(address) {
            self.wait_for_flash();
            self.stall += self.flash.data_stall(offset);
            return load(self.flash.bytes(), offset as usize, width).ok_or(BusError);
        }
        if let Some(value) = load(&self.ccm, address.wrapping_sub(CCM) as usize, width) {
            return Ok(value);
        }
        if IDENTIFIER.contains(&address) {
            let mut bytes = [0xFF; 20];
            bytes[..12].copy_from_slice(&UNIQUE);
            let flash_kib = (self.flash.bytes().len() / 1_024) as u16;
            bytes[18..].copy_from_slice(&flash_kib.to_le_bytes());
            let offset = (address - IDENTIFIER.start) as usize;
            return load(&bytes, offset, width).ok_or(BusError);
        }
        if ROM.contains(&address) {
            return Ok(part(address & !3 | 1, address, width));
        }
        let word = self.read_block(address & !3).ok_or(BusError)?;
        Ok(part(word, address, width))
    }

    #[inline]
    fn write(&mut self, address: u32, width: Width, value: u32) -> Result<(), BusError> {
        let sram = address.wrapping_sub(SRAM) as usize;
        if store(&mut self.sram, sram, width, value).is_some() {
            return Ok(());
        }
        if store(
            &mut self.ccm,
            address.wrapping_sub(CCM) as usize,
            width,
            value,
        )
        .is_some()
        {
            return Ok(());
        }
        if let Some(offset) = self.flash_offset(address) {
            self.flash
                .program(self.now, offset as usize, value, len(width));
            return Ok(());
        }
        // A register is written as a whole: a byte of the flash's ACR, say, repeats.
        self.write_block(address & !3, value).ok_or(BusError)
    }

    #[inline]
    fn fetch(&mut self, address: u32) -> Result<u16, BusError> {
        if let Some(offset) = self.flash_offset(address) {
            let halfword = load(self.flash.bytes(), offset as usize, Width::Half);
            return halfword.map(|halfword| halfword as u16).ok_or(BusError);
        }
        let sram = address.wrapping_sub(SRAM) as usize;
        let halfword = load(&self.sram, sram, Width::Half);
        halfword.map(|halfword| halfword as u16).ok_or(BusError)
    }

    #[inline]
    fn executes(&mut self, address: u32, halfwords: u32) {
        let Some(offset) = self.flash_offset(address) else {
            return;
        };
        self.wait_for_flash();
        self.stall += self.flash.fetch_stall(self.cycles, offset);
        // An instruction may begin in one line and end in the next.
        let last = offset + 2 * (halfwords - 1);
        self.stall += self.flash.fetch_stall(self.cycles + self.stall, last);
    }
}
