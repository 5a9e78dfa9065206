//! Settings in flash: kept across power-off, whenever that comes.
//!
//! Flash is two pages ([`NorFlash::ERASE_SIZE`] each). One is a log to which each
//! save appends the settings and then, when they have been read back, a receipt;
//! the other has a mark alone. `page` keeps a log, `record` defines its entries, and
//! [`memory`] is a replacement for flash.
//!
//! # When pages are erased
//!
//! Only in [`Store::prepare`], which a board calls at boot, before its watchdog
//! runs: on an STM32F405 erasing a page of 128 kB stops the processor for 1 to 2 s,
//! programming a word for 16 µs (its data sheet, flash memory programming). It makes
//! room for a number of saves, and [`Store::save`] never erases: a board that is
//! saved to more often reports it, until it is reset.
//!
//! # When power goes
//!
//! A word that was being written may hold anything after it, and so may a page that
//! was being erased. The storage crate alone would not do: as a map over two pages
//! it looks for the place of a page in the order by marks in it, and one that was
//! half erased may still have them.
//!
//! * While saving: the settings are there as a whole or not at all, and those
//!   before them are untouched.
//! * While moving to the other page, when one is full: settings are written there
//!   as a new generation, before the old page is erased. A page is erased only
//!   while the other holds all that counts.
//!
//! # When a page is lost
//!
//! The mark, a receipt of generation 0, is what shows that settings had been saved if the log is
//! erased as a whole. Only a flash of which both pages are erased is that of a new board.
//!
//! # What is in force after it
//!
//! The newest intact settings, unless there is a receipt for newer ones: those
//! were damaged later, and going back to older ones unnoticed could mean limits
//! that have been made tighter since. Then, and whenever nothing intact is
//! found in pages that are not blank, the defaults are in force, and
//! [`SettingsFrom`] reports it until settings are saved again; the board does not arm before.
//! Of another version's settings those groups are in force whose encoding is the same.
//!
//! # Example
//!
//! Settings in RAM that behaves like flash, before and after a reset:
//!
//! ```
//! use armbridge_board::tick::can_run;
//! use armbridge_board::store::{Store, memory::Memory};
//! use armbridge_link::message::{Settings, SettingsFrom};
//!
//! const PAGE: usize = 4_096;
//! let mut flash = [0xFF; 2 * PAGE];
//!
//! let mut store = Store::new(Memory::<_, PAGE>(&mut flash));
//! store.prepare(1).unwrap();
//! assert_eq!(store.load(can_run), (Settings::default(), SettingsFrom::Default));
//! let mut settings = Settings::default();
//! settings.limits.torque_nm = [0.5, 0.3];
//! store.save(&settings).unwrap();
//!
//! let mut store = Store::new(Memory::<_, PAGE>(&mut flash));
//! assert_eq!(store.load(can_run), (settings, SettingsFrom::Saved));
//! // Of settings with which a board cannot run, the defaults are in force.
//! assert_eq!(store.load(|_| false), (Settings::default(), SettingsFrom::Refused));
//! ```

pub mod memory;
mod page;
mod record;
#[cfg(test)]
mod tests;

use armbridge_link::message::{Settings, SettingsFrom};
use embedded_storage::nor_flash::{NorFlash, NorFlashErrorKind};
use page::{FlashError, Page, PageScan};
use record::{
    Bytes, Malformed, RECEIPT_LEN, Record, SETTINGS_MAX, encode_receipt, encode_settings, renumber,
};

/// Generation of a receipt without settings: the settings that had been saved are in the other
/// page. Those of settings count from 1.
const MARK: u32 = 0;

/// Settings in the first two pages of this flash.
#[derive(Debug)]
pub struct Store<F> {
    flash: F,
}

/// Why there is no room for saves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PrepareError {
    /// Two pages, or this many saves in one, are more than there is.
    TooSmall,
    /// The flash reports an error.
    Flash(NorFlashErrorKind),
    /// The flash does not keep what is written, or does not get erased.
    Worn,
}

