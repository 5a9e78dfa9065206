//! Flash (section 3): wait states, prefetch, instruction and data cache; erasing and
//! programming.
//!
//! A read of 128 bits takes one cycle and the wait states. Instructions come from the
//! present line, from the cache of 64 lines, or from the next line that the prefetch unit
//! read meanwhile; data from their cache of 8 lines. All else waits. While a sector is
//! erased or a word programmed, every read waits for its end, and with it the core.

use std::collections::VecDeque;

use crate::time::Time;

/// First address.
pub const BASE: u32 = 0x0800_0000;
/// Erasing a sector of 128 kB, and of 16 kB: typical at 32 bits (data sheet, table 39).
const ERASE_LARGE: Time = Time::from_us(1_100_000);
const ERASE_SMALL: Time = Time::from_us(300_000);
/// Programming a word: typical.
const PROGRAM: Time = Time::from_us(16);

const KEYS: [u32; 2] = [0x4567_0123, 0xCDEF_89AB];
const OPTION_KEYS: [u32; 2] = [0x0819_2A3B, 0x4C5D_6E7F];
const CR_PG: u32 = 1;
const CR_SER: u32 = 1 << 1;
const CR_STRT: u32 = 1 << 16;
const CR_LOCK: u32 = 1 << 31;
const SR_EOP: u32 = 1;
const SR_WRPERR: u32 = 1 << 4;
const SR_PGSERR: u32 = 1 << 7;
const ACR_PRFTEN: u32 = 1 << 8;
const ACR_ICEN: u32 = 1 << 9;
const ACR_DCEN: u32 = 1 << 10;
const ACR_ICRST: u32 = 1 << 11;
const ACR_DCRST: u32 = 1 << 12;

/// Lines of the caches (section 3.5.2).
const INSTRUCTION_LINES: usize = 64;
const DATA_LINES: usize = 8;
/// No line.
const NONE: u32 = u32::MAX;

/// Lines of 128 bits by last use.
#[derive(Clone, Debug, Default)]
struct Cache {
    lines: VecDeque<u32>,
}

impl Cache {
    /// Whether a line is there; it is the latest then.
    fn find(&mut self, line: u32) -> bool {
        let found = self.lines.iter().position(|other| *other == line);
        if let Some(index) = found.filter(|index| *index != 0) {
            self.lines.remove(index);
            self.lines.push_front(line);
        }
        found.is_some()
    }

    fn insert(&mut self, line: u32, most: usize) {
        self.lines.truncate(most - 1);
        self.lines.push_front(line);
    }
}

/// Flash and its interface.
#[derive(Clone, Debug)]
pub struct Flash {
    bytes: Vec<u8>,
    access: u32,
    status: u32,
    control: u32,
    options: u32,
    keys: usize,
    option_keys: usize,
    is_option_unlocked: bool,
    busy_until: Time,
    /// Present line of instructions, and the one that prefetch reads, with its end in cycles.
    line: u32,
    next_line: u32,
    prefetched: u64,
    instructions: Cache,
    data: Cache,
    data_line: u32,
    erased: Vec<u32>,
    /// Content changed since it was last asked.
    is_changed: bool,
}

/// Option bytes as the chip comes: brown-out reset off, watchdog by software.
const OPTIONS: u32 = 0x0FFF_AAED;

impl Flash {
    /// Erased flash of a number of bytes.
    pub fn new(len: usize) -> Self {
        Self {
            bytes: vec![0xFF; len],
            access: 0,
            status: 0,
            control: CR_LOCK,
            options: OPTIONS,
            keys: 0,
            option_keys: 0,
            is_option_unlocked: false,
            busy_until: Time::ZERO,
            line: NONE,
            next_line: NONE,
            prefetched: 0,
            instructions: Cache::default(),
            data: Cache::default(),
            data_line: NONE,
            erased: Vec::new(),
            is_changed: true,
        }
    }

    /// Registers as after a reset; contents and option bytes stay.
    pub fn reset(&mut self) {
        let bytes = std::mem::take(&mut self.bytes);
        let options = self.options;
        let erased = std::mem::take(&mut self.erased);
        *self = Self {
            bytes,
            options,
            erased,
            ..Self::new(0)
        };
    }

