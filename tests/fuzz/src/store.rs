//! Settings in flash: scripts of saves, boots, power cuts and damage.
//!
//! | byte, modulo 6 | with                  | what happens                        |
//! |----------------|-----------------------|-------------------------------------|
//! | 0              | number                | these settings are saved            |
//! | 1              | saves                 | a boot, with room for one or two    |
//! | 2              | number, step u16, mask | a save in which power goes         |
//! | 3              | saves, step u16, mask | a boot in which power goes          |
//! | 4              | at u16, mask          | bits of a byte flip                 |
//! | 5              | at u16, length, bytes | bytes are replaced                  |
//!
//! A step is a word programmed or a page erased. In the one in which power goes,
//! the mask has the bits that stay unprogrammed, or are erased already.

use armbridge_board::store::memory::Memory;
use armbridge_board::store::{PrepareError, SaveError, Store};
use armbridge_link::message::{Settings, SettingsFrom};
use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};

/// Room for four saves: pages change often.
const PAGE: usize = 1_280;

/// Runs the script, and counts how often saved settings are in force.
///
/// # Panics
/// If settings change or are lost without damage, or are in force without having
/// been saved; if a save erases, or there is no room for one that a boot has
/// made room for.
pub fn check(input: &[u8]) -> usize {
    let mut board = Board {
        store: Store::new(Flash::blank()),
        in_force: (Settings::default(), SettingsFrom::Default),
        was_saved: [false; 256],
        is_damaged: false,
    };
    let mut script = input.iter().copied();
    let mut found = 0;
    while board.step(&mut script).is_some() {
        found += usize::from(board.in_force.1 == SettingsFrom::Saved);
    }
    found
}

/// Settings that differ by this number.
fn settings(number: u8) -> Settings {
    let mut settings = Settings::default();
    settings.setup.period_us = 1_000 + u32::from(number);
    settings.limits.silence_ms = 600 + u16::from(number);
    settings
}

struct Board {
    store: Store<Flash>,
    in_force: (Settings, SettingsFrom),
    was_saved: [bool; 256],
    /// By more than power cuts: saved settings may be lost.
    is_damaged: bool,
}

impl Board {
    /// Next step; `None` at the end of the script.
    fn step(&mut self, script: &mut impl Iterator<Item = u8>) -> Option<()> {
        let kind = script.next()? % 6;
        match kind {
            0 => self.save(script.next()?, None),
            1 => self.boot(script.next()?, None),
            2 => self.save(script.next()?, Some(PowerCut::read(script)?)),
            3 => self.boot(script.next()?, Some(PowerCut::read(script)?)),
            4 => {
                let at = usize::from(number(script)?);
                let mask = script.next()?;
                self.damage(|bytes| bytes[at % (2 * PAGE)] ^= mask);
            }
            _ => {
                let at = usize::from(number(script)?) % (2 * PAGE);
                let length = usize::from(script.next()?);
                self.damage(|bytes| {
                    let cells = bytes[at..].iter_mut().take(length);
                    cells.zip(script).for_each(|(cell, byte)| *cell = byte);
                });
            }
        }
        Some(())
    }

    fn save(&mut self, number: u8, cut: Option<PowerCut>) {
        let new = (settings(number), SettingsFrom::Saved);
        let before = self.in_force;
        self.was_saved[usize::from(number)] = true;
        let result = self.powered(cut, |store| {
            let result = store.save(&new.0);
            assert!(!store.flash().is_erasing, "a save erases");
            result
        });
        let found = self.look();
        match result {
            Ok(()) => assert_eq!(found, new),
            Err(SaveError::Full) => assert_eq!(found, before),
            Err(error) => {
                // Damage may look like the beginning of a record.
                assert!(cut.is_some() || self.is_damaged, "{error:?}");
                let is_first = before.1 == SettingsFrom::Default;
                let is_begun = is_first && found == (before.0, SettingsFrom::Damaged);
                let is_either = found == before || found == new;
                assert!(is_either || is_begun || self.is_damaged, "{found:?}");
            }
        }
    }

