//! The dialogue of a task with the person who moves the arm.

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
