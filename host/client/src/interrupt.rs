//! Ctrl-C, remembered instead of obeyed at once: what drives a link looks, switches the
//! motors off, and ends.
//!
//! A request to terminate, and a terminal that is closed, count as well.

use std::sync::atomic::{AtomicU32, Ordering};

/// Exit code of a program that ctrl-c ended: 128 and the signal's number.
const ENDED: i32 = 130;

/// How often it was pressed since [`listen`].
static PRESSED: AtomicU32 = AtomicU32::new(0);

/// Whether ctrl-c has been pressed since [`listen`].
pub fn is_raised() -> bool {
    PRESSED.load(Ordering::Relaxed) > 0
}

/// Ctrl-C cannot be remembered.
#[derive(Debug, thiserror::Error)]
#[error(
    "ctrl-c cannot be listened to: {0}; nothing was begun, so that nothing has to be switched off"
)]
pub struct ListenError(ctrlc::Error);

/// From now on, ctrl-c (and a request to terminate) is remembered instead of ending
/// the program; pressed a second time, it ends it.
///
/// # Errors
/// If the system does not let it.
pub fn listen() -> Result<(), ListenError> {
    let heard = ctrlc::set_handler(|| {
        if PRESSED.fetch_add(1, Ordering::Relaxed) > 0 {
            std::process::exit(ENDED);
        }
    });
    match heard {
        // Another part of this program listens already.
        Ok(()) | Err(ctrlc::Error::MultipleHandlers) => Ok(()),
        Err(error) => Err(ListenError(error)),
    }
}
