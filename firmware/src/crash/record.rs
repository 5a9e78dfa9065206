//! Crash record: the end of the program, as words in memory.
//!
//! | word   | content                                                        |
//! |--------|----------------------------------------------------------------|
//! | 0      | [`MAGIC`]                                                       |
//! | 1      | cause, as a number of [`CAUSES`]; [`RUNNING`] until there is one |
//! | 2      | program counter                                                |
//! | 3      | line that panicked                                             |
//! | 4..10  | end of the name of its file                                    |
//! | 10     | tick                                                           |
//! | 11     | CRC-32 of these words                                          |
//!
//! Memory holds noise after power-up, which the magic word and the
//! CRC detect. So an intact record also proves that the
//! memory has not been without power since it was written.

use armbridge_link::board::PLACE_LEN;
use armbridge_link::crc32::checksum_of_words;
use armbridge_link::message::{End, LastEnd};

/// Words of a record.
pub const WORDS: usize = 12;

/// A record as words in memory.
pub type Words = [u32; WORDS];

const MAGIC: u32 = u32::from_le_bytes(*b"ARMb");
const RUNNING: u32 = 0xFF;

/// Causes by their number in a record.
const CAUSES: [End; 9] = [
    End::PowerUp,
    End::BrownOut,
    End::ResetPin,
    End::Software,
    End::Watchdog,
    End::Panic,
    End::HardFault,
    End::StackOverflow,
    End::Crystal,
];

/// Information about the program that wrote a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CrashRecord {
    /// The program had not recorded its end.
    Running,
    /// The recorded end.
    Ended(LastEnd),
}

impl CrashRecord {
    /// Encodes the record as words.
    pub fn to_words(self) -> Words {
        let (code, end) = match self {
            Self::Running => (RUNNING, LastEnd::default()),
            Self::Ended(end) => {
                let is_cause = |cause: &End| *cause == end.cause;
                let code = CAUSES.iter().position(is_cause).unwrap_or_default();
                (code as u32, end)
            }
        };
        let mut place = end.place.chunks_exact(4).map(little);
        let mut place_word = || place.next().unwrap_or_default();
        let mut words = [
            MAGIC,
            code,
            end.pc,
            end.line,
            place_word(),
            place_word(),
            place_word(),
            place_word(),
            place_word(),
            place_word(),
            end.tick,
            0,
        ];
        let [content @ .., crc] = &mut words;
        *crc = checksum_of_words(content.iter().copied());
        words
    }

    /// Decodes the record; `None` if the words are noise.
    pub fn from_words(words: &Words) -> Option<Self> {
        let [content @ .., crc] = words;
        let [magic, code, pc, line, place @ .., tick] = content;
        if *magic != MAGIC || *crc != checksum_of_words(content.iter().copied()) {
            return None;
        }
        if *code == RUNNING {
            return Some(Self::Running);
        }
        let mut bytes = [0; PLACE_LEN];
        for (slot, byte) in bytes
            .iter_mut()
            .zip(place.iter().flat_map(|word| word.to_le_bytes()))
        {
            *slot = byte;
        }
        Some(Self::Ended(LastEnd {
            cause: *CAUSES.get(*code as usize)?,
            pc: *pc,
            line: *line,
            place: bytes,
            tick: *tick,
        }))
    }
}

fn little(bytes: &[u8]) -> u32 {
    bytes
        .iter()
        .rev()
        .fold(0, |word, byte| word << 8 | u32::from(*byte))
}

/// The last characters of a file's name, padded with zeros.
pub fn tail(file: &str) -> [u8; PLACE_LEN] {
    let bytes = file.as_bytes();
    let begin = bytes.len().saturating_sub(PLACE_LEN);
    let mut place = [0; PLACE_LEN];
    for (slot, byte) in place.iter_mut().zip(bytes.iter().skip(begin)) {
        *slot = *byte;
    }
    place
}

/// End of the last program: from its record, or else from the chip's cause
/// of the reset. `tick` is the last one that began, if memory was kept.
pub fn last_end(kept: Option<CrashRecord>, chip: End, tick: u32) -> LastEnd {
    let cause = match (kept, chip) {
        (Some(CrashRecord::Ended(end)), _) => return end,
        // The chip was reset by its supply, and memory outlasted it.
        (Some(CrashRecord::Running), End::PowerUp) => End::BrownOut,
        (_, chip) => chip,
    };
    LastEnd {
        cause,
        tick: if kept.is_some() { tick } else { 0 },
        ..LastEnd::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panicked() -> LastEnd {
        LastEnd {
            cause: End::Panic,
            pc: 0,
            line: 321,
            place: tail("firmware/src/board/mps2_an386/fault_injection.rs"),
            tick: 0xFFFF_FFF0,
        }
    }

    #[test]
    fn a_record_is_read_back_and_no_flipped_bit_is_taken_for_one() {
        assert_eq!(&panicked().place, b"an386/fault_injection.rs" as &[u8; 24]);
        let mut all = [CrashRecord::Running; CAUSES.len() + 1];
        for (kept, cause) in all.iter_mut().zip(CAUSES) {
            *kept = CrashRecord::Ended(LastEnd {
                cause,
                ..panicked()
            });
        }
        for kept in all {
            let words = kept.to_words();
            assert_eq!(CrashRecord::from_words(&words), Some(kept));
            for bit in 0..32 * WORDS {
                let mut damaged = words;
                damaged[bit / 32] ^= 1 << (bit % 32);
                assert_eq!(
                    CrashRecord::from_words(&damaged),
                    None,
                    "bit {bit} of {kept:?}"
                );
            }
        }
        assert_eq!(CrashRecord::from_words(&[0; WORDS]), None);
        assert_eq!(CrashRecord::from_words(&[u32::MAX; WORDS]), None);
    }

    #[test]
    fn the_end_of_a_name_is_kept() {
        assert_eq!(tail("run.rs")[..7], *b"run.rs\0");
        assert_eq!(tail(""), [0; PLACE_LEN]);
    }

    #[test]
    fn a_programs_own_account_counts_more_than_the_chips() {
        let ended = Some(CrashRecord::Ended(panicked()));
        assert_eq!(last_end(ended, End::Software, 7), panicked());
        let cause = |kept, chip| {
            let end = last_end(kept, chip, 7);
            (end.cause, end.tick)
        };
        let running = Some(CrashRecord::Running);
        assert_eq!(cause(running, End::Watchdog), (End::Watchdog, 7));
        // Memory that was kept has had power all the time.
        assert_eq!(cause(running, End::PowerUp), (End::BrownOut, 7));
        assert_eq!(cause(None, End::PowerUp), (End::PowerUp, 0));
        assert_eq!(cause(None, End::BrownOut), (End::BrownOut, 0));
    }
}
