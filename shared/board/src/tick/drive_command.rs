//! Drive command: the source that drives the motors, stored so that a turned bit is detected.
//!
//! The source is a word that differs from any other source's in 12 bits. A [`CheckWord`]
//! covers it, the constant torque and the age of the command; every tick compares it
//! before it drives anything.

use super::reference::TimedTrajectory;
use armbridge_control::check_word::{CheckWord, CodeTable, checked};
use armbridge_control::trajectory::stream::Point;
use armbridge_link::experiment::Experiment;
use armbridge_link::message::Drive;
use armbridge_servo::JOINTS;

/// Request of the host that drives the arm, within its bounds.
#[derive(Clone, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "a queue has room for the largest"
)]
pub enum DriveRequest {
    /// Constant torques in N m.
    Torque([f32; JOINTS]),
    /// Hold the arm at these angles in rad.
    Regulate([f32; JOINTS]),
    /// Follow a planned motion.
    Follow(TimedTrajectory),
    /// Follow a stream of which this is the next point.
    Stream(Point<f32>),
    /// Run this experiment.
    Experiment(Experiment),
    /// Make the arm weightless, for a hand to lead.
    Float,
}

/// See the [module](self).
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct DriveCommand {
    words: Words,
    check: CheckWord,
}

#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
struct Words {
    drive: u32,
    torque_nm: [f32; JOINTS],
    commanded_us: u64,
}

checked!(Words {
    drive,
    torque_nm,
    commanded_us,
});

/// Code words: Walsh functions, with the index of the source in the last four bits.
const DRIVES: [(Drive, u32); 7] = [
    (Drive::Torque, 0x5555_5550),
    (Drive::Regulate, 0x3333_3331),
    (Drive::Track, 0x0F0F_0F02),
    (Drive::Hold, 0x00FF_00F3),
    (Drive::Experiment, 0x6969_6964),
    (Drive::Float, 0x3C3C_3C35),
    (Drive::Park, 0x5A5A_5A56),
];

const CODES: CodeTable<Drive> = CodeTable::new(&DRIVES);

impl DriveCommand {
    /// A command of this source, at this time in µs; torques are those of
    /// [`Drive::Torque`].
    pub(super) fn new(drive: Drive, torque_nm: [f32; JOINTS], commanded_us: u64) -> Self {
        let known = DRIVES.iter().find(|(known, _)| *known == drive);
        let words = Words {
            drive: known.map_or(0, |(_, word)| *word),
            torque_nm,
            commanded_us,
        };
        Self {
            words,
            check: CheckWord::compute(&words),
        }
    }

    /// This command, continued by another source from this time on. One that is corrupted keeps
    /// its check word, which shows that at the next tick.
    pub(super) fn continued(&self, drive: Drive, commanded_us: u64) -> Self {
        let renewed = Self::new(drive, self.words.torque_nm, commanded_us);
        if self.is_intact() {
            renewed
        } else {
            Self {
                check: self.check,
                ..renewed
            }
        }
    }

    /// The source; [`Drive::Hold`] if the word is invalid.
    pub(super) fn drive(&self) -> Drive {
        self.known().unwrap_or(Drive::Hold)
    }

    fn known(&self) -> Option<Drive> {
        CODES.decode(self.words.drive)
    }

    /// Constant torques in N m.
    pub(super) fn torque_nm(&self) -> [f32; JOINTS] {
        self.words.torque_nm
    }

    /// Age of the command at this time, in µs.
    pub(super) fn age_us(&self, now_us: u64) -> u64 {
        now_us.saturating_sub(self.words.commanded_us)
    }

    /// Whether the command is as it was written.
    pub(super) fn is_intact(&self) -> bool {
        self.known().is_some() && CheckWord::compute(&self.words) == self.check
    }

    /// Turns a bit, chosen by `draw`, for tests.
    pub(super) fn inject_error(&mut self, draw: u32) {
        let (word, bit) = (draw / u32::BITS, draw % u32::BITS);
        match self.words.torque_nm.get_mut(word as usize) {
            Some(torque) => *torque = f32::from_bits(torque.to_bits() ^ 1 << bit),
            None if word % 2 == 0 => self.words.drive ^= 1 << bit,
            None => self.words.commanded_us ^= 1 << (bit + draw / 256 % 2 * 32),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_far_apart() {
        for (index, (drive, word)) in DRIVES.iter().enumerate() {
            assert_eq!(CODES.decode(*word), Some(*drive));
            for (_, other) in &DRIVES[..index] {
                assert!((word ^ other).count_ones() >= 12, "{word:x} {other:x}");
            }
        }
    }

    #[test]
    fn every_turned_bit_shows() {
        for (drive, _) in DRIVES {
            let command = DriveCommand::new(drive, [0.25, -0.5], 1_000_000);
            assert!(command.is_intact() && command.drive() == drive);
            for draw in 0..512 {
                let mut changed = command;
                changed.inject_error(draw);
                assert!(!changed.is_intact(), "{drive:?}, {draw}");
                for (other, _) in DRIVES.iter().filter(|(other, _)| *other != drive) {
                    let renewed = changed.continued(*other, 2_000_000);
                    assert!(!renewed.is_intact(), "{drive:?} to {other:?}, {draw}");
                }
            }
        }
    }
}
