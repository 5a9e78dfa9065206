//! Power control (section 5): the programmable voltage detector, and the over-drive of the
//! F446. Standby and stop modes are not modelled.

const PVDE: u32 = 1 << 4;
const ODEN: u32 = 1 << 16;
const ODSWEN: u32 = 1 << 17;

/// The block.
#[derive(Clone, Debug)]
pub struct Pwr {
    control: u32,
    status: u32,
}

impl Default for Pwr {
    fn default() -> Self {
        Self {
            control: 0x0000_4000,
            status: 0,
        }
    }
}

impl Pwr {
    /// Whether the detector finds the supply too low, by its nominal thresholds (section
    /// 5.4.1, PLS); their spread and hysteresis are not modelled.
    pub fn is_low(&self, supply_mv: u32) -> bool {
        let thresholds = [2_000, 2_100, 2_300, 2_500, 2_600, 2_700, 2_800, 2_900];
        let threshold = thresholds[(self.control >> 5 & 7) as usize];
        self.control & PVDE != 0 && supply_mv < threshold
    }

    /// Reads a register.
    pub fn read(&self, offset: u32, supply_mv: u32) -> Option<u32> {
        Some(match offset {
            0x0 => self.control,
            // The regulator is ready, over-drive as it was asked for.
            0x4 => {
                let over_drive = self.control & (ODEN | ODSWEN);
                self.status | over_drive | 1 << 14 | u32::from(self.is_low(supply_mv)) << 2
            }
            _ => return None,
        })
    }

    /// Writes a register; `None` if there is none.
    pub fn write(&mut self, offset: u32, value: u32) -> Option<()> {
        match offset {
            0x0 => self.control = value,
            0x4 => self.status = value & 0x300,
            _ => return None,
        }
        Some(())
    }
}
