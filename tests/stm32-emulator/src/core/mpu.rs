//! The memory protection unit, and which default addresses execute no code.
//!
//! Eight regions with subregions; the region of highest number counts. Source: DDI 0403, B3.5.

/// Number of regions.
const REGIONS: usize = 8;

const CTRL_ENABLE: u32 = 1 << 0;
const CTRL_IN_FAULTS: u32 = 1 << 1;
const CTRL_DEFAULT: u32 = 1 << 2;
const RASR_NO_EXECUTION: u32 = 1 << 28;

/// Kind of an access.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Access {
    Read,
    Write,
    Execute,
}

/// The unit's registers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mpu {
    control: u32,
    number: usize,
    /// RBAR without VALID and REGION, and RASR.
    regions: [(u32, u32); REGIONS],
}

impl Mpu {
    #[inline]
    pub(crate) fn is_enabled(&self) -> bool {
        self.control & CTRL_ENABLE != 0
    }

    /// Whether the unit lets this access pass; `negative`: the execution priority is below 0.
    pub(crate) fn permits(
        &self,
        address: u32,
        access: Access,
        privileged: bool,
        negative: bool,
    ) -> bool {
        let by_default = access != Access::Execute || is_executable(address);
        // The private peripheral bus is not the unit's.
        if address >> 20 == 0xE00 {
            return by_default;
        }
        if !self.is_enabled() || negative && self.control & CTRL_IN_FAULTS == 0 {
            return by_default;
        }
        let matching = self.regions.iter().rev().find(|(base, attributes)| {
            let exponent = (attributes >> 1 & 31) + 1;
            // The base is a multiple of the size, up to the whole of 4 GiB.
            let within = (1_u64 << exponent) as u32;
            let within = within.wrapping_sub(1);
            let offset = address & within;
            if attributes & 1 == 0 || exponent < 5 || (address ^ base) & !within != 0 {
                return false;
            }
            let subregion = offset >> (exponent - 3) & 7;
            exponent < 8 || attributes >> (8 + subregion) & 1 == 0
        });
        let Some((_, attributes)) = matching else {
            return privileged && self.control & CTRL_DEFAULT != 0 && by_default;
        };
        let (read, write) = match (attributes >> 24 & 7, privileged) {
            (1 | 2, true) | (3, _) => (true, true),
            (2, false) | (5, true) | (6 | 7, _) => (true, false),
            _ => (false, false),
        };
        match access {
            Access::Read => read,
            Access::Write => write,
            Access::Execute => {
                let forbidden = attributes & RASR_NO_EXECUTION != 0 || address >> 29 == 7;
                read && !forbidden
            }
        }
    }

    /// Reads a register by its offset from `0xE000_ED90`.
    pub(crate) fn read(&self, offset: u32) -> u32 {
        match offset {
            0x0 => (REGIONS as u32) << 8,
            0x4 => self.control,
            0x8 => self.number as u32,
            0xC..=0x28 => {
                let (base, attributes) = self.regions[self.number];
                if offset & 4 != 0 {
                    base | self.number as u32
                } else {
                    attributes
                }
            }
            _ => 0,
        }
    }

    /// Writes a register.
    pub(crate) fn write(&mut self, offset: u32, value: u32) {
        match offset {
            0x4 => self.control = value & 7,
            0x8 => self.number = value as usize % REGIONS,
            // RBAR and its aliases; then RASR and its aliases.
            0xC..=0x28 if offset & 4 != 0 => {
                if value & 1 << 4 != 0 {
                    self.number = (value & 15) as usize % REGIONS;
                }
                self.regions[self.number].0 = value & !31;
            }
            0xC..=0x28 => {
                self.regions[self.number].1 = value & 0x173F_FF3F;
            }
            _ => {}
        }
    }
}

/// Whether instructions may be fetched there with the default memory map: B3.1.
pub(crate) fn is_executable(address: u32) -> bool {
    !matches!(address >> 29, 2 | 5 | 6 | 7)
}
