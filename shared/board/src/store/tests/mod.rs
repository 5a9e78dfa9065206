//! Power cut everywhere, damage everywhere.

extern crate std;

mod power;

use super::memory::Memory;
use super::page::Page;
use super::record::{encode_settings, renumber};
use super::{PrepareError, SaveError, Store};
use crate::bridge::can_run;
use armbridge_link::message::{Settings, SettingsFrom, SettingsGroups};
use embedded_storage::nor_flash::NorFlashErrorKind;
use power::{Step, Traced, cut, take};
use std::vec;
use std::vec::Vec;

/// Room for some saves, so that pages change often.
const PAGE: usize = 1_536;
/// Every how many places are tried: an interpreter takes a second for each boot.
const STRIDE: usize = if cfg!(miri) { 31 } else { 1 };

type Flash = Memory<Vec<u8>, PAGE>;

fn blank() -> Flash {
    Memory(vec![0xFF; 2 * PAGE])
}

/// Settings that differ.
fn settings(number: u32) -> Settings {
    let mut settings = Settings::default();
    settings.setup.period_us = 1_000 + number;
    settings.limits.torque_nm = [0.2 + number as f32 * 0.01; 2];
    settings
}

fn load(flash: &Flash) -> (Settings, SettingsFrom) {
    Store::new(flash.clone()).load(|_| true)
}

/// Xorshift: varied, the same on every machine.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 >> 11
    }

    fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit as u64) as usize
    }

    fn byte(&mut self) -> u8 {
        self.next() as u8
    }
}

/// Steps of a run, and their number at the beginning and at the end of each save.
fn run(saves: u32) -> (Vec<Step>, Vec<(usize, usize)>) {
    let mut store = Store::new(Traced::new(blank()));
    let mut spans = Vec::new();
    for number in 1..=saves {
        store.prepare(1).unwrap();
        let begin = store.flash.steps.len();
        store.save(&settings(number)).unwrap();
        spans.push((begin, store.flash.steps.len()));
    }
    (core::mem::take(&mut store.flash.steps), spans)
}

#[test]
fn a_cut_leaves_the_old_or_the_new() {
    /// Pages change twice.
    const SAVES: u32 = if cfg!(miri) { 1 } else { 12 };
    let (steps, spans) = run(SAVES);
    let erases = steps.iter().filter(|step| matches!(step, Step::Erase(_)));
    assert!(erases.count() >= 2 || cfg!(miri), "there and back");
    let mut random = Random(0x5EED);
    let mut flash = blank();
    let mut tried = 0;
    for (taken, step) in steps.iter().enumerate() {
        let done = spans.iter().filter(|(_, end)| *end <= taken).count() as u32;
        let begun = spans.iter().filter(|(begin, _)| *begin <= taken).count() as u32;
        if taken.is_multiple_of(STRIDE) || matches!(step, Step::Erase(_)) {
            for after in cut(&flash, *step, &mut random) {
                tried += 1;
                let found = load(&after);
                if done == 0 && found.1 != SettingsFrom::Saved {
                    // The very first save was cut short.
                    assert_eq!(found.0, Settings::default());
                } else {
                    let allowed = [settings(done), settings(begun)];
                    assert!(allowed.contains(&found.0), "step {taken}: {found:?}");
                    assert_eq!(found.1, SettingsFrom::Saved, "step {taken}");
                }
                recovers(&after, taken, &mut random);
            }
        }
        take(&mut flash, *step);
    }
    assert_eq!(load(&flash), (settings(SAVES), SettingsFrom::Saved));
    assert!(tried > if cfg!(miri) { 10 } else { 5_000 }, "{tried}");
}

/// The next boot changes nothing of what is in force, whenever power goes again,
/// and a save works.
fn recovers(flash: &Flash, taken: usize, random: &mut Random) {
    let found = load(flash);
    let mut store = Store::new(Traced::new(flash.clone()));
    store.prepare(1).unwrap();
    assert_eq!(store.load(|_| true), found, "step {taken}");

    let steps = core::mem::take(&mut store.flash.steps);
    let mut between = flash.clone();
    for (i, step) in steps.iter().enumerate() {
        // Erasing is where most can go wrong; of words a few.
        if matches!(step, Step::Erase(_)) || (i + taken).is_multiple_of(199 * STRIDE) {
            for after in cut(&between, *step, random) {
                assert_eq!(load(&after), found, "step {taken}, {i}");
                let mut store = Store::new(after);
                store.prepare(1).unwrap();
                assert_eq!(store.load(|_| true), found, "step {taken}, {i}");
            }
        }
        take(&mut between, *step);
    }

    store.save(&settings(99)).unwrap();
    let saved = (settings(99), SettingsFrom::Saved);
    assert_eq!(store.load(|_| true), saved, "step {taken}");
    let erased = store
        .flash
        .steps
        .iter()
        .any(|step| matches!(step, Step::Erase(_)));
    assert!(!erased, "erased while running");
}

