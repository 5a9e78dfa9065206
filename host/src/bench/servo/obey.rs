//! The command interpreter.

use super::control::OFF;
use super::inbox::SYNC_WRITE;
use super::mcu::{Bus, Mcu, Stage};
use super::registers::{
    self, DEFAULT_ROM, MARKER, MARKER_VALID, POSITION_HIGH, POSITION_LOW, PWM_LOW, REGISTERS,
    RESTORE_ORDER, ROM_REGISTERS, SPEED, TEMPERATURE_HIGH, TEMPERATURE_LOW,
};
use super::{Action, costs};

const PING: u8 = 0x01;
const READ: u8 = 0x02;
const WRITE: u8 = 0x03;
const START: u8 = 0x06;
const CYCLE: u8 = 0x07;
const RESET: u8 = 0x09;
const OK: u8 = 0x04;
const REFUSED: u8 = 0x08;
const BROADCAST: u8 = 0xFF;

/// Ticks of a START slot, times the id.
const SLOT_TICKS: u16 = 100;
/// Ticks of CYCLE's fail-safe, times the baud register and the number of
/// packets seen while waiting for the slot.
const FAILSAFE_TICKS: u16 = 2;
/// No packet carries more data; a larger count is a runaway.
const LONGEST_DATA: u16 = 200;

/// A message that takes several stages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Job {
    /// Starting up.
    Boot,
    /// Nothing longer than one stage.
    None,
    /// A reply is being built.
    Reply,
    /// A reply outside any message is being built.
    Unasked,
    Write {
        /// Bytes left, as the firmware counts them: 16 bits, from -1 when the
        /// packet has no address.
        left: u16,
        /// Where the next byte is in the message.
        index: u8,
        /// The register it goes to.
        address: u8,
        sync: bool,
        answer: bool,
        rom_changed: bool,
    },
    /// Defaults are being restored on request.
    Reset { answer: bool },
}

impl Mcu {
    /// Caught in the loop of a WRITE without data.
    pub(super) fn runaway(&self) -> bool {
        self.runaway_turns > 0 || matches!(self.job, Job::Write { left, .. } if left > LONGEST_DATA)
    }

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
                return self.go(Stage::Obey, now + costs::ACCEPT);
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
                self.rom[usize::from(MARKER)] = 0;
                self.rom_ready = now + costs::ROM_WRITE;
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

    fn done(&mut self, now: u64) -> Option<Action> {
        self.job = Job::None;
        self.inbox.close();
        self.chain(now)
    }