    /// All bytes.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// All bytes, to be written by a programmer.
    pub fn bytes_mut(&mut self) -> &mut [u8] {
        self.is_changed = true;
        &mut self.bytes
    }

    /// Whether contents have changed since the last call.
    pub fn take_changed(&mut self) -> bool {
        std::mem::take(&mut self.is_changed)
    }

    /// Sectors that were erased so far, in order.
    pub fn erased(&self) -> &[u32] {
        &self.erased
    }

    /// Access control register: wait states and accelerator.
    pub fn access_control(&self) -> u32 {
        self.access
    }

    /// End of the operation in progress.
    pub fn busy_until(&self) -> Time {
        self.busy_until
    }

    fn wait_states(&self) -> u64 {
        u64::from(self.access & 0xF)
    }

    fn is_on(&self, bit: u32) -> bool {
        self.access & bit != 0
    }

    /// Cycles for which the core waits for an instruction at `offset`, at cycle `now`.
    pub fn fetch_stall(&mut self, now: u64, offset: u32) -> u64 {
        let line = offset / 16;
        if line == self.line {
            return 0;
        }
        let read = 1 + self.wait_states();
        let mut stall = self.wait_states();
        if line == self.next_line {
            stall = self.prefetched.saturating_sub(now).min(stall);
        } else if self.is_on(ACR_ICEN) {
            if self.instructions.find(line) {
                stall = 0;
            } else {
                self.instructions.insert(line, INSTRUCTION_LINES);
            }
        }
        self.line = line;
        if self.is_on(ACR_PRFTEN) {
            self.next_line = line + 1;
            self.prefetched = now + stall + read;
        }
        stall
    }

    /// Cycles for which the core waits for data at `offset`.
    pub fn data_stall(&mut self, offset: u32) -> u64 {
        let line = offset / 16;
        let is_there = if self.is_on(ACR_DCEN) {
            let is_there = self.data.find(line);
            if !is_there {
                self.data.insert(line, DATA_LINES);
            }
            is_there
        } else {
            std::mem::replace(&mut self.data_line, line) == line
        };
        if is_there { 0 } else { self.wait_states() }
    }

    /// Reads a register of the interface.
    pub fn read(&self, now: Time, offset: u32) -> Option<u32> {
        Some(match offset {
            0x00 => self.access,
            0x04 | 0x08 => 0,
            0x0C => self.status | u32::from(now < self.busy_until) << 16,
            0x10 => self.control,
            0x14 => self.options & !1 | u32::from(!self.is_option_unlocked),
            _ => return None,
        })
    }

    /// Writes a register of the interface; `None` if there is none.
    pub fn write(&mut self, now: Time, offset: u32, value: u32) -> Option<()> {
        match offset {
            0x00 => {
                if value & ACR_ICRST != 0 {
                    self.instructions = Cache::default();
                }
                if value & ACR_DCRST != 0 {
                    self.data = Cache::default();
                }
                self.access = value;
            }
            0x04 => {
                if next_key(&mut self.keys, KEYS, value) {
                    self.control &= !CR_LOCK;
                }
            }
            0x08 => {
                if next_key(&mut self.option_keys, OPTION_KEYS, value) {
                    self.is_option_unlocked = true;
                }
            }
            0x0C => self.status &= !value,
            0x10 if self.control & CR_LOCK != 0 => {}
            0x10 => {
                self.control = value & !CR_STRT;
                if value & (CR_STRT | CR_SER) == CR_STRT | CR_SER {
                    self.erase(now, value >> 3 & 0xF);
                }
            }
            0x14 if self.is_option_unlocked => {
                self.options = value & !2;
                self.is_option_unlocked = value & 1 == 0;
                if value & 2 != 0 {
                    self.busy_until = now + PROGRAM;
                }
            }
            0x14 => {}
            _ => return None,
        }
        Some(())
    }

