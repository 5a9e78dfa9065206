//! Effects of instructions: what follows from the registers that are written, and what is done
//! after the status packet.
//!
//! From the e-Manual: a new operating mode resets gains, profile and goals; the turns of the
//! position are reset by position and extended position control mode when they are set, and by
//! torque on in position control mode; a goal enables torque if the drive mode says so.

use armbridge_servo::protocol2::model::OperatingMode;
use armbridge_servo::protocol2::register as at;

use super::XServo;
use super::memory::{GOALS, Write};
use super::table;

/// Time for two bytes of EEPROM.
const EEPROM_WORD_NS: u64 = 140_000;

/// Action after the status packet.
#[derive(Clone, Debug)]
pub(super) enum Deferred {
    Write(Write),
    /// With the option of the instruction.
    Reset(u8),
    Reboot,
}

impl XServo {
    /// Executes the action that was deferred until after the status packet.
    pub(super) fn run_deferred(&mut self, now_ns: u64) {
        match self.deferred.take() {
            None => {}
            Some(Deferred::Write(writes)) => {
                let persistent = writes.iter().filter(|(address, _)| *address < table::RAM);
                let words = persistent.count().div_ceil(2) as u64;
                self.apply(&writes);
                self.deaf_until_ns = self.deaf_until_ns.max(now_ns + words * EEPROM_WORD_NS);
            }
            Some(Deferred::Reset(option)) => {
                let (id, rate) = (self.id(), self.memory.byte(at::BAUD_RATE));
                self.memory.reset_eeprom();
                if option != 0xFF {
                    self.memory.set_byte(at::ID, id);
                }
                if option == 2 {
                    self.memory.set_byte(at::BAUD_RATE, rate);
                }
                self.restart(now_ns);
            }
            Some(Deferred::Reboot) => self.restart(now_ns),
        }
    }

    /// Writes checked bytes, with all that follows from them.
    pub(super) fn apply(&mut self, writes: &[(u16, u8)]) {
        let was_on = self.memory.torque_on();
        let mode = self.memory.byte(at::OPERATING_MODE);
        let was_reverse = self.memory.is_reverse();
        self.memory.write(writes);
        let writes_to = |register: u16| writes.iter().any(|(address, _)| *address == register);
        let has_goal = GOALS.into_iter().any(writes_to);
        let is_by_goal = self.memory.byte(at::DRIVE_MODE) & at::TORQUE_BY_GOAL != 0;
        if is_by_goal && has_goal && !self.memory.is_shut_down {
            self.memory.set_byte(at::TORQUE_ENABLE, 1);
        }
        if self.memory.is_reverse() != was_reverse {
            self.motor.turn_round();
        }
        let is_joint = self.memory.has_mode(&[OperatingMode::Position]);
        if self.memory.byte(at::OPERATING_MODE) != mode {
            self.memory.reset_control();
            if is_joint || self.memory.has_mode(&[OperatingMode::ExtendedPosition]) {
                self.motor.clear_turns();
            }
            self.motor.stop(&mut self.memory);
        }
        if self.memory.torque_on() && !was_on {
            if is_joint {
                self.motor.clear_turns();
            }
            if !writes_to(at::GOAL_POSITION) {
                self.motor.stop(&mut self.memory);
            }
        }
    }
}