/// Why settings were not saved. Those before are still in force after a reset,
/// except that an error of the flash may come after the new ones are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SaveError {
    /// There is no room without erasing: reset the board.
    Full,
    /// The flash reports an error.
    Flash(NorFlashErrorKind),
    /// The written record does not read back.
    Mismatch,
}

impl From<FlashError> for PrepareError {
    fn from(error: FlashError) -> Self {
        match error {
            FlashError::Driver(kind) => Self::Flash(kind),
            FlashError::Full => Self::TooSmall,
            FlashError::Mismatch => Self::Worn,
        }
    }
}

impl From<FlashError> for SaveError {
    fn from(error: FlashError) -> Self {
        match error {
            FlashError::Driver(kind) => Self::Flash(kind),
            FlashError::Full => Self::Full,
            FlashError::Mismatch => Self::Mismatch,
        }
    }
}

impl<F: NorFlash> Store<F> {
    /// Bytes of a page that one save takes at most.
    const COST: u32 = Page::<F>::cost(SETTINGS_MAX) + Page::<F>::cost(RECEIPT_LEN);
    /// Bytes of a mark.
    const MARK_COST: u32 = Page::<F>::cost(RECEIPT_LEN);

    /// Settings in this flash, which is not touched yet.
    pub const fn new(flash: F) -> Self {
        Self { flash }
    }

    /// The flash.
    pub fn flash(&mut self) -> &mut F {
        &mut self.flash
    }

    /// Makes room for this many saves, and completes what power-off interrupted. May
    /// erase both pages. Does not change what [`Store::load`] finds.
    ///
    /// # Errors
    /// [`PrepareError`]; settings can be loaded all the same.
    pub fn prepare(&mut self, saves: u32) -> Result<(), PrepareError> {
        let mut needed = saves.saturating_mul(Self::COST);
        // Beside them there are the settings in force, after a mark.
        let most = Page::<F>::ROOM.saturating_sub(Self::COST + Self::MARK_COST);
        if self.flash.capacity() < 2 * F::ERASE_SIZE || most < needed {
            return Err(PrepareError::TooSmall);
        }
        let Some(log) = self.log()? else {
            return Ok(());
        };
        let spare = 1 - log.page;
        if log.spare != Spare::Marked {
            if log.spare == Spare::Used {
                self.page(spare).erase()?;
            }
            self.append_receipt(spare, MARK)?;
        }
        let settings = log.scan.in_force();
        let unreceipted = settings.filter(|generation| log.scan.receipt < Some(*generation));
        if unreceipted.is_some() {
            needed += Page::<F>::cost(RECEIPT_LEN);
        }
        if log.scan.room >= needed {
            return match unreceipted {
                Some(generation) => Ok(self.append_receipt(log.page, generation)?),
                None => Ok(()),
            };
        }
        let generation = log.next_generation();
        if let Some(last) = settings {
            let mut record = self.page(log.page).settings(last)?;
            renumber(&mut record, generation);
            self.append(spare, &record)?;
        }
        self.append_receipt(spare, generation)?;
        self.page(log.page).erase()?;
        Ok(self.append_receipt(log.page, MARK)?)
    }

    /// The settings to begin with, and where they come from. Changes nothing.
    ///
    /// `accept` decides whether a program can run with them.
    pub fn load(&mut self, accept: impl FnOnce(&Settings) -> bool) -> (Settings, SettingsFrom) {
        let from = match self.in_force() {
            Ok(None) => SettingsFrom::Default,
            Ok(Some(bytes)) => match Record::read(&bytes).map(|r| r.settings()) {
                Some(Ok((settings, lost))) => {
                    let from = if lost.is_empty() {
                        SettingsFrom::Saved
                    } else {
                        SettingsFrom::OtherVersion { lost }
                    };
                    if accept(&settings) {
                        return (settings, from);
                    }
                    SettingsFrom::Refused
                }
                Some(Err(Malformed)) | None => SettingsFrom::Damaged,
            },
            Err(_) => SettingsFrom::Unreadable,
        };
        (Settings::default(), from)
    }

