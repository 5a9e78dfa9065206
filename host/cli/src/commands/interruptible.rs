//! Work that a signal ends, although it has no place to look for one.

use std::panic::resume_unwind;
use std::time::Duration;

use armbridge_client::ctrl_c;

use super::Error;

/// Interval between two looks at the signals and the work.
const LOOK: Duration = Duration::from_millis(10);

/// Result of `work`. After a signal it is abandoned, and ends with the program: it must leave
/// nothing behind. `what` names it in the error, as "the log was read".
pub(super) fn interruptible<T: Send + 'static>(
    what: &str,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, Error> {
    ctrl_c::listen()?;
    let thread = std::thread::Builder::new().spawn(work)?;
    while !thread.is_finished() {
        if ctrl_c::is_raised() {
            return Err(format!("ended by {} before {what}", ctrl_c::in_words()).into());
        }
        std::thread::sleep(LOOK);
    }
    Ok(thread.join().unwrap_or_else(|panic| resume_unwind(panic)))
}
