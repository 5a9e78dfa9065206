//! External interrupt controller (section 12.3): edges of lines become pending interrupts.

/// The controller.
#[derive(Clone, Debug, Default)]
pub struct Exti {
    interrupts: u32,
    events: u32,
    rising: u32,
    falling: u32,
    pending: u32,
    levels: u32,
}

impl Exti {
    /// Sets the level of a line.
    pub fn set_line(&mut self, line: u32, level: bool) {
        let bit = 1 << line;
        let was_high = self.levels & bit != 0;
        if level && !was_high {
            self.levels |= bit;
            self.pending |= self.rising & self.interrupts & bit;
        } else if !level && was_high {
            self.levels &= !bit;
            self.pending |= self.falling & self.interrupts & bit;
        }
    }

    /// Whether the interrupt of a line is requested.
    pub fn is_pending(&self, line: u32) -> bool {
        self.pending >> line & 1 != 0
    }

    /// Reads a register.
    pub fn read(&self, offset: u32) -> Option<u32> {
        Some(match offset {
            0x00 => self.interrupts,
            0x04 => self.events,
            0x08 => self.rising,
            0x0C => self.falling,
            0x10 => 0,
            0x14 => self.pending,
            _ => return None,
        })
    }

    /// Writes a register; `None` if there is none.
    pub fn write(&mut self, offset: u32, value: u32) -> Option<()> {
        match offset {
            0x00 => self.interrupts = value,
            0x04 => self.events = value,
            0x08 => self.rising = value,
            0x0C => self.falling = value,
            0x10 => self.pending |= value & self.interrupts,
            0x14 => self.pending &= !value,
            _ => return None,
        }
        Some(())
    }
}
