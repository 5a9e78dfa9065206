//! The EEPROM and the register map.
//!
//! | address    | bytes | register                                          |
//! |------------|-------|---------------------------------------------------|
//! | 0x00       | 1     | marker, 0xAA; anything else restores all defaults |
//! | 0x01       | 1     | id                                                |
//! | 0x02, 0x03 | 1     | upper and lower margin of the position range      |
//! | 0x04..0x06 | 1     | position gains P, I, D                            |
//! | 0x07..0x09 | 1     | speed gains P, I, D                               |
//! | 0x0A       | 1     | rate: 2 000 000 / (value + 1) baud                |
//! | 0x0B       | 2     | position (read), goal (written)                   |
//! | 0x0D       | 1     | speed                                             |
//! | 0x0E       | 2     | temperature                                       |
//! | 0x10       | 2     | PWM; its high byte always reads 0                 |

use super::control::Gains;

/// Registers below this address are kept in the EEPROM.
pub(super) const ROM_REGISTERS: u8 = 0x0B;
/// One past the last register.
pub(super) const REGISTERS: u8 = 0x12;
/// Number of EEPROM registers.
pub const ROM_SIZE: usize = ROM_REGISTERS as usize;

pub(super) const MARKER: u8 = 0x00;
pub(super) const MARKER_VALID: u8 = 0xAA;
pub(super) const ID: u8 = 0x01;
pub(super) const BAUD: u8 = 0x0A;
pub(super) const POSITION_LOW: u8 = 0x0B;
pub(super) const POSITION_HIGH: u8 = 0x0C;
pub(super) const SPEED: u8 = 0x0D;
pub(super) const TEMPERATURE_LOW: u8 = 0x0E;
pub(super) const TEMPERATURE_HIGH: u8 = 0x0F;
pub(super) const PWM_LOW: u8 = 0x10;
pub(super) const PWM_HIGH: u8 = 0x11;

/// The EEPROM with the firmware's defaults: id 1, 1 Mbaud.
pub const DEFAULT_ROM: [u8; ROM_SIZE] = [MARKER_VALID, 1, 2, 2, 0x28, 1, 10, 0x28, 10, 0, 1];
/// Order in which the defaults are restored: the marker last.
pub(super) const RESTORE_ORDER: [u8; ROM_SIZE] = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 0];

/// Rates that are accepted: 2M, 1M, 500k, 115200, 57600 and 9600 baud.
const BAUD_ACCEPTED: [u8; 6] = [0, 1, 3, 16, 34, 207];

/// Whether the firmware stores this value.
pub(super) fn storable(address: u8, value: u8) -> bool {
    match address {
        ID => value != 0 && value != 0xFF,
        BAUD => BAUD_ACCEPTED.contains(&value),
        _ => true,
    }
}

/// Reads an EEPROM cell; cells beyond the registers are erased.
pub(super) fn cell(rom: &[u8; ROM_SIZE], address: u8) -> u8 {
    rom.get(usize::from(address)).copied().unwrap_or(0xFF)
}

/// The settings of the control step.
pub(super) fn gains(rom: &[u8; ROM_SIZE]) -> Gains {
    Gains {
        upper_margin: rom[2],
        lower_margin: rom[3],
        position: [rom[4], rom[5], rom[6]],
        speed: [rom[7], rom[8], rom[9]],
    }
}

/// Commanded values, and the previous ones.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Requests {
    pub(super) goal: u16,
    pub(super) goal_before: u16,
    pub(super) speed: u16,
    pub(super) pwm: u16,
    pub(super) pwm_before: u16,
    /// The last PWM taken from a sync write.
    pub(super) pwm_sync: u16,
}

fn with_low(word: u16, low: u8) -> u16 {
    u16::from_le_bytes([low, word.to_le_bytes()[1]])
}

fn with_high(word: u16, high: u8) -> u16 {
    u16::from_le_bytes([word.to_le_bytes()[0], high])
}

impl Requests {
    /// Writes a register that is not in the EEPROM. Writing either half of
    /// the PWM makes it count as changed, with any value.
    pub(super) fn write(&mut self, address: u8, value: u8) {
        match address {
            POSITION_LOW => self.goal = with_low(self.goal, value),
            POSITION_HIGH => self.goal = with_high(self.goal, value),
            SPEED => self.speed = value.into(),
            PWM_LOW | PWM_HIGH => {
                self.pwm = if address == PWM_LOW {
                    with_low(self.pwm, value)
                } else {
                    with_high(self.pwm, value)
                };
                self.pwm_before = self.pwm.wrapping_add(1);
            }
            _ => {}
        }
    }
}
