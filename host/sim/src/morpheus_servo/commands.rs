//! Command interpreter: execution of each message.

use super::mcu::Mcu;
use super::receiver::SYNC_WRITE;
use super::registers::{
    self, POSITION_HIGH, POSITION_LOW, PWM_LOW, REGISTERS, ROM_REGISTERS, SPEED, TEMPERATURE_HIGH,
    TEMPERATURE_LOW,
};
use super::state::{Bus, Job, Stage};
use super::{Action, cycle_costs};

pub(super) const PING: u8 = 0x01;
const READ: u8 = 0x02;
const WRITE: u8 = 0x03;
const START: u8 = 0x06;
const CYCLE: u8 = 0x07;
const RESET: u8 = 0x09;
pub(super) const OK: u8 = 0x04;
pub(super) const REFUSED: u8 = 0x08;
const BROADCAST: u8 = 0xFF;

/// Ticks of a START slot, times the id.
const SLOT_TICKS: u16 = 100;
/// Ticks of CYCLE's fail-safe, times the baud register and the number of
/// packets seen while waiting for the slot.
const FAILSAFE_TICKS: u16 = 2;

impl Mcu {
    pub(super) fn look(&mut self, now: u64) -> Option<Action> {
        if self.job == Job::Boot {
            self.job = Job::None;
        }
        let mut head = [0; 3];
        let stuck = self.inbox.stuck();
        if !stuck && let Some(length) = self.inbox.read(0, &mut head) {
            self.scratch[..3].copy_from_slice(&head);
            if length < 0x80 {
                self.message_length = length;
                return self.go(Stage::Obey, now + cycle_costs::ACCEPT);
            }
        }
        self.chain(now)
    }

    pub(super) fn obey(&mut self, now: u64) -> Option<Action> {
        match self.stage {
            Stage::Obey => self.dispatch(now),
            Stage::Write => self.write_next(now),
            Stage::Store { address, value } => self.store(now, address, value),
            Stage::Settle => self.settle(now),
            Stage::Reset => {
                self.rom[usize::from(registers::MARKER)] = 0;
                self.rom_ready = now + cycle_costs::ROM_WRITE;
                self.go(Stage::Load { restored: 0 }, self.rom_ready)
            }
            Stage::Load { restored } => self.load(now, restored),
            Stage::Loaded => self.loaded(now),
            Stage::Reply => {
                self.send_reply();
                if self.job == Job::Unasked {
                    self.job = Job::None;
                    self.finish_turn(now)
                } else {
                    self.done(now)
                }
            }
            _ => self.done(now),
        }
    }

    pub(super) fn done(&mut self, now: u64) -> Option<Action> {
        self.job = Job::None;
        self.inbox.close();
        self.chain(now)
    }

    /// Sends without a request when its START slot or CYCLE's fail-safe is due.
    pub(super) fn chain(&mut self, now: u64) -> Option<Action> {
        if self.delay_ticks == 0 {
            if self.bus == Bus::Slot {
                self.bus = Bus::Member;
                self.job = Job::Unasked;
                return self.answer(now - cycle_costs::REPLY_UNASKED, &[PING]);
            }
            if self.bus == Bus::Member && self.cycle_pending {
                self.cycle_pending = false;
                self.job = Job::Unasked;
                return self.answer_position(now);
            }
        }
        self.finish_turn(now)
    }

    /// Builds a reply: AA, length, destination, source, data, checksum.
    pub(super) fn answer(&mut self, now: u64, data: &[u8]) -> Option<Action> {
        let head = [data.len() as u8 + 2, self.master, self.id];
        let checked = || head.iter().chain(data);
        let checksum = checked().fold(0_u8, |sum, &byte| sum.wrapping_add(!byte));
        self.reply.push_back(0xAA);
        self.reply.extend(checked());
        self.reply.push_back(checksum);
        if self.job == Job::None {
            self.job = Job::Reply;
        }
        let cost = match data.len() as u64 {
            0 => cycle_costs::REPLY - cycle_costs::REPLY_EMPTY,
            bytes => cycle_costs::REPLY + cycle_costs::REPLY_BYTE * (bytes - 1),
        };
        self.go(Stage::Reply, now + cost)
    }

