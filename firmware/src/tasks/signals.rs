//! The signals of the real-time loop to the loops in thread mode.

use armbridge_link::message::Mode;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;

/// Signals of the real-time loop, each with its latest value only.
#[derive(Default)]
pub struct Signals {
    /// A frame is ready for the host.
    pub frame_ready: Signal<CriticalSectionRawMutex, ()>,
    /// Bytes are ready for the client of the transparent port, or there is room for bytes
    /// from it.
    pub client_bytes: Signal<CriticalSectionRawMutex, ()>,
    /// The mode has changed.
    pub mode: Signal<CriticalSectionRawMutex, Mode>,
}

impl Signals {
    /// Signals that have not been given.
    pub const fn new() -> Self {
        Self {
            frame_ready: Signal::new(),
            client_bytes: Signal::new(),
            mode: Signal::new(),
        }
    }
}
