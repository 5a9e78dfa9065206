//! Settings of the bus line: firmware, speed and set-up state of the servos.

use super::{Busy, Master};
use crate::bus::Bus;
use crate::exchange::Readiness;
use crate::master::timing::tick_us;
use crate::{ControlMode, Firmware, ServoIds};

impl<B: Bus> Master<B> {
    /// Sets the firmware of the servos and the speed of the line.
    ///
    /// # Errors
    /// [`Busy`] while a transaction is under way.
    pub fn set_line(&mut self, firmware: Firmware, baud: u32) -> Result<(), Busy> {
        if !self.is_idle() {
            return Err(Busy);
        }
        self.line.firmware = firmware;
        if self.line.baud != baud {
            self.line.baud = baud;
            self.bus.set_baud(baud);
        }
        self.note_least_period();
        Ok(())
    }

    /// Sets the servos under control, which have to be searched for.
    ///
    /// # Errors
    /// [`Busy`] while a transaction is under way.
    pub fn set_servos(&mut self, ids: ServoIds) -> Result<(), Busy> {
        if !self.is_idle() {
            return Err(Busy);
        }
        self.line.ids = ids;
        Ok(())
    }

    /// Notes the shortest period after a change of the line.
    pub(super) fn note_least_period(&mut self) {
        let line = &mut self.line;
        line.least_period_us = tick_us(line.firmware, line.baud, line.readiness);
    }

    /// Shortest period in µs in which a tick's exchange is sure to end.
    pub fn least_period_us(&self) -> u32 {
        self.line.least_period_us
    }

    /// Sets the time in µs that a tick's exchange may take, which determines its margin.
    pub fn set_available(&mut self, us: u32) {
        self.line.available_us = us;
    }

    /// Forgets whether the bus echoes; the end of the next transaction, which must have no
    /// reply, shows it.
    pub fn forget_echo(&mut self) {
        self.echo.forget_bus();
    }

    /// Sets that stock or X servos are prepared, and what their commands are; if `None`, their
    /// settings are unknown, and a tick only reads their positions.
    pub fn set_prepared(&mut self, mode: Option<ControlMode>) {
        self.line.readiness = match mode {
            Some(mode) => {
                self.line.mode = mode;
                Readiness::Prepared
            }
            None => Readiness::Unknown,
        };
        self.note_least_period();
    }

    /// Marks stock servos as released: no longer prepared, but with the same response
    /// time.
    pub fn mark_released(&mut self) {
        if self.line.readiness == Readiness::Prepared {
            self.line.readiness = Readiness::Released;
            self.note_least_period();
        }
    }

    /// Whether torque can be given to the servos.
    pub fn is_prepared(&self) -> bool {
        self.line.readiness == Readiness::Prepared || self.line.firmware == Firmware::Morpheus
    }

    /// What commands of the servos are, PWM unless they are prepared for another.
    pub fn mode(&self) -> ControlMode {
        if self.line.readiness == Readiness::Prepared {
            self.line.mode
        } else {
            ControlMode::Pwm
        }
    }

    /// Whether the servos answer without the return delay of the factory.
    pub fn answers_soon(&self) -> bool {
        self.line.readiness.answers_soon() || self.line.firmware == Firmware::Morpheus
    }

    /// Last known activity on the bus, in µs.
    pub fn active_us(&self) -> u64 {
        self.active_us
    }

    /// Firmware of the servos.
    pub fn firmware(&self) -> Firmware {
        self.line.firmware
    }

    /// Speed of the line in bits per second.
    pub fn baud(&self) -> u32 {
        self.line.baud
    }
}