    /// Sends unasked when its START slot or CYCLE's fail-safe has come.
    pub(super) fn chain(&mut self, now: u64) -> Option<Action> {
        if self.delay_ticks == 0 {
            if self.bus == Bus::Slot {
                self.bus = Bus::Member;
                self.job = Job::Unasked;
                return self.answer(now, &[PING]);
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
    fn answer(&mut self, now: u64, data: &[u8]) -> Option<Action> {
        let head = [data.len() as u8 + 2, self.master, self.id];
        let checked = || head.iter().chain(data);
        let checksum = checked().fold(0_u8, |sum, &byte| sum.wrapping_add(!byte));
        self.reply.push_back(0xAA);
        self.reply.extend(checked());
        self.reply.push_back(checksum);
        if self.job == Job::None {
            self.job = Job::Reply;
        }
        let mut cost = costs::REPLY + costs::REPLY_BYTE * data.len() as u64 - costs::REPLY_BYTE;
        if self.job == Job::Unasked {
            cost -= costs::REPLY_UNASKED;
        }
        self.go(Stage::Reply, now + cost)
    }

    fn answer_position(&mut self, now: u64) -> Option<Action> {
        let position = (self.control.position as u16).to_be_bytes();
        self.answer(now, &position)
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
                    self.ignore(now)
                }
                WRITE => self.write(now, left, false),
                SYNC_WRITE => self.sync_write(now),
                CYCLE => self.cycle(now, source),
                RESET => self.reset(now, false),
                _ => {
                    self.master = source;
                    self.answer(now, &[REFUSED])
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
            }
            self.ignore(now)
        }
    }

    fn cycle(&mut self, now: u64, source: u8) -> Option<Action> {
        if self.bus != Bus::Member {
            return self.ignore(now);
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
        self.ignore(now)
    }

    /// Arguments that the packet does not have are what was in memory.
    fn read(&mut self, now: u64) -> Option<Action> {
        let mut arguments = [0; 2];
        if self.inbox.read(3, &mut arguments).is_some() {
            self.scratch[2..4].copy_from_slice(&arguments);
        }
        let [first, count] = [self.scratch[2], self.scratch[3]];
        if u16::from(first) + u16::from(count) > REGISTERS.into() {
            return self.answer(now + costs::READ, &[REFUSED]);
        }
        let mut cost = costs::READ;
        for i in 0..count {
            // Only the first address decides between EEPROM and the rest.
            let place = usize::from(4 + i);
            if first < ROM_REGISTERS {
                self.scratch[place] = registers::cell(&self.rom, first + i);
                cost += costs::READ_ROM_BYTE;
            } else if first < REGISTERS {
                self.scratch[place] = self.register(first + i);
                cost += costs::READ_BYTE;
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

    fn write(&mut self, now: u64, left: u16, answer: bool) -> Option<Action> {
        let mut address = [0];
        if self.inbox.read(3, &mut address).is_some() {
            self.scratch[1] = address[0];
        }
        // With no address in the packet, the source stands in for it.
        let address = self.scratch[1];
        let last = i32::from(left as i16) + i32::from(address);
        if answer && last > REGISTERS.into() {
            return self.answer(now + costs::READ, &[REFUSED]);
        }
        self.job = Job::Write {
            left,
            index: 4,
            address,
            sync: false,
            answer,
            rom_changed: false,
        };
        self.go(Stage::Write, now + costs::WRITE)
    }

    fn sync_write(&mut self, now: u64) -> Option<Action> {
        let mut head = [0; 2];
        if self.inbox.read(3, &mut head).is_some() {
            self.scratch[..2].copy_from_slice(&head);
        }
        let [address, count] = [self.scratch[0], self.scratch[1]];
        let mut data = [0; 256];
        let data = &mut data[..usize::from(count)];
        if self.inbox.read(6, data).is_some() {
            let room = data.len().min(self.scratch.len() - 3);
            self.scratch[2..2 + room].copy_from_slice(&data[..room]);
        }
        self.inbox.close();
        self.job = Job::Write {
            left: count.into(),
            index: 2,
            address,
            sync: true,
            answer: false,
            rom_changed: false,
        };
        self.go(Stage::Write, now + costs::SYNC_WRITE)
    }

    /// One byte of a WRITE or SYNC_WR.
    fn write_next(&mut self, now: u64) -> Option<Action> {
        let Job::Write {
            left,
            index,
            address,
            sync,
            answer,
            rom_changed,
        } = self.job
        else {
            return self.done(now);
        };
        if left == 0 {
            self.runaway_turns = 0;
            return self.go(Stage::Settle, now);
        }
        if sync {
            self.scratch[0] = self.scratch[usize::from(index)];
        } else {
            let mut byte = [0];
            if self.inbox.read(index, &mut byte).is_some() {
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
            let at = self.rom_ready.max(now + costs::ROM_CALL);
            return self.go(Stage::Store { address, value }, at);
        }
        if !to_rom && address < REGISTERS {
            self.requests.write(address, value);
        }
        self.next_byte(now)
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
            return self.done(now);
        };
        if *sync {
            return self.go(Stage::Write, now + costs::SYNC_WRITE_BYTE);
        }
        if *left <= LONGEST_DATA {
            return self.go(Stage::Write, now + costs::WRITE_BYTE);
        }
        if *address < REGISTERS || self.inbox.is_open() || self.inbox.waiting() {
            return self.go(Stage::Write, now + costs::RUNAWAY_TURN);
        }
        // Nothing can happen until the count runs out: one long stage.
        let turns = *left;
        *index = index.wrapping_add(turns as u8);
        *left = 0;
        self.runaway_turns = turns;
        self.go(Stage::Write, now + u64::from(turns) * costs::RUNAWAY_TURN)
    }

    /// A message that arrives during a runaway is eaten by it.
    pub(super) fn cut_runaway(&mut self, now: u64) {
        let Job::Write { left, index, .. } = &mut self.job else {
            return;
        };
        if self.runaway_turns == 0 || !self.inbox.waiting() {
            return;
        }
        let turns = self.stage_end.saturating_sub(now) / costs::RUNAWAY_TURN;
        *left = turns as u16;
        *index = index.wrapping_sub(turns as u8);
        self.stage_end -= turns * costs::RUNAWAY_TURN;
        self.runaway_turns = 0;
    }

    fn store(&mut self, now: u64, address: u8, value: u8) -> Option<Action> {
        if let Some(cell) = self.rom.get_mut(usize::from(address)) {
            *cell = value;
            self.rom_ready = now + costs::ROM_WRITE;
        }
        self.next_byte(now)
    }

    /// A new goal wins over a new PWM, and sets the remembered PWM to 1000
    /// even when the goal is refused.
    fn settle(&mut self, now: u64) -> Option<Action> {
        let requests = &mut self.requests;
        if requests.goal != requests.goal_before {
            requests.goal_before = requests.goal;
            self.control
                .set_goal(requests.goal, requests.speed, &self.gains);
            requests.pwm = OFF;
            requests.pwm_before = OFF;
            requests.pwm_sync = OFF;
        }
        if requests.pwm != requests.pwm_before {
            self.control.set_pwm(requests.pwm);
            requests.pwm_before = requests.pwm;
            requests.pwm_sync = requests.pwm;
            requests.goal = 0;
            requests.goal_before = 0;
        }
        match self.job {
            Job::Write {
                rom_changed: true, ..
            } => {
                let at = self.rom_ready.max(now + costs::ROM_CALL);
                self.go(Stage::Load { restored: 0 }, at)
            }
            Job::Write { answer: true, .. } => self.answer(now, &[OK]),
            _ => self.done(now),
        }
    }

    fn reset(&mut self, now: u64, answer: bool) -> Option<Action> {
        self.job = Job::Reset { answer };
        self.go(Stage::Reset, now + costs::ROM_CALL)
    }

    fn load(&mut self, now: u64, restored: usize) -> Option<Action> {
        let valid = self.rom[usize::from(MARKER)] == MARKER_VALID;
        match RESTORE_ORDER.get(restored) {
            Some(&address) if restored > 0 || !valid => {
                let place = usize::from(address);
                self.rom[place] = DEFAULT_ROM[place];
                self.rom_ready = now + costs::ROM_WRITE;
                let restored = restored + 1;
                self.go(Stage::Load { restored }, self.rom_ready)
            }
            _ => self.go(Stage::Loaded, now + costs::ROM_LOAD),
        }
    }

    fn loaded(&mut self, now: u64) -> Option<Action> {
        self.load_variables();
        self.uart.set_up(now, self.baud);
        match self.job {
            Job::Boot => self.go(Stage::Look, now),
            Job::Write { answer: true, .. } => self.answer(now, &[OK]),
            Job::Reset { answer: true } => self.answer(now, &[PING]),
            _ => self.done(now),
        }
    }
}
