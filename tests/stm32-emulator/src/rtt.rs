//! The image's log: the bytes of its RTT channel, taken as a debug probe takes them.
//!
//! A control block in RAM (`_SEGGER_RTT`) has the address, the size and both indices of a
//! ring buffer; the probe advances the index of reading.

use crate::image::Image;

/// A reader of the log.
#[derive(Clone, Copy, Debug)]
pub struct Rtt {
    control: u32,
}

/// Offset of the first channel towards the probe in the control block: an identifier of 16
/// bytes and two counts.
const CHANNEL: u32 = 24;

impl Rtt {
    /// The reader for an image that has such a log.
    pub fn of(image: &Image) -> Option<Self> {
        let control = image.symbol("_SEGGER_RTT")?;
        Some(Self { control })
    }

    /// Takes all bytes in the buffer. `sram` begins at `0x2000_0000`.
    pub fn take(self, sram: &mut [u8]) -> Vec<u8> {
        const BASE: u32 = 0x2000_0000;
        let at = |address: u32| address.wrapping_sub(BASE) as usize;
        let word = |sram: &[u8], address: u32| {
            let bytes = sram.get(at(address)..at(address) + 4)?;
            Some(u32::from_le_bytes(bytes.try_into().ok()?))
        };
        let channel = self.control + CHANNEL;
        let field = |sram: &[u8], index: u32| word(sram, channel + 4 * index).unwrap_or(0);
        let [buffer, size, write, read] = [1, 2, 3, 4].map(|index| field(sram, index));
        let Some(ring) = sram.get(at(buffer)..at(buffer) + size as usize) else {
            return Vec::new();
        };
        if write >= size || read >= size {
            return Vec::new();
        }
        let (write_at, read_at) = (write as usize, read as usize);
        let bytes = if write_at >= read_at {
            ring[read_at..write_at].to_vec()
        } else {
            [&ring[read_at..], &ring[..write_at]].concat()
        };
        let index = at(channel + 16);
        sram[index..index + 4].copy_from_slice(&write.to_le_bytes());
        bytes
    }
}
