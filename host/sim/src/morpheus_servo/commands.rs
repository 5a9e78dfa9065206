//! Command interpreter: execution of each message.

use super::mcu::Mcu;
use super::receiver::SYNC_WRITE;
use super::registers::{
    self, POSITION_HIGH, POSITION_LOW, PWM_LOW, REGISTERS, ROM_REGISTERS, SPEED, TEMPERATURE_HIGH,
    TEMPERATURE_LOW,
};
use super::state::{CycleState, Job, Stage};
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

/// Ticks from START to a servo's slot, per unit of its id.
const SLOT_TICKS: u16 = 100;
/// Ticks of CYCLE's fail-safe, per unit of the baud register and per packet
/// received while waiting for the slot.
const FAILSAFE_TICKS: u16 = 2;

impl Mcu {
    /// Opens a waiting message.
    pub(super) fn poll_messages(&mut self, now: u64) -> Option<Action> {
        if self.job == Job::Boot {
            self.job = Job::None;
        }
        let mut head = [0; 3];
        let stuck = self.receiver.stuck();
        if !stuck && let Some(length) = self.receiver.read(0, &mut head) {
            self.scratch[..3].copy_from_slice(&head);
            if length < 0x80 {
                self.message_length = length;
                return self.enter(Stage::Dispatch, now + cycle_costs::ACCEPT);
            }
        }
        self.send_unsolicited(now)
    }

    /// Executes the present stage of a message.
    pub(super) fn execute(&mut self, now: u64) -> Option<Action> {
        match self.stage {
            Stage::Dispatch => self.dispatch(now),
            Stage::WriteByte => self.write_next(now),
            Stage::StoreByte { address, value } => self.store(now, address, value),
            Stage::ApplyWrites => self.apply_writes(now),
            Stage::ClearMarker => {
                self.rom[usize::from(registers::MARKER)] = 0;
                self.rom_ready = now + cycle_costs::ROM_WRITE;
                self.enter(Stage::LoadEeprom { restored: 0 }, self.rom_ready)
            }
            Stage::LoadEeprom { restored } => self.load(now, restored),
            Stage::EepromLoaded => self.loaded(now),
            Stage::QueueReply => {
                self.queue_reply();
                if self.job == Job::UnsolicitedReply {
                    self.job = Job::None;
                    self.finish_turn(now)
                } else {
                    self.finish_message(now)
                }
            }
            _ => self.finish_message(now),
        }
    }

    /// Closes the message.
    pub(super) fn finish_message(&mut self, now: u64) -> Option<Action> {
        self.job = Job::None;
        self.receiver.close();
        self.send_unsolicited(now)
    }

    /// Replies without a request when its START slot or CYCLE's fail-safe is due.
    pub(super) fn send_unsolicited(&mut self, now: u64) -> Option<Action> {
        if self.delay_ticks == 0 {
            if self.cycle_state == CycleState::AwaitingSlot {
                self.cycle_state = CycleState::Member;
                self.job = Job::UnsolicitedReply;
                return self.build_reply(now - cycle_costs::REPLY_UNSOLICITED, &[PING]);
            }
            if self.cycle_state == CycleState::Member && self.cycle_pending {
                self.cycle_pending = false;
                self.job = Job::UnsolicitedReply;
                return self.reply_position(now);
            }
        }
        self.finish_turn(now)
    }

    /// Builds a reply: AA, length, destination, source, data, checksum.
    pub(super) fn build_reply(&mut self, now: u64, data: &[u8]) -> Option<Action> {
        let head = [data.len() as u8 + 2, self.master, self.id];
        let body = || head.iter().chain(data);
        let checksum = body().fold(0_u8, |sum, &byte| sum.wrapping_add(!byte));
        self.reply.push_back(0xAA);
        self.reply.extend(body());
        self.reply.push_back(checksum);
        if self.job == Job::None {
            self.job = Job::Reply;
        }
        let cost = match data.len() as u64 {
            0 => cycle_costs::REPLY - cycle_costs::REPLY_EMPTY,
            bytes => cycle_costs::REPLY + cycle_costs::REPLY_BYTE * (bytes - 1),
        };
        self.enter(Stage::QueueReply, now + cost)
    }

