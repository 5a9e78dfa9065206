//! Memory that is retained through a reset: crash record, number of resets,
//! tick, and speed of the servo bus.
//!
//! It lies in a section that is not initialised, so that it holds noise after
//! power-up. Every cell is atomic: an exception handler may interrupt between any two
//! accesses, and then its values are final.

use super::record::{self, CrashRecord, WORDS};
use armbridge_link::message::{BoardReport, End, LastEnd};
use armbridge_servo::port::{BAUD_RATES, SERVO_BAUD};
use core::sync::atomic::{AtomicU32, Ordering};

struct Memory {
    record: [AtomicU32; WORDS],
    /// Number of resets.
    resets: AtomicU32,
    tick: AtomicU32,
    baud: AtomicU32,
}

// SAFETY: `.uninit` is placed in RAM by cortex-m-rt's linker script, and any bits
// are an `AtomicU32`.
#[cfg_attr(target_os = "none", unsafe(link_section = ".uninit.CRASH"))]
static MEMORY: Memory = Memory {
    record: [const { AtomicU32::new(0) }; WORDS],
    resets: AtomicU32::new(0),
    tick: AtomicU32::new(0),
    baud: AtomicU32::new(0),
};

/// Logs the end of the program before.
#[cfg(feature = "board")]
pub fn log(report: &BoardReport) {
    let end = &report.last_end;
    defmt::info!(
        "session {=u32}; the one before ended by {}, tick {=u32}",
        report.session,
        end.cause,
        end.tick
    );
    let place = end.place.split(|byte| *byte == 0).next();
    let place = core::str::from_utf8(place.unwrap_or_default()).unwrap_or_default();
    if !place.is_empty() {
        defmt::info!("it ended at {=str}:{=u32}", place, end.line);
    } else if end.pc != 0 {
        defmt::info!("it ended at pc {=u32:#x}", end.pc);
    }
}

/// The record, if memory was retained.
fn kept() -> Option<CrashRecord> {
    let mut words = [0; WORDS];
    for (word, cell) in words.iter_mut().zip(&MEMORY.record) {
        *word = cell.load(Ordering::Relaxed);
    }
    CrashRecord::from_words(&words)
}

/// Writes the record.
fn keep_record(kept: CrashRecord) {
    for (cell, word) in MEMORY.record.iter().zip(kept.to_words()) {
        cell.store(word, Ordering::Relaxed);
    }
}

/// Starts after a reset, once. `chip` is the chip's own cause of the
/// reset. The session is counted up from its value in memory.
pub fn begin(chip: End) -> BoardReport {
    let session = MEMORY.resets.load(Ordering::Relaxed).wrapping_add(1);
    MEMORY.resets.store(session, Ordering::Relaxed);
    let last_end = record::last_end(kept(), chip, tick());
    MEMORY.tick.store(0, Ordering::Relaxed);
    MEMORY.baud.store(BAUD_RATES[0], Ordering::Relaxed);
    keep_record(CrashRecord::Running);
    BoardReport {
        session,
        last_end,
        ..BoardReport::default()
    }
}

/// Whether this memory was retained through the reset.
pub fn is_kept() -> bool {
    kept().is_some()
}

/// Records the end of the program, unless one is recorded already.
pub fn keep(end: LastEnd) {
    if !matches!(kept(), Some(CrashRecord::Ended(_))) {
        keep_record(CrashRecord::Ended(end));
    }
}

/// Records the tick that has begun.
pub fn set_tick(tick: u32) {
    MEMORY.tick.store(tick, Ordering::Relaxed);
}

/// The last tick that began.
pub fn tick() -> u32 {
    MEMORY.tick.load(Ordering::Relaxed)
}

/// Stores the baud rate of the servo bus.
pub fn set_baud(baud: u32) {
    MEMORY.baud.store(baud, Ordering::Relaxed);
}

/// Speed of the servo bus in bits per second; before [`begin`], that before the reset.
pub fn baud() -> u32 {
    let baud = MEMORY.baud.load(Ordering::Relaxed);
    // Any other value is noise from power-up.
    if SERVO_BAUD.contains(&baud) {
        baud
    } else {
        BAUD_RATES[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_kept_is_told_once() {
        assert_eq!(baud(), BAUD_RATES[0]);
        let first = begin(End::PowerUp);
        assert_eq!(first.last_end.cause, End::PowerUp);
        set_tick(41);
        set_baud(4_500_000);
        assert_eq!(baud(), 4_500_000);
        set_baud(57_142);
        let end = LastEnd {
            cause: End::HardFault,
            pc: 0x1234,
            tick: tick(),
            ..LastEnd::default()
        };
        keep(end);
        // Ending has failed too.
        keep(LastEnd {
            cause: End::Panic,
            ..end
        });
        // Servos that are driven listen at this speed, whatever has happened.
        assert_eq!(baud(), 57_142);
        let second = begin(End::Software);
        assert_eq!(baud(), BAUD_RATES[0]);
        assert_eq!(second.last_end, end);
        assert_eq!(second.session, first.session.wrapping_add(1));
        assert_eq!(begin(End::Software).last_end.cause, End::Software);
    }
}
