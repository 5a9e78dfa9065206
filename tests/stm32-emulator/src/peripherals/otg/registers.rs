//! Registers of the block, and its FIFOs (section 34.16).

use super::endpoint::{STUP, TXFE, XFRC};
use super::{ENDPOINTS, Entry, OUT_DONE, Otg, SETUP_DONE};

impl Otg {
    /// Reads a register or the receive FIFO.
    pub fn read(&mut self, offset: u32) -> Option<u32> {
        Some(match offset {
            0x000 => self.session,
            0x008 => self.ahb,
            0x00C => self.usb,
            // AHB idle; resets and flushes are done at once.
            0x010 => 1 << 31,
            0x014 => self.pending(),
            0x018 => self.mask,
            0x01C => self.received.front().map_or(0, status_word),
            0x020 => self.pop(),
            0x024 => self.receive_words,
            0x028 => self.transmit[0],
            0x038 => self.phy,
            0x03C => self.id,
            // GOTGINT. HWCFG4: not among the registers of the manual; only its width of the PHY is
            // read, which an internal one does not use.
            0x004 | 0x050 => 0,
            0x104..=0x114 => *self.transmit.get((offset as usize - 0x100) / 4)?,
            0x800 => self.device,
            0x804 => self.device_control,
            // Full speed.
            0x808 => 3 << 1,
            0x810 => self.in_mask,
            0x814 => self.out_mask,
            0x818 => self.all_interrupts(),
            0x81C => self.all_mask,
            0x834 => self.empty_mask,
            0x900..0xA00 => {
                let (index, register) = place(offset - 0x900)?;
                let words = self.free_words(index);
                let endpoint = &self.inputs[index];
                match register {
                    0x00 => endpoint.control(),
                    0x08 => {
                        let empty = if endpoint.fifo.is_empty() { TXFE } else { 0 };
                        endpoint.interrupts | empty
                    }
                    0x10 => endpoint.size,
                    0x18 => words,
                    _ => return None,
                }
            }
            0xB00..0xC00 => {
                let (index, register) = place(offset - 0xB00)?;
                let endpoint = &self.outputs[index];
                match register {
                    0x00 => endpoint.control(),
                    0x08 => endpoint.interrupts,
                    0x10 => endpoint.size,
                    _ => return None,
                }
            }
            0xE00 => self.power,
            0x1000..0x1_0000 => self.reading.pop_front().unwrap_or(0),
            _ => return None,
        })
    }

    /// Writes a register or a transmit FIFO; `None` if there is none.
    pub fn write(&mut self, offset: u32, value: u32) -> Option<()> {
        match offset {
            0x000 => self.session = value,
            0x004 => {}
            0x008 => self.ahb = value,
            0x00C => self.usb = value,
            0x010 => self.reset_parts(value),
            0x014 => self.interrupts &= !value,
            0x018 => self.mask = value,
            0x024 => self.receive_words = value & 0xFFFF,
            0x028 => self.transmit[0] = value,
            0x038 => self.phy = value,
            0x03C => self.id = value,
            0x104..=0x114 => *self.transmit.get_mut((offset as usize - 0x100) / 4)? = value,
            0x800 => self.device = value,
            0x804 => self.device_control = value,
            0x810 => self.in_mask = value,
            0x814 => self.out_mask = value,
            0x81C => self.all_mask = value,
            0x834 => self.empty_mask = value,
            0x900..0xA00 => {
                let (index, register) = place(offset - 0x900)?;
                let endpoint = &mut self.inputs[index];
                match register {
                    0x00 => endpoint.write(value),
                    0x08 => endpoint.interrupts &= !value,
                    0x10 => endpoint.size = value,
                    _ => return None,
                }
            }
            0xB00..0xC00 => {
                let (index, register) = place(offset - 0xB00)?;
                let endpoint = &mut self.outputs[index];
                match register {
                    0x00 => endpoint.write(value),
                    0x08 => endpoint.interrupts &= !value,
                    0x10 => endpoint.size = value,
                    _ => return None,
                }
            }
            0xE00 => self.power = value,
            0x1000..0x1_0000 => {
                let index = ((offset - 0x1000) >> 12) as usize;
                let fifo = &mut self.inputs.get_mut(index)?.fifo;
                fifo.extend(value.to_le_bytes());
            }
            _ => return None,
        }
        Some(())
    }

    /// GRSTCTL: resets and flushes.
    fn reset_parts(&mut self, value: u32) {
        if value & 1 != 0 {
            *self = Self {
                id: self.id,
                phy: self.phy,
                is_wired: self.is_wired,
                ..Self::default()
            };
        }
        if value & 1 << 4 != 0 {
            self.received.clear();
            self.reading.clear();
        }
        if value & 1 << 5 != 0 {
            let number = value >> 6 & 0x1F;
            for (index, endpoint) in self.inputs.iter_mut().enumerate() {
                if number == 0x10 || number == index as u32 {
                    endpoint.fifo.clear();
                }
            }
        }
    }

    /// Free words of an IN endpoint's FIFO.
    fn free_words(&self, index: usize) -> u32 {
        let used = self.inputs[index].fifo.len().div_ceil(4) as u32;
        (self.transmit[index] >> 16).saturating_sub(used)
    }

    /// Pops the receive FIFO's next entry (GRXSTSP); its bytes are read from the FIFO.
    fn pop(&mut self) -> u32 {
        let Some(entry) = self.received.pop_front() else {
            return 0;
        };
        let words = entry.data.chunks(4).map(|chunk| {
            let bytes = chunk.iter().rev();
            bytes.fold(0, |word, byte| word << 8 | u32::from(*byte))
        });
        self.reading.extend(words);
        match entry.status {
            SETUP_DONE => self.outputs[entry.endpoint].interrupts |= STUP,
            OUT_DONE => self.outputs[entry.endpoint].interrupts |= XFRC,
            _ => {}
        }
        status_word(&entry)
    }
}

fn status_word(entry: &Entry) -> u32 {
    entry.endpoint as u32 | (entry.data.len() as u32) << 4 | entry.status << 17
}

/// Endpoint and register at an offset among those of one direction.
fn place(offset: u32) -> Option<(usize, u32)> {
    let index = (offset >> 5) as usize;
    (index < ENDPOINTS).then_some((index, offset & 0x1F))
}