#[test]
#[cfg_attr(miri, ignore = "takes an interpreter too long")]
fn damage_is_reported_or_harmless() {
    let mut random = Random(0xDA_4A6E);
    let mut counts = [0; 2];
    for _ in 0..3_000 {
        let mut store = Store::new(blank());
        let saves = 1 + random.below(9) as u32;
        for number in 1..=saves {
            store.prepare(1).unwrap();
            store.save(&settings(number)).unwrap();
        }
        let mut flash = store.flash;
        for _ in 0..=random.below(3) {
            let at = random.below(flash.0.len());
            let most = [4, PAGE][random.below(2)];
            let len = random.below(most);
            let end = (at + len + 1).min(flash.0.len());
            let byte = random.byte();
            match random.below(4) {
                0 => flash.0[at] ^= 1 << random.below(8),
                1 => flash.0[at..end].fill(0xFF),
                2 => flash.0[at..end].fill(byte),
                _ => flash.0[at..end].fill_with(|| random.byte()),
            }
        }
        let found = load(&flash);
        match found.1 {
            SettingsFrom::Saved => {
                counts[0] += 1;
                assert!((1..=saves).any(|number| found.0 == settings(number)));
            }
            SettingsFrom::Damaged | SettingsFrom::Default => {
                counts[1] += 1;
                assert_eq!(found.0, Settings::default());
            }
            _ => panic!("{found:?}"),
        }
        let mut store = Store::new(flash);
        store.prepare(1).unwrap();
        assert_eq!(store.load(|_| true), found);
        store.save(&settings(99)).unwrap();
        assert_eq!(store.load(|_| true), (settings(99), SettingsFrom::Saved));
    }
    assert!(counts.iter().all(|count| *count > 3), "{counts:?}");
}

#[test]
fn damaged_settings_do_not_bring_back_older_ones() {
    let mut store = Store::new(Traced::new(blank()));
    store.save(&settings(1)).unwrap();
    let before = store.flash.steps.len();
    store.save(&settings(2)).unwrap();
    let Traced { mut flash, steps } = store.flash;
    let Some(Step::Word(at, _)) = steps.get(before + 10).copied() else {
        panic!("a word of the second record");
    };
    flash.0[at] ^= 4;
    let damaged = (Settings::default(), SettingsFrom::Damaged);
    assert_eq!(load(&flash), damaged);
    // Boot after boot, until something is saved; other pages or not.
    let mut store = Store::new(flash);
    for saves in [1, 3, 1] {
        store.prepare(saves).unwrap();
        assert_eq!(store.load(|_| true), damaged);
    }
    store.save(&settings(3)).unwrap();
    assert_eq!(store.load(|_| true), (settings(3), SettingsFrom::Saved));
}

/// A board that had settings does not take itself for a new one, whichever page is erased.
#[test]
fn a_page_that_is_erased_as_a_whole_is_damage() {
    let damaged = (Settings::default(), SettingsFrom::Damaged);
    let mut store = Store::new(blank());
    for number in 1..=12 {
        store.prepare(1).unwrap();
        store.save(&settings(number)).unwrap();
        let saved = (settings(number), SettingsFrom::Saved);
        let results = [0, PAGE].map(|from| {
            let mut flash = store.flash.clone();
            flash.0[from..from + PAGE].fill(0xFF);
            let found = load(&flash);
            // It stays so, and a save ends it.
            let mut store = Store::new(flash);
            store.prepare(1).unwrap();
            assert_eq!(store.load(|_| true), found, "save {number}");
            store.save(&settings(99)).unwrap();
            assert_eq!(store.load(|_| true), (settings(99), SettingsFrom::Saved));
            found
        });
        assert!(
            results.contains(&damaged) && results.contains(&saved),
            "save {number}: {results:?}"
        );
    }
    let blank = load(&blank());
    assert_eq!(blank, (Settings::default(), SettingsFrom::Default));
}

