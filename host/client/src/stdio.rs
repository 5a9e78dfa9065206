//! Standard output and standard error, which may be closed at any time.
//!
//! A reader closes its pipe, a terminal hangs up, a disk is full. `println!` and
//! `eprintln!` panic then, perhaps while a board is armed. Here an error of standard output
//! is returned, and remembered for the exit code; one of standard error is ignored, as there
//! is no place left to report it.
//!
//! Much of what is printed was written by others: names in a log or a file, lines of a board.
//! A terminal obeys control characters in it, so text is printed [`Visible`]. Bytes that are
//! given to [`Stdout`] as bytes are passed on: those of a file are no text for a terminal.

use std::fmt::{Arguments, Display, Formatter, Result, Write as _};
use std::io;
use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};

static IS_CLOSED: AtomicBool = AtomicBool::new(false);
static HAS_FAILED: AtomicBool = AtomicBool::new(false);

/// Whether the reader of standard output has closed it.
pub fn is_closed() -> bool {
    IS_CLOSED.load(Ordering::Relaxed)
}

/// Whether a write to standard output has failed, for any reason.
pub fn has_failed() -> bool {
    HAS_FAILED.load(Ordering::Relaxed)
}

/// Standard output; its errors begin with "cannot print".
#[derive(Clone, Copy, Debug, Default)]
pub struct Stdout;

impl Stdout {
    /// The result of a write to standard output, which a library made itself: its error is
    /// remembered, and begins with "cannot print".
    ///
    /// # Errors
    /// That of the write.
    pub fn checked<T>(result: io::Result<T>) -> io::Result<T> {
        result.map_err(|error| {
            if error.kind() == io::ErrorKind::Interrupted {
                return error;
            }
            HAS_FAILED.store(true, Ordering::Relaxed);
            if error.kind() == io::ErrorKind::BrokenPipe {
                IS_CLOSED.store(true, Ordering::Relaxed);
            }
            io::Error::new(error.kind(), format!("cannot print: {error}"))
        })
    }
}

impl Write for Stdout {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        Self::checked(io::stdout().write(bytes))
    }

    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        Self::checked(io::stdout().write_all(bytes))
    }

    fn write_fmt(&mut self, text: Arguments<'_>) -> io::Result<()> {
        // Formatted first: a line of several parts reaches a pipe in one piece.
        self.write_all(Visible(text).to_string().as_bytes())
    }

    fn flush(&mut self) -> io::Result<()> {
        Self::checked(io::stdout().flush())
    }
}

/// Prints text on standard output, all of it at once.
///
/// # Errors
/// If it cannot be written.
pub fn print(text: impl Display) -> io::Result<()> {
    write!(Stdout, "{text}")?;
    Stdout.flush()
}

/// Prints a line on standard output.
///
/// # Errors
/// If it cannot be written.
pub fn print_line(line: impl Display) -> io::Result<()> {
    print(format_args!("{line}\n"))
}

/// Writes a line on standard error, if that is still there.
pub fn note(line: impl Display) {
    note_text(format_args!("{line}\n"));
}

/// Writes text on standard error, if that is still there.
pub fn note_text(text: impl Display) {
    write_error(Visible(text));
}

/// Writes text over the last line of a terminal at standard error.
pub fn note_over(text: impl Display) {
    write_error(format_args!("\r\x1b[K{}", Visible(text)));
}

fn write_error(text: impl Display) {
    let mut stderr = io::stderr();
    // An error here cannot be reported anywhere.
    let _ = stderr.write_all(text.to_string().as_bytes());
    let _ = stderr.flush();
}

/// Text whose control characters are shown as `\u001b`, as in JSON, but for the end of a line
/// and the tab. Marks that change the direction of writing count as control characters, for
/// they show a text in another order than it has.
#[derive(Clone, Copy, Debug)]
pub struct Visible<T>(pub T);

impl<T: Display> Display for Visible<T> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        write!(VisibleWriter(f), "{}", self.0)
    }
}

struct VisibleWriter<'a, 'b>(&'a mut Formatter<'b>);

impl std::fmt::Write for VisibleWriter<'_, '_> {
    fn write_str(&mut self, text: &str) -> Result {
        let is_hidden = |c: char| {
            let is_layout = matches!(c, '\n' | '\t');
            let is_direction = matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
            (c.is_control() && !is_layout) || is_direction
        };
        for part in text.split_inclusive(is_hidden) {
            match part.chars().next_back().filter(|c| is_hidden(*c)) {
                Some(hidden) => {
                    self.0.write_str(&part[..part.len() - hidden.len_utf8()])?;
                    write!(self.0, "\\u{:04x}", u32::from(hidden))?;
                }
                None => self.0.write_str(part)?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_shown() {
        let hostile = "a\x1b[2J\u{9b}1m\r\u{7f}\u{202e}b\tµ\n";
        let shown = "a\\u001b[2J\\u009b1m\\u000d\\u007f\\u202eb\tµ\n";
        assert_eq!(Visible(hostile).to_string(), shown);
    }
}
