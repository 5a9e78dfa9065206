//! Ctrl-C as a flag instead of an immediate exit: the driver of a link polls it, switches
//! the motors off, and ends.
//!
//! A request to terminate and a closed terminal set it as well.

use std::sync::atomic::{AtomicU32, Ordering};

/// Exit code of a program that ctrl-c ended: 128 plus the signal's number.
const ENDED: i32 = 130;

/// Number of times since [`listen`].
static PRESSED: AtomicU32 = AtomicU32::new(0);

/// Whether ctrl-c has been pressed since [`listen`].
pub fn is_raised() -> bool {
    PRESSED.load(Ordering::Relaxed) > 0
}

/// The handler cannot be installed.
#[derive(Debug, thiserror::Error)]
#[error(
    "cannot install a handler for ctrl-c: {0}; nothing was started, so nothing has to be switched off"
)]
pub struct ListenError(ctrlc::Error);

/// Installs the handler: the first ctrl-c (or request to terminate) sets the flag, the
/// second ends the program.
///
/// # Errors
/// If the system refuses.
pub fn listen() -> Result<(), ListenError> {
    let installed = ctrlc::set_handler(|| {
        if PRESSED.fetch_add(1, Ordering::Relaxed) > 0 {
            std::process::exit(ENDED);
        }
    });
    match installed {
        // Already installed by another part of this program.
        Ok(()) | Err(ctrlc::Error::MultipleHandlers) => Ok(()),
        Err(error) => Err(ListenError(error)),
    }
}