    fn boot(&mut self, saves: u8, cut: Option<PowerCut>) {
        let saves = 1 + u32::from(saves % 2);
        let before = self.in_force;
        let result = self.powered(cut, |store| store.prepare(saves));
        let found = self.look();
        assert!(found == before || self.is_damaged, "{found:?}");
        match result {
            Ok(()) => {
                assert_eq!(found, before);
                self.has_room(saves);
            }
            Err(PrepareError::Flash(_)) => assert!(cut.is_some()),
            Err(error) => assert!(self.is_damaged, "{error:?}"),
        }
    }

    /// Number of saves that would work.
    fn has_room(&mut self, saves: u32) {
        let mut store = Store::new(self.store.flash().clone());
        for _ in 0..saves {
            let result = store.save(&settings(0));
            let is_harmed = self.is_damaged && result == Err(SaveError::Mismatch);
            assert!(result.is_ok() || is_harmed, "{result:?}");
        }
    }

    fn damage(&mut self, damage: impl FnOnce(&mut [u8])) {
        self.is_damaged = true;
        damage(&mut self.store.flash().memory.0);
        self.look();
    }

    /// Performs this with power until the cut.
    fn powered<T>(&mut self, cut: Option<PowerCut>, run: impl FnOnce(&mut Store<Flash>) -> T) -> T {
        self.store.flash().cut = cut;
        self.store.flash().is_erasing = false;
        let result = run(&mut self.store);
        self.store.flash().cut = None;
        result
    }

    /// Result of a boot now.
    fn look(&mut self) -> (Settings, SettingsFrom) {
        let found = self.store.load(|_| true);
        match found.1 {
            SettingsFrom::Saved => {
                let is_known = |number: u8| self.was_saved[usize::from(number)];
                let mut numbers = (0..=u8::MAX).filter(|number| is_known(*number));
                assert!(numbers.any(|number| settings(number) == found.0));
            }
            SettingsFrom::Default | SettingsFrom::Damaged => {
                assert_eq!(found.0, Settings::default());
            }
            _ => panic!("{found:?}"),
        }
        self.in_force = found;
        found
    }
}

fn number(script: &mut impl Iterator<Item = u8>) -> Option<u16> {
    Some(u16::from_le_bytes([script.next()?, script.next()?]))
}

/// When power goes.
#[derive(Clone, Copy)]
struct PowerCut {
    /// In this step, counting from 0.
    step: usize,
    mask: u8,
}

impl PowerCut {
    fn read(script: &mut impl Iterator<Item = u8>) -> Option<Self> {
        Some(Self {
            // Both pages full, and some.
            step: usize::from(number(script)?) % 600,
            mask: script.next()?,
        })
    }
}

/// Flash whose power may go.
#[derive(Clone)]
struct Flash {
    memory: Memory<Vec<u8>, PAGE>,
    cut: Option<PowerCut>,
    is_erasing: bool,
}

impl Flash {
    fn blank() -> Self {
        Self {
            memory: Memory(vec![0xFF; 2 * PAGE]),
            cut: None,
            is_erasing: false,
        }
    }

    /// Goes on to the next step; the mask, if it is cut.
    fn next(&mut self) -> Option<u8> {
        match &mut self.cut {
            Some(PowerCut { step: 0, mask }) => Some(*mask),
            Some(cut) => {
                cut.step -= 1;
                None
            }
            None => None,
        }
    }
}

impl ErrorType for Flash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        self.memory.read(offset, bytes)
    }

    fn capacity(&self) -> usize {
        self.memory.capacity()
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = PAGE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        self.is_erasing = true;
        let Some(mask) = self.next() else {
            return self.memory.erase(from, to);
        };
        for cell in &mut self.memory.0[from as usize..to as usize] {
            *cell |= mask;
        }
        Err(NorFlashErrorKind::Other)
    }

    fn write(&mut self, mut offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        for word in bytes.chunks(4) {
            if let Some(mask) = self.next() {
                let word: Vec<u8> = word.iter().map(|byte| byte | mask).collect();
                self.memory.write(offset, &word)?;
                return Err(NorFlashErrorKind::Other);
            }
            self.memory.write(offset, word)?;
            offset += 4;
        }
        Ok(())
    }
}
