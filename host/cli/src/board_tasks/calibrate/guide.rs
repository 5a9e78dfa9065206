//! The dialogue of a task with the person who moves the arm.

use armbridge_control::actuator::Joint;

use super::super::TaskError;

/// The dialogue with the person.
pub trait Guide {
    /// Prints a line: an instruction or a question.
    fn say(&mut self, line: &str);

    /// Shows where the arm is; replaces what was shown before.
    fn show(&mut self, line: &str);

    /// The next answer, if there is one.
    ///
    /// # Errors
    /// If no answer can come.
    fn answer(&mut self) -> Result<Option<String>, TaskError>;
}

impl<G: Guide + ?Sized> Guide for &mut G {
    fn say(&mut self, line: &str) {
        (**self).say(line);
    }

    fn show(&mut self, line: &str) {
        (**self).show(line);
    }

    fn answer(&mut self) -> Result<Option<String>, TaskError> {
        (**self).answer()
    }
}

/// Asks for the joint of this number to be held at its zero.
pub(super) fn zero_request(number: usize) -> String {
    format!(
        "Joint {number}: hold it at its zero (upright, or straight down if the arm hangs, or in line \
         with the link before it) and press Enter."
    )
}

/// Asks for it to be turned.
pub(super) fn turn_request(number: usize) -> String {
    format!(
        "Joint {number}: turn it alone by 0.3 rad or more towards positive angles \
         (counter-clockwise), hold it, and press Enter."
    )
}

/// What was measured of it.
pub(super) fn change(number: usize, before: &Joint<f32>, after: &Joint<f32>) -> String {
    format!(
        "joint {number}: zero {:.1} -> {:.1} counts, {:?} -> {:?}",
        before.zero_count, after.zero_count, before.direction, after.direction
    )
}
