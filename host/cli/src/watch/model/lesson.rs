//! Lesson: the path along which a hand has led the arm in its last float, to be written as a motion.

use std::io;
use std::path::{Path, PathBuf};

use armbridge_analysis::taught_motion::{FloatSamples, TaughtMotion, TeachError};
use armbridge_link::message::{Drive, Record};
use armbridge_log::output_file::{self, Existing};

/// Number of samples that are kept, from the beginning of the float: ten minutes at 1 kHz.
const SAMPLES_MAX: usize = 600_000;
/// Name of the file, or the next free one.
const FILE: &str = "taught.csv";

/// See the [module](self).
#[derive(Clone, Debug, Default)]
pub struct Lesson(FloatSamples);

/// Reason for which no motion was written.
#[derive(Debug, thiserror::Error)]
pub enum LessonError {
    /// There is none.
    #[error(transparent)]
    Teach(#[from] TeachError),
    /// Its file could not be written.
    #[error("{FILE}: {0}")]
    Write(#[from] io::Error),
}

impl Lesson {
    /// Takes the record of a tick.
    pub(super) fn take(&mut self, record: &Record) {
        if record.mode.drive() != Some(Drive::Float) || self.0.len() < SAMPLES_MAX {
            self.0.take(record);
        }
    }

    /// The motion.
    ///
    /// # Errors
    /// See [`TeachError`].
    pub fn motion(&self) -> Result<TaughtMotion, TeachError> {
        self.0.motion()
    }

    /// Writes the motion into this folder. Returns its file, and its duration in s.
    ///
    /// # Errors
    /// See [`LessonError`].
    pub fn write(&self, folder: &Path) -> Result<(PathBuf, f64), LessonError> {
        let taught = self.motion()?;
        let file = output_file::write(
            &folder.join(FILE),
            taught.csv().as_bytes(),
            Existing::Number,
        )?;
        Ok((file, taught.duration_s()))
    }
}

#[cfg(test)]
mod tests {
    use armbridge_link::message::Mode;

    use super::*;

    fn record(tick: u32, mode: Mode, angle_rad: f32) -> Record {
        let mut record = Record {
            tick,
            mode,
            ..Record::NONE
        };
        record.input.start_us = u64::from(tick) * 1_000;
        record.output.angle_rad = [angle_rad, 0.0];
        record
    }

    /// The last float is written, also while it is under way, and keeps earlier files.
    #[test]
    fn the_last_float_is_a_motion() {
        let folder = tempfile::tempdir().unwrap();
        let mut lesson = Lesson::default();
        assert!(matches!(
            lesson.write(folder.path()),
            Err(LessonError::Teach(TeachError::NoFloat))
        ));
        let float = Mode::Running(Drive::Float);
        for tick in 0..1_000 {
            lesson.take(&record(tick, float, 0.5));
        }
        lesson.take(&record(1_000, Mode::Armed, 0.5));
        for tick in 0..3_000_u32 {
            let way = (tick.clamp(1_000, 2_000) - 1_000) as f32 * 1e-3;
            lesson.take(&record(2_000 + tick, float, 0.3 * way));
        }
        let (file, duration_s) = lesson.write(folder.path()).unwrap();
        assert_eq!(file.file_name().unwrap(), FILE);
        assert!((1.0..2.0).contains(&duration_s), "{duration_s}");
        lesson.take(&record(5_000, float, 0.3));
        for tick in 5_000..6_000 {
            lesson.take(&record(tick, float, 0.2));
        }
        let (second, _) = lesson.write(folder.path()).unwrap();
        assert_ne!(second, file);
    }
}