    fn reply_position(&mut self, now: u64) -> Option<Action> {
        let position = (self.control.position as u16).to_be_bytes();
        self.build_reply(now + cycle_costs::POSITION, &position)
    }

    fn end_message(&mut self, now: u64) -> Option<Action> {
        self.enter(Stage::MessageDone, now)
    }

    /// Executes the command of the message, or tracks the order of the other servos.
    fn dispatch(&mut self, now: u64) -> Option<Action> {
        let [destination, source, command] = [self.scratch[0], self.scratch[1], self.scratch[2]];
        let left = u16::from(self.message_length).wrapping_sub(4);
        if destination == BROADCAST {
            match command {
                START => {
                    self.master = source;
                    self.cycle_state = CycleState::AwaitingSlot;
                    self.predecessor = 0;
                    self.delay_ticks = u16::from(self.id) * SLOT_TICKS;
                    self.end_message(now + cycle_costs::START)
                }
                WRITE => self.write(now, left, false),
                SYNC_WRITE => self.sync_write(now),
                CYCLE => self.cycle(now, source),
                RESET => self.reset(now, false),
                _ => {
                    self.master = source;
                    self.build_reply(now - cycle_costs::REFUSED_BROADCAST, &[REFUSED])
                }
            }
        } else if destination == self.id {
            self.master = source;
            match command {
                WRITE => self.write(now, left, true),
                READ => self.read(now),
                PING => self.build_reply(now, &[PING]),
                RESET => self.reset(now, true),
                _ => self.build_reply(now, &[REFUSED]),
            }
        } else if source == self.predecessor {
            if self.cycle_state == CycleState::Member && self.cycle_pending {
                self.cycle_pending = false;
                return self.reply_position(now);
            }
            self.end_message(now)
        } else {
            if self.cycle_state == CycleState::AwaitingSlot {
                self.predecessor = source;
                self.predecessors = self.predecessors.wrapping_add(1);
                return self.end_message(now - cycle_costs::PREDECESSOR_LEARNT);
            }
            self.end_message(now)
        }
    }

    fn cycle(&mut self, now: u64, source: u8) -> Option<Action> {
        let now = now + cycle_costs::CYCLE;
        if self.cycle_state != CycleState::Member {
            return self.end_message(now + cycle_costs::CYCLE_IGNORED);
        }
        self.master = source;
        if self.predecessor == 0 {
            self.cycle_pending = false;
            return self.reply_position(now);
        }
        self.cycle_pending = true;
        self.delay_ticks = FAILSAFE_TICKS
            .wrapping_mul(self.baud.into())
            .wrapping_mul(self.predecessors.into());
        self.end_message(now + cycle_costs::CYCLE_WAITS)
    }

    /// READ. Missing arguments of a packet are stale memory.
    fn read(&mut self, now: u64) -> Option<Action> {
        let mut arguments = [0; 2];
        if self.receiver.read(3, &mut arguments).is_some() {
            self.scratch[2..4].copy_from_slice(&arguments);
        }
        let [first, count] = [self.scratch[2], self.scratch[3]];
        if u16::from(first) + u16::from(count) > REGISTERS.into() {
            return self.build_reply(now + cycle_costs::READ_REFUSED, &[REFUSED]);
        }
        let mut cost = cycle_costs::READ;
        for i in 0..count {
            // Only the first address decides between EEPROM and the rest.
            let index = usize::from(4 + i);
            if first < ROM_REGISTERS {
                self.scratch[index] = registers::cell(&self.rom, first + i);
                cost += cycle_costs::READ_ROM_BYTE;
            } else if first < REGISTERS {
                self.scratch[index] = self.register(first + i);
                cost += cycle_costs::READ_BYTE;
            }
        }
        let data = self.scratch;
        self.build_reply(now + cost, &data[4..4 + usize::from(count)])
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
