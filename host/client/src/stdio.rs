//! Standard output and standard error, which may be closed at any time.
//!
//! A reader closes its pipe, a terminal hangs up, a disk is full. `println!` and
//! `eprintln!` panic then, perhaps while a board is armed. Here an error of standard output
//! is returned, and remembered for the exit code; one of standard error is ignored, as there
//! is no place left to report it.

use std::fmt::{Arguments, Display};
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
        Self::checked(io::stdout().write_fmt(text))
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
    // Formatted first: a line of several parts reaches a pipe in one piece.
    Stdout.write_all(text.to_string().as_bytes())?;
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
    let mut stderr = io::stderr();
    // An error here cannot be reported anywhere.
    let _ = stderr.write_all(text.to_string().as_bytes());
    let _ = stderr.flush();
}
