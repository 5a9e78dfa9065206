//! DMA streams (section 10) between memory and a peripheral's register: direct mode, bytes,
//! halfwords and words, circular or not. FIFO, bursts, double buffers and
//! memory-to-memory transfers are not modelled.
//!
//! The block keeps the registers; who moves a datum is the chip, which knows memory and
//! peripherals, and asks whether a stream serves a register ([`Dma::serves`]).

const EN: u32 = 1;
const TCIE: u32 = 1 << 4;
const HTIE: u32 = 1 << 3;
const TO_PERIPHERAL: u32 = 1 << 6;
const CIRC: u32 = 1 << 8;
const PINC: u32 = 1 << 9;
const MINC: u32 = 1 << 10;

const TRANSFERRED: u32 = 1 << 5;
const HALF: u32 = 1 << 4;

/// Direction of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// From the peripheral to memory.
    FromPeripheral,
    /// From memory to the peripheral.
    ToPeripheral,
}

#[derive(Clone, Copy, Debug, Default)]
struct Stream {
    control: u32,
    left: u32,
    /// Number of data as written, to which a circular stream returns.
    total: u32,
    peripheral: u32,
    memory: [u32; 2],
    fifo: u32,
    flags: u32,
}

/// A controller.
#[derive(Clone, Debug, Default)]
pub struct Dma {
    streams: [Stream; 8],
}

impl Dma {
    /// Whether a stream is enabled, on `channel`, and serves the peripheral's register at
    /// `address` in this direction.
    pub fn serves(&self, stream: usize, channel: u32, address: u32, direction: Direction) -> bool {
        let to_peripheral = match direction {
            Direction::FromPeripheral => 0,
            Direction::ToPeripheral => TO_PERIPHERAL,
        };
        let stream = &self.streams[stream];
        stream.control & EN != 0
            && stream.left != 0
            && stream.peripheral == address
            && stream.control >> 25 & 7 == channel
            && stream.control & 3 << 6 == to_peripheral
    }

    /// Address in memory of the next datum of a stream, and its number of bytes.
    pub fn memory(&self, stream: usize) -> (u32, u32) {
        let stream = &self.streams[stream];
        let bytes = 1 << (stream.control >> 13 & 3);
        let index = match stream.control & MINC {
            0 => 0,
            _ => stream.total - stream.left,
        };
        (stream.memory[0] + bytes * index, bytes)
    }

    /// A datum of a stream was moved.
    pub fn moved(&mut self, stream: usize) {
        let stream = &mut self.streams[stream];
        stream.left -= 1;
        if stream.left == stream.total / 2 {
            stream.flags |= HALF;
        }
        if stream.left == 0 {
            stream.flags |= TRANSFERRED;
            if stream.control & CIRC == 0 {
                stream.control &= !EN;
            } else {
                stream.left = stream.total;
            }
        }
    }

    /// Whether the interrupt line of a stream is high.
    pub fn is_interrupt(&self, stream: usize) -> bool {
        let stream = &self.streams[stream];
        stream.control & TCIE != 0 && stream.flags & TRANSFERRED != 0
            || stream.control & HTIE != 0 && stream.flags & HALF != 0
    }

    /// Reads a register.
    pub fn read(&self, offset: u32) -> Option<u32> {
        if offset < 0x10 {
            return Some(match offset {
                0x0 => self.gather(0),
                0x4 => self.gather(4),
                _ => 0,
            });
        }
        let (index, register) = place(offset)?;
        let stream = self.streams.get(index)?;
        Some(match register {
            0x00 => stream.control,
            0x04 => stream.left,
            0x08 => stream.peripheral,
            0x0C | 0x10 => stream.memory[(register as usize - 0x0C) / 4],
            _ => stream.fifo,
        })
    }

    /// Writes a register; `None` if there is none, or if it asks for what is not modelled.
    pub fn write(&mut self, offset: u32, value: u32) -> Option<()> {
        if offset < 0x10 {
            match offset {
                0x8 => self.clear(0, value),
                0xC => self.clear(4, value),
                _ => {}
            }
            return Some(());
        }
        let (index, register) = place(offset)?;
        let stream = self.streams.get_mut(index)?;
        match register {
            0x00 => {
                // Double buffers, a peripheral's address that counts, other flow
                // controllers, memory to memory.
                if value & (1 << 18 | PINC | 1 << 5 | 1 << 7) != 0 {
                    return None;
                }
                stream.control = value;
            }
            // Section 10.5.6: written only while the stream is off.
            0x04 if stream.control & EN == 0 => {
                stream.left = value & 0xFFFF;
                stream.total = stream.left;
            }
            0x08 if stream.control & EN == 0 => stream.peripheral = value,
            0x0C | 0x10 => stream.memory[(register as usize - 0x0C) / 4] = value,
            0x14 => stream.fifo = value,
            _ => {}
        }
        Some(())
    }

    /// Flags of four streams as LISR and HISR have them.
    fn gather(&self, first: usize) -> u32 {
        let shifts = [0, 6, 16, 22];
        let streams = self.streams.iter().skip(first);
        streams
            .zip(shifts)
            .fold(0, |word, (stream, shift)| word | stream.flags << shift)
    }

    fn clear(&mut self, first: usize, value: u32) {
        let shifts = [0, 6, 16, 22];
        for (stream, shift) in self.streams.iter_mut().skip(first).zip(shifts) {
            stream.flags &= !(value >> shift);
        }
    }
}

/// Stream and register at an offset.
fn place(offset: u32) -> Option<(usize, u32)> {
    let offset = offset.checked_sub(0x10)?;
    Some(((offset / 0x18) as usize, offset % 0x18))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_circular_stream_begins_again() {
        let mut dma = Dma::default();
        let base = 0x10 + 0x18;
        for (offset, value) in [
            (base + 4, 3),
            (base + 8, 0x4000_4804),
            (base + 0xC, 0x2000_0100),
            (base, 4 << 25 | MINC | CIRC | TCIE | EN),
        ] {
            assert_eq!(dma.write(offset, value), Some(()));
        }
        let serves = |channel, direction| dma.serves(1, channel, 0x4000_4804, direction);
        assert!(serves(4, Direction::FromPeripheral));
        assert!(!serves(5, Direction::FromPeripheral) && !serves(4, Direction::ToPeripheral));
        let addresses = [0x100, 0x101, 0x102, 0x100].map(|low| 0x2000_0000 + low);
        for address in addresses {
            assert_eq!(dma.memory(1), (address, 1));
            dma.moved(1);
        }
        assert!(dma.is_interrupt(1));
        assert_eq!(dma.read(base + 4), Some(2));
        assert_eq!(dma.write(0x8, TRANSFERRED << 6), Some(()));
        assert!(!dma.is_interrupt(1));
    }
}
