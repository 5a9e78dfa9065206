//! Values of a record, as far as they exist: NaN where they do not.
//!
//! A board sends every field in every tick. Angles exist once servos have been found, samples
//! unless they are missing, and reference and error only while a controller holds the arm at a
//! reference: under a constant torque, in an experiment or while the arm floats the field has the
//! last one, which nothing follows. Figures and pages show the same values by these functions.

use armbridge_client::enum_names;
use armbridge_link::message::{Drive, Record};

/// A value that is known once servos have been found.
pub fn once_up(record: &Record, value: f32) -> f64 {
    if enum_names::is_up(record.mode) {
        value.into()
    } else {
        f64::NAN
    }
}

/// A value that exists while a controller holds the arm at a reference.
pub fn in_closed_loop(record: &Record, value: f32) -> f64 {
    if record.mode.drive().is_some_and(Drive::is_closed_loop) {
        value.into()
    } else {
        f64::NAN
    }
}

/// Estimated angle in rad.
pub fn angle_rad(record: &Record, joint: usize) -> f64 {
    once_up(record, record.output.angle_rad[joint])
}

/// Reference angle in rad.
pub fn reference_rad(record: &Record, joint: usize) -> f64 {
    in_closed_loop(record, record.output.reference_rad[joint])
}

/// Estimate minus reference in rad.
pub fn error_rad(record: &Record, joint: usize) -> f64 {
    angle_rad(record, joint) - reference_rad(record, joint)
}

/// Encoder count.
pub fn count(record: &Record, joint: usize) -> f64 {
    let count = record.input.samples[joint].counts();
    count.map_or(f64::NAN, |count| once_up(record, count.into()))
}

#[cfg(test)]
mod tests {
    use armbridge_link::message::{Mode, Sample};

    use super::*;

    #[test]
    fn a_value_exists_in_the_modes_that_give_it_a_meaning() {
        use Drive::{Experiment, Float, Hold, Park, Regulate, Torque, Track};
        let exists = |mode: Mode| {
            let mut record = Record {
                mode,
                ..Record::NONE
            };
            record.input.samples = [Sample::Counts(512); 2];
            let values = [count, angle_rad, reference_rad, error_rad];
            values.map(|value| value(&record, 0).is_finite())
        };
        assert_eq!(exists(Mode::Boot), [false; 4]);
        assert_eq!(exists(Mode::Armed), [true, true, false, false]);
        for drive in [Torque, Experiment, Float] {
            assert_eq!(exists(Mode::Running(drive)), [true, true, false, false]);
        }
        for drive in [Regulate, Track, Hold, Park] {
            assert_eq!(exists(Mode::Running(drive)), [true; 4]);
            assert_eq!(exists(Mode::Degraded(drive)), [true; 4]);
        }
    }
}