    fn answer_position(&mut self, now: u64) -> Option<Action> {
        let position = (self.control.position as u16).to_be_bytes();
        self.answer(now + cycle_costs::POSITION, &position)
    }

    fn ignore(&mut self, now: u64) -> Option<Action> {
        self.go(Stage::Done, now)
    }

    fn dispatch(&mut self, now: u64) -> Option<Action> {
        let [destination, source, command] = [self.scratch[0], self.scratch[1], self.scratch[2]];
        let left = u16::from(self.message_length).wrapping_sub(4);
        if destination == BROADCAST {
            match command {
                START => {
                    self.master = source;
                    self.bus = Bus::Slot;
                    self.predecessor = 0;
                    self.delay_ticks = u16::from(self.id) * SLOT_TICKS;
                    self.ignore(now + cycle_costs::START)
                }
                WRITE => self.write(now, left, false),
                SYNC_WRITE => self.sync_write(now),
                CYCLE => self.cycle(now, source),
                RESET => self.reset(now, false),
                _ => {
                    self.master = source;
                    self.answer(now - cycle_costs::REFUSED_TO_ALL, &[REFUSED])
                }
            }
        } else if destination == self.id {
            self.master = source;
            match command {
                WRITE => self.write(now, left, true),
                READ => self.read(now),
                PING => self.answer(now, &[PING]),
                RESET => self.reset(now, true),
                _ => self.answer(now, &[REFUSED]),
            }
        } else if source == self.predecessor {
            if self.bus == Bus::Member && self.cycle_pending {
                self.cycle_pending = false;
                return self.answer_position(now);
            }
            self.ignore(now)
        } else {
            if self.bus == Bus::Slot {
                self.predecessor = source;
                self.predecessors = self.predecessors.wrapping_add(1);
                return self.ignore(now - cycle_costs::LEARNT);
            }
            self.ignore(now)
        }
    }

    fn cycle(&mut self, now: u64, source: u8) -> Option<Action> {
        let now = now + cycle_costs::CYCLE;
        if self.bus != Bus::Member {
            return self.ignore(now + cycle_costs::CYCLE_IGNORED);
        }
        self.master = source;
        if self.predecessor == 0 {
            self.cycle_pending = false;
            return self.answer_position(now);
        }
        self.cycle_pending = true;
        self.delay_ticks = FAILSAFE_TICKS
            .wrapping_mul(self.baud.into())
            .wrapping_mul(self.predecessors.into());
        self.ignore(now + cycle_costs::CYCLE_WAITS)
    }

    /// Missing arguments of a packet are stale memory.
    fn read(&mut self, now: u64) -> Option<Action> {
        let mut arguments = [0; 2];
        if self.inbox.read(3, &mut arguments).is_some() {
            self.scratch[2..4].copy_from_slice(&arguments);
        }
        let [first, count] = [self.scratch[2], self.scratch[3]];
        if u16::from(first) + u16::from(count) > REGISTERS.into() {
            return self.answer(now + cycle_costs::READ_REFUSED, &[REFUSED]);
        }
        let mut cost = cycle_costs::READ;
        for i in 0..count {
            // Only the first address decides between EEPROM and the rest.
            let place = usize::from(4 + i);
            if first < ROM_REGISTERS {
                self.scratch[place] = registers::cell(&self.rom, first + i);
                cost += cycle_costs::READ_ROM_BYTE;
            } else if first < REGISTERS {
                self.scratch[place] = self.register(first + i);
                cost += cycle_costs::READ_BYTE;
            }
        }
        let data = self.scratch;
        self.answer(now + cost, &data[4..4 + usize::from(count)])
    }

    fn register(&self, address: u8) -> u8 {
        let [position_low, position_high] = self.control.position.to_le_bytes();
        let [temperature_low, temperature_high] = self.control.temperature.to_le_bytes();
        match address {
            POSITION_LOW => position_low,
            POSITION_HIGH => position_high,
            SPEED => self.control.speed.to_le_bytes()[0],
            TEMPERATURE_LOW => temperature_low,
            TEMPERATURE_HIGH => temperature_high,
            PWM_LOW => self.requests.pwm.to_le_bytes()[0],
            _ => 0,
        }
    }
}
