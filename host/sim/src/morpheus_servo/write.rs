//! Writing registers: WRITE, `SYNC_WR` and RESET.
//!
//! Every byte is a stage of its own, because an EEPROM byte waits for the one
//! before it, with interrupts off. After the last byte a new goal or PWM takes
//! effect; if an EEPROM byte was written, all variables are loaded again, which may
//! restore the defaults first.
//!
//! A WRITE without even an address counts its bytes from -1, as 16 bits: it
//! writes, or at least counts, for 266 ms.

use super::commands::{OK, PING, REFUSED};
use super::control::OFF;
use super::mcu::Mcu;
use super::registers::{
    self, DEFAULT_ROM, MARKER, MARKER_VALID, POSITION_HIGH, POSITION_LOW, PWM_HIGH, PWM_LOW,
    REGISTERS, RESTORE_ORDER, ROM_REGISTERS,
};
use super::state::{Job, Stage};
use super::{Action, cycle_costs};

/// No packet carries more data; a larger count is a runaway.
const LONGEST_DATA: u16 = 200;

impl Mcu {
    /// Whether it executes the runaway loop of a WRITE without data.
    pub(super) fn runaway(&self) -> bool {
        self.runaway_turns > 0 || matches!(self.job, Job::Write { left, .. } if left > LONGEST_DATA)
    }

    /// Starts a WRITE.
    pub(super) fn write(&mut self, now: u64, left: u16, answer: bool) -> Option<Action> {
        let mut address = [0];
        if self.receiver.read(3, &mut address).is_some() {
            self.scratch[1] = address[0];
        }
        // Without an address in the packet, the source is used as address.
        let address = self.scratch[1];
        let last = i32::from(left as i16) + i32::from(address);
        if answer && last > REGISTERS.into() {
            return self.build_reply(now + cycle_costs::WRITE_REFUSED, &[REFUSED]);
        }
        self.job = Job::Write {
            left,
            index: 4,
            address,
            sync: false,
            answer,
            rom_changed: false,
        };
        let broadcast = if answer {
            0
        } else {
            cycle_costs::WRITE_BROADCAST
        };
        self.enter(Stage::WriteByte, now + cycle_costs::WRITE - broadcast)
    }

    /// Starts a `SYNC_WR`.
    pub(super) fn sync_write(&mut self, now: u64) -> Option<Action> {
        let mut head = [0; 2];
        if self.receiver.read(3, &mut head).is_some() {
            self.scratch[..2].copy_from_slice(&head);
        }
        let [address, count] = [self.scratch[0], self.scratch[1]];
        let mut data = [0; 256];
        let data = &mut data[..usize::from(count)];
        if self.receiver.read(6, data).is_some() {
            let room = data.len().min(self.scratch.len() - 3);
            self.scratch[2..2 + room].copy_from_slice(&data[..room]);
        }
        self.receiver.close();
        self.job = Job::Write {
            left: count.into(),
            index: 2,
            address,
            sync: true,
            answer: false,
            rom_changed: false,
        };
        self.enter(Stage::WriteByte, now + cycle_costs::SYNC_WRITE)
    }

    /// Writes one byte of a WRITE or `SYNC_WR`.
    pub(super) fn write_next(&mut self, now: u64) -> Option<Action> {
        let Job::Write {
            left,
            index,
            address,
            sync,
            answer,
            rom_changed,
        } = self.job
        else {
            return self.finish_message(now);
        };
        if left == 0 {
            self.runaway_turns = 0;
            return self.enter(Stage::ApplyWrites, now);
        }
        if sync {
            self.scratch[0] = self.scratch[usize::from(index)];
        } else {
            let mut byte = [0];
            if self.receiver.read(index, &mut byte).is_some() {
                self.scratch[0] = byte[0];
            }
        }
        let value = self.scratch[0];
        let to_rom = address < ROM_REGISTERS;
        self.job = Job::Write {
            left: left - 1,
            index: index.wrapping_add(1),
            address: address + u8::from(address < REGISTERS),
            sync,
            answer,
            rom_changed: rom_changed || to_rom,
        };
        if to_rom && registers::storable(address, value) {
            let at = self.rom_ready.max(now + cycle_costs::ROM_CALL);
            return self.enter(Stage::StoreByte { address, value }, at);
        }
        let mut cost = 0;
        if !to_rom && address < REGISTERS {
            self.requests.write(address, value);
            cost = match address {
                POSITION_LOW | POSITION_HIGH => cycle_costs::GOAL_BYTE,
                PWM_LOW | PWM_HIGH => cycle_costs::PWM_BYTE,
                _ => 0,
            };
        }
        self.next_byte(now + cost)
    }

