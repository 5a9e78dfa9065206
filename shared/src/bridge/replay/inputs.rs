//! What a record says of the tick's inputs.

use crate::actuator::Pwm;
use crate::link::message::{Record, Sample};

/// When a recorded tick was planned to begin, in µs.
pub const fn planned_us(record: &Record) -> u64 {
    record
        .start_us
        .saturating_sub(record.timing.start_error_us as u64)
}

/// Whether the motors are off in this tick.
pub const fn is_off(record: &Record) -> bool {
    let [a, b] = record.pwm_in_force;
    a == Pwm::OFF.counts() && b == Pwm::OFF.counts()
}

/// Whether both joints' samples are there: an estimator that begins anew needs them.
pub const fn is_complete(record: &Record) -> bool {
    matches!(record.samples, [Sample::Counts(_), Sample::Counts(_)])
}
