//! Bus watchdog: the servo stops when the bus is silent.
//!
//! The e-Manual ("Bus Watchdog"): while torque is on, the time between instruction packets is
//! measured. If it is larger than the register, in units of 20 ms, the servo stops, the register
//! becomes -1, and the goals can only be read: a write is a data range error, until 0 is written
//! to the register. In its example a new goal drives the motor again then: torque has stayed on.
//!
//! Assumptions: any intact instruction packet on the bus counts, to whichever servo it goes; a
//! damaged packet, or a reply of another servo, does not. The time is looked at each control step,
//! so that it is up to a millisecond longer. The stop makes the goal of the operating mode 0, or
//! the present position, also after the error is cleared. The PWM slope holds for it.

use armbridge_servo::protocol2::model::OperatingMode;
use armbridge_servo::protocol2::register as at;

use super::XServo;
use super::memory::WATCHDOG_TRIGGERED;

/// Unit of the register.
const WATCHDOG_NS: u64 = 20_000_000;

impl XServo {
    /// Stops the servo if the bus has been silent for too long.
    pub(super) fn watch_bus(&mut self, now_ns: u64) {
        let limit = self.memory.byte(at::BUS_WATCHDOG);
        let is_set = limit != 0 && limit != WATCHDOG_TRIGGERED;
        // An instruction ends with its stop bit, which may still be on the wire.
        let silence_ns = now_ns.saturating_sub(self.last_instruction_ns);
        if !is_set || !self.memory.torque_on() || silence_ns <= u64::from(limit) * WATCHDOG_NS {
            return;
        }
        self.memory.set_byte(at::BUS_WATCHDOG, WATCHDOG_TRIGGERED);
        if self.memory.has_mode(&[OperatingMode::Pwm]) {
            self.memory.set_short(at::GOAL_PWM, 0);
        }
        if self.memory.has_mode(&[OperatingMode::Current]) {
            self.memory.set_short(at::GOAL_CURRENT, 0);
        }
        self.memory.set_long(at::GOAL_VELOCITY, 0);
        self.motor.stop(&mut self.memory);
    }
}