    fn erase(&mut self, now: Time, sector: u32) {
        let (begin, len) = sector_range(sector);
        let Some(bytes) = self.bytes.get_mut(begin..begin + len) else {
            self.status |= SR_WRPERR;
            return;
        };
        bytes.fill(0xFF);
        self.erased.push(sector);
        self.is_changed = true;
        self.busy_until = now
            + if len > 16 * 1_024 {
                ERASE_LARGE
            } else {
                ERASE_SMALL
            };
        self.status |= SR_EOP;
    }

    /// Programs bytes at `offset`: bits can only be cleared.
    pub fn program(&mut self, now: Time, offset: usize, value: u32, len: usize) {
        if self.control & (CR_LOCK | CR_PG) != CR_PG {
            self.status |= SR_PGSERR;
            return;
        }
        let Some(bytes) = self.bytes.get_mut(offset..offset + len) else {
            self.status |= SR_WRPERR;
            return;
        };
        for (byte, new) in bytes.iter_mut().zip(value.to_le_bytes()) {
            *byte &= new;
        }
        self.is_changed = true;
        self.busy_until = self.busy_until.max(now) + PROGRAM;
        self.status |= SR_EOP;
    }
}

/// Takes the next key of a sequence; true after the last.
fn next_key(taken: &mut usize, keys: [u32; 2], value: u32) -> bool {
    *taken = if keys.get(*taken) == Some(&value) {
        *taken + 1
    } else {
        0
    };
    *taken == keys.len() && {
        *taken = 0;
        true
    }
}

/// Offset and length of a sector (table 5).
fn sector_range(sector: u32) -> (usize, usize) {
    const KIB: usize = 1_024;
    match sector as usize {
        small @ 0..=3 => (small * 16 * KIB, 16 * KIB),
        4 => (64 * KIB, 64 * KIB),
        large => ((large - 4) * 128 * KIB, 128 * KIB),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn caches_and_prefetch_hide_the_wait_states() {
        let mut flash = Flash::new(1 << 20);
        assert_eq!(flash.write(Time::ZERO, 0, 5), Some(()));
        // A loop of four lines, eight cycles each and its stalls.
        let run = |flash: &mut Flash, begin: u64| -> u64 {
            let mut now = begin;
            for step in 0..40 {
                now += 8 + flash.fetch_stall(now, 16 * (step % 4));
            }
            now - begin - 8 * 40
        };
        assert_eq!(run(&mut flash, 100), 5 * 40);
        assert_eq!(flash.write(Time::ZERO, 0, 5 | ACR_PRFTEN), Some(()));
        // The jump back alone waits.
        assert!(run(&mut flash, 1_000) <= 5 * 11);
        let all = 5 | ACR_PRFTEN | ACR_ICEN | ACR_DCEN;
        assert_eq!(flash.write(Time::ZERO, 0, all), Some(()));
        assert!(run(&mut flash, 2_000) <= 10);
        assert_eq!([flash.data_stall(64), flash.data_stall(68)], [5, 0]);
    }

    #[test]
    fn a_sector_is_erased_and_a_word_programmed_only_when_unlocked() {
        let mut flash = Flash::new(1 << 20);
        let at = Time::from_us;
        let offset = 0xC_0000;
        flash.program(at(0), offset, 0, 4);
        assert_eq!(flash.bytes()[offset], 0xFF);
        for (register, value) in [(4, KEYS[0]), (4, KEYS[1]), (0x10, CR_PG)] {
            assert_eq!(flash.write(at(1), register, value), Some(()));
        }
        flash.program(at(1), offset, 0x1234_5678, 4);
        assert_eq!(flash.bytes()[offset..offset + 4], [0x78, 0x56, 0x34, 0x12]);
        assert_eq!(flash.busy_until(), at(17));
        let erase = CR_SER | CR_STRT | 10 << 3;
        assert_eq!(flash.write(at(20), 0x10, erase), Some(()));
        assert_eq!((flash.bytes()[offset], flash.erased()), (0xFF, &[10][..]));
        assert_eq!(flash.busy_until(), at(20) + ERASE_LARGE);
    }
}