    /// Keeps these settings. Programs some sixty words, and never erases. What is
    /// there already is not written again: a command to save may be repeated.
    ///
    /// # Errors
    /// [`SaveError`].
    pub fn save(&mut self, settings: &Settings) -> Result<(), SaveError> {
        let log = self.log()?;
        let last = log
            .as_ref()
            .and_then(|log| log.scan.generation())
            .unwrap_or(0);
        let mut record = encode_settings(settings, last).ok_or(SaveError::Full)?;
        let (page, room, generation, spare) = match log {
            Some(log) => {
                let is_receipted = log.scan.in_force() == log.scan.receipt;
                if is_receipted && self.page(log.page).holds(&record)? {
                    return Ok(());
                }
                (log.page, log.scan.room, log.next_generation(), log.spare)
            }
            None => (0, Page::<F>::ROOM, 1, Spare::Blank),
        };
        if room < Self::COST {
            return Err(SaveError::Full);
        }
        renumber(&mut record, generation);
        self.append(page, &record)?;
        self.append_receipt(page, generation)?;
        if spare == Spare::Blank {
            self.append_receipt(1 - page, MARK)?;
        }
        Ok(())
    }

    /// The record of the settings in force, empty if nothing intact is; `None` in a flash whose
    /// pages are both erased.
    fn in_force(&mut self) -> Result<Option<Bytes>, FlashError> {
        let Some(log) = self.log()? else {
            return Ok(None);
        };
        match log.scan.in_force() {
            Some(generation) => Ok(Some(self.page(log.page).settings(generation)?)),
            None => Ok(Some(Bytes::new())),
        }
    }

    /// The page in use: the one with the highest generation or, where there is
    /// none, one that is not blank.
    fn log(&mut self) -> Result<Option<Log>, FlashError> {
        let (first, second) = (self.page(0).scan()?, self.page(1).scan()?);
        if first.is_blank && second.is_blank {
            return Ok(None);
        }
        let is_second = first.is_blank || first.generation() < second.generation();
        let (scan, other) = if is_second {
            (second, first)
        } else {
            (first, second)
        };
        let is_mark = other.receipt == Some(MARK) && other.settings.is_none();
        let spare = if other.is_blank {
            Spare::Blank
        } else if is_mark && other.room == Page::<F>::ROOM.saturating_sub(Self::MARK_COST) {
            Spare::Marked
        } else {
            Spare::Used
        };
        Ok(Some(Log {
            page: u32::from(is_second),
            scan,
            spare,
        }))
    }

    fn page(&mut self, number: u32) -> Page<'_, F> {
        Page::new(&mut self.flash, number)
    }

    fn append_receipt(&mut self, page: u32, generation: u32) -> Result<(), FlashError> {
        self.append(page, &encode_receipt(generation))
    }

    /// Appends a record, and reads it back.
    fn append(&mut self, page: u32, record: &[u8]) -> Result<(), FlashError> {
        self.page(page).append(record)?;
        if self.page(page).holds(record)? {
            Ok(())
        } else {
            Err(FlashError::Mismatch)
        }
    }
}

/// The page in use.
struct Log {
    /// Its number.
    page: u32,
    scan: PageScan,
    spare: Spare,
}

/// Contents of the page that is not in use.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Spare {
    Blank,
    /// A mark alone.
    Marked,
    /// A log that is out of use, or what power-off left of one.
    Used,
}

impl Log {
    fn next_generation(&self) -> u32 {
        let last = self.scan.generation();
        last.map_or(1, |generation| generation.saturating_add(1))
    }
}