#[test]
fn as_many_saves_as_prepared_for_and_no_erasing() {
    let mut store = Store::new(Traced::new(blank()));
    let most = (1..PAGE as u32).find(|saves| store.prepare(*saves) == Err(PrepareError::TooSmall));
    let most = most.unwrap() - 1;
    for _ in 0..if cfg!(miri) { 1 } else { 3 } {
        store.prepare(most).unwrap();
        store.flash.steps.clear();
        let mut saved = 0;
        while store.save(&settings(saved + 1)).is_ok() {
            saved += 1;
        }
        assert!(saved >= most, "{saved} of {most}");
        let full = store.flash.steps.len();
        assert_eq!(store.save(&settings(0)), Err(SaveError::Full));
        assert_eq!(store.flash.steps.len(), full, "refused, not begun");
        let erased = store
            .flash
            .steps
            .iter()
            .any(|step| matches!(step, Step::Erase(_)));
        assert!(!erased);
        assert_eq!(store.load(|_| true), (settings(saved), SettingsFrom::Saved));
    }
}

#[test]
#[cfg_attr(miri, ignore = "a quarter of a megabyte, many times over")]
fn a_repeated_save_writes_nothing_and_a_log_stays_short() {
    const LARGE: usize = 128 * 1_024;
    let mut store = Store::new(Memory::<_, LARGE>(vec![0xFF; 2 * LARGE]));
    store.save(&settings(1)).unwrap();
    let before = store.flash.0.clone();
    store.save(&settings(1)).unwrap();
    assert_eq!(store.flash.0, before);
    let most = (2..1_000).find(|number| store.save(&settings(number % 7)).is_err());
    assert!((50..100).contains(&most.unwrap()), "{most:?}");
    store.prepare(1).unwrap();
    let used = store.flash.0[..LARGE].iter().filter(|byte| **byte != 0xFF);
    assert!(used.count() < 64, "a mark");
    store.save(&settings(8)).unwrap();
    assert_eq!(store.load(|_| true), (settings(8), SettingsFrom::Saved));
}

#[test]
fn what_is_not_for_this_program_is_not_used() {
    let mut store = Store::new(blank());
    assert_eq!(store.load(|_| true).1, SettingsFrom::Default);
    store.save(&settings(1)).unwrap();
    let refused = (Settings::default(), SettingsFrom::Refused);
    assert_eq!(store.load(|_| false), refused);
    let mut beyond = settings(2);
    beyond.limits.torque_nm[1] = f32::NAN;
    store.save(&beyond).unwrap();
    assert_eq!(store.load(can_run), refused);

    // Another version's settings are kept until this one saves its own.
    let mut record = encode_settings(&settings(3), 7).unwrap();
    record[0] += 1;
    renumber(&mut record, 7);
    let mut flash = store.flash;
    let mut page = Page::new(&mut flash, 0);
    page.append(&record).unwrap();
    let mut store = Store::new(flash);
    for saves in [1, 3] {
        store.prepare(saves).unwrap();
        let other = (
            Settings::default(),
            SettingsFrom::OtherVersion {
                lost: SettingsGroups::ALL,
            },
        );
        assert_eq!(store.load(|_| true), other);
    }
    store.save(&settings(4)).unwrap();
    assert_eq!(store.load(|_| true), (settings(4), SettingsFrom::Saved));
}

#[test]
fn flash_that_does_not_work_is_reported() {
    // Half of it is missing.
    let mut store = Store::new(Memory::<_, PAGE>(vec![0xFF; PAGE]));
    assert_eq!(store.prepare(1), Err(PrepareError::TooSmall));
    assert_eq!(store.load(|_| true).1, SettingsFrom::Unreadable);
    let error = SaveError::Flash(NorFlashErrorKind::OutOfBounds);
    assert_eq!(store.save(&settings(1)), Err(error));

    // A cell in the way of the next record that cannot be programmed.
    let mut store = Store::new(blank());
    store.save(&settings(1)).unwrap();
    let mut flash = store.flash;
    flash.0[PAGE / 2] = 0;
    let mut store = Store::new(flash);
    assert_eq!(store.save(&settings(2)), Err(SaveError::Full));
    store.prepare(1).unwrap();
    assert_eq!(store.load(|_| true), (settings(1), SettingsFrom::Saved));
    store.save(&settings(2)).unwrap();
}
