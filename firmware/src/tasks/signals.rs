//! The signals of the real-time loop to the loops in thread mode.

use armbridge_shared::link::message::Mode;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;

/// Signals of the real-time loop, each with its latest value only.
#[derive(Default)]
pub struct Signals {
    /// There is a frame to send.
    pub ran: Signal<CriticalSectionRawMutex, ()>,
    /// There are bytes for the client of the transparent port, or room for bytes from
    /// it.
    pub served: Signal<CriticalSectionRawMutex, ()>,
    /// The mode has changed.
    pub mode: Signal<CriticalSectionRawMutex, Mode>,
}

impl Signals {
    /// Signals that have not been given.
    pub const fn new() -> Self {
        Self {
            ran: Signal::new(),
            served: Signal::new(),
            mode: Signal::new(),
        }
    }
}