    fn next_byte(&mut self, now: u64) -> Option<Action> {
        let Job::Write {
            left,
            index,
            address,
            sync,
            ..
        } = &mut self.job
        else {
            return self.finish_message(now);
        };
        if *sync {
            return self.enter(Stage::WriteByte, now + cycle_costs::SYNC_WRITE_BYTE);
        }
        if *left <= LONGEST_DATA {
            return self.enter(Stage::WriteByte, now + cycle_costs::WRITE_BYTE);
        }
        if *address < REGISTERS || self.receiver.is_open() || self.receiver.waiting() {
            return self.enter(Stage::WriteByte, now + cycle_costs::RUNAWAY_TURN);
        }
        // Nothing can happen until the count runs out: one long stage.
        let turns = *left;
        *index = index.wrapping_add(turns as u8);
        *left = 0;
        self.runaway_turns = turns;
        self.enter(
            Stage::WriteByte,
            now + u64::from(turns) * cycle_costs::RUNAWAY_TURN,
        )
    }

    /// Ends a long runaway stage early: a message that arrives during a runaway is
    /// consumed by it.
    pub(super) fn shorten_runaway(&mut self, now: u64) {
        let Job::Write { left, index, .. } = &mut self.job else {
            return;
        };
        if self.runaway_turns == 0 || !self.receiver.waiting() {
            return;
        }
        let turns = self.stage_end.saturating_sub(now) / cycle_costs::RUNAWAY_TURN;
        *left = turns as u16;
        *index = index.wrapping_sub(turns as u8);
        self.stage_end -= turns * cycle_costs::RUNAWAY_TURN;
        self.runaway_turns = 0;
    }

    pub(super) fn store(&mut self, now: u64, address: u8, value: u8) -> Option<Action> {
        if let Some(cell) = self.rom.get_mut(usize::from(address)) {
            *cell = value;
            self.rom_ready = now + cycle_costs::ROM_WRITE;
        }
        self.next_byte(now)
    }

    /// Applies a new goal or PWM. A goal takes precedence over a PWM, and sets the stored
    /// PWM to 1000 even when the goal is refused.
    pub(super) fn apply_writes(&mut self, now: u64) -> Option<Action> {
        let mut now = now;
        let requests = &mut self.requests;
        if requests.goal != requests.goal_before {
            requests.goal_before = requests.goal;
            let accepted = self
                .control
                .set_goal(requests.goal, requests.speed, self.gains);
            now += if accepted {
                cycle_costs::NEW_GOAL
            } else {
                cycle_costs::OUT_OF_RANGE
            };
            requests.pwm = OFF;
            requests.pwm_before = OFF;
            requests.pwm_sync = OFF;
        }
        if requests.pwm != requests.pwm_before {
            now += if self.control.set_pwm(requests.pwm) {
                cycle_costs::NEW_PWM
            } else {
                cycle_costs::OUT_OF_RANGE
            };
            requests.pwm_before = requests.pwm;
            requests.pwm_sync = requests.pwm;
            requests.goal = 0;
            requests.goal_before = 0;
        }
        match self.job {
            Job::Write {
                rom_changed: true, ..
            } => {
                let at = self.rom_ready.max(now + cycle_costs::ROM_CALL);
                self.enter(Stage::LoadEeprom { restored: 0 }, at)
            }
            Job::Write { answer: true, .. } => self.build_reply(now, &[OK]),
            _ => self.finish_message(now),
        }
    }

    pub(super) fn reset(&mut self, now: u64, answer: bool) -> Option<Action> {
        self.job = Job::Reset { answer };
        self.enter(Stage::ClearMarker, now + cycle_costs::ROM_CALL)
    }

    pub(super) fn load(&mut self, now: u64, restored: usize) -> Option<Action> {
        let valid = self.rom[usize::from(MARKER)] == MARKER_VALID;
        match RESTORE_ORDER.get(restored) {
            Some(&address) if restored > 0 || !valid => {
                let index = usize::from(address);
                self.rom[index] = DEFAULT_ROM[index];
                self.rom_ready = now + cycle_costs::ROM_NEXT + cycle_costs::ROM_WRITE;
                let restored = restored + 1;
                self.enter(Stage::LoadEeprom { restored }, self.rom_ready)
            }
            _ => self.enter(Stage::EepromLoaded, now + cycle_costs::ROM_LOAD),
        }
    }

    pub(super) fn loaded(&mut self, now: u64) -> Option<Action> {
        self.load_variables();
        self.uart.set_up(now, self.baud);
        match self.job {
            Job::Boot => self.enter(Stage::Tick, now),
            Job::Write { answer: true, .. } => self.build_reply(now, &[OK]),
            Job::Reset { answer: true } => self.build_reply(now, &[PING]),
            _ => self.finish_message(now),
        }
    }
}
