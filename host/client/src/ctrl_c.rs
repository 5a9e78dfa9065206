//! Ctrl-C as a flag instead of an immediate exit: the driver of a link polls it, switches
//! the motors off, and ends.
//!
//! A request to terminate and a terminal that hangs up set it as well. A second ctrl-c ends
//! the program at once; a second hang-up does not: a terminal that closes sends one to the
//! program and one through its shell, and the motors must be switched off first.
//!
//! | system | handlers | signals |
//! |---|---|---|
//! | Unix | `signal-hook`, which tells signals apart | all of [`Signal`] |
//! | Windows | `ctrlc`: a thread of its own, as consoles have it | every event is [`Signal::Interrupt`]: ctrl-c, ctrl-break |
//!
//! Windows ends a program whose window is closed without waiting for it, as a kill does: a
//! board switches its motors off when its host's heartbeats stop.

use std::io;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, LazyLock};

/// A signal that ends the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
    /// The terminal hung up: `SIGHUP`.
    HangUp,
    /// Ctrl-C: `SIGINT`.
    Interrupt,
    /// A request to terminate: `SIGTERM`.
    Terminate,
}

impl Signal {
    const ALL: [Self; 3] = [Self::HangUp, Self::Interrupt, Self::Terminate];

    /// Its number, as POSIX has it.
    const fn number(self) -> u8 {
        match self {
            Self::HangUp => 1,
            Self::Interrupt => 2,
            Self::Terminate => 15,
        }
    }

    /// Its name in a sentence.
    pub const fn in_words(self) -> &'static str {
        match self {
            Self::HangUp => "a terminal that hung up",
            Self::Interrupt => "ctrl-c",
            Self::Terminate => "a request to terminate",
        }
    }

    /// Exit code of a program that it ended: 128 plus its number, as shells have it.
    pub const fn exit_code(self) -> u8 {
        128 + self.number()
    }
}

/// Number of the last signal since [`listen`]; 0 for none.
static RAISED: LazyLock<Arc<AtomicUsize>> = LazyLock::new(Arc::default);

/// Whether ctrl-c has been pressed, or another signal has come, since [`listen`].
pub fn is_raised() -> bool {
    RAISED.load(Ordering::Relaxed) > 0
}

/// The signal that came since [`listen`].
pub fn raised() -> Option<Signal> {
    let number = RAISED.load(Ordering::Relaxed);
    let mut signals = Signal::ALL.into_iter();
    signals.find(|signal| usize::from(signal.number()) == number)
}

/// Exit code of a program that a signal ended; that of ctrl-c if none came.
pub fn exit_code() -> u8 {
    raised().unwrap_or(Signal::Interrupt).exit_code()
}

/// Exit code of a program that runs until ctrl-c: 0 after that, and if no signal came.
pub fn awaited_exit_code() -> u8 {
    match raised() {
        None | Some(Signal::Interrupt) => 0,
        Some(signal @ (Signal::HangUp | Signal::Terminate)) => signal.exit_code(),
    }
}

/// Name of the signal that came since [`listen`], in a sentence; ctrl-c if none came.
pub fn in_words() -> &'static str {
    raised().unwrap_or(Signal::Interrupt).in_words()
}

/// The handler cannot be installed.
#[derive(Debug, thiserror::Error)]
#[error(
    "cannot install a handler for ctrl-c: {0}; nothing was started, so nothing has to be switched off"
)]
pub struct ListenError(io::Error);

/// Installs the handlers, once: the first ctrl-c, hang-up or request to terminate sets the
/// flag, another ctrl-c ends the program.
///
/// # Errors
/// If the system refuses.
pub fn listen() -> Result<(), ListenError> {
    static INSTALLED: LazyLock<Result<(), io::ErrorKind>> =
        LazyLock::new(|| install().map_err(|error| error.kind()));
    INSTALLED.map_err(|kind| ListenError(kind.into()))
}

#[cfg(unix)]
fn install() -> io::Result<()> {
    use std::sync::atomic::AtomicBool;

    use signal_hook::consts::SIGINT;
    use signal_hook::flag;

    // Before the flag is set by the same ctrl-c.
    let interrupted = Arc::new(AtomicBool::new(false));
    let code = Signal::Interrupt.exit_code();
    flag::register_conditional_shutdown(SIGINT, code.into(), Arc::clone(&interrupted))?;
    flag::register(SIGINT, interrupted)?;
    for signal in Signal::ALL {
        let number = signal.number();
        flag::register_usize(number.into(), Arc::clone(&RAISED), number.into())?;
    }
    Ok(())
}

#[cfg(not(unix))]
fn install() -> io::Result<()> {
    let set = ctrlc::set_handler(|| {
        let number = Signal::Interrupt.number();
        if RAISED.swap(number.into(), Ordering::Relaxed) > 0 {
            std::process::exit(Signal::Interrupt.exit_code().into());
        }
    });
    set.map_err(|error| match error {
        ctrlc::Error::System(error) => error,
        other => io::Error::other(other),
    })
}
