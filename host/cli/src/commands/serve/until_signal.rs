//! A served board until a signal ends the program.

use armbridge_client::{Host, ctrl_c};

/// A host that is done once a signal has come.
pub(super) struct UntilSignal<H>(pub(super) H);

impl<H: Host> Host for UntilSignal<H> {
    type Error = H::Error;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], H::Error> {
        self.0.transmit(now_us)
    }

    fn receive(&mut self, now_us: u64, bytes: &[u8]) -> Result<(), H::Error> {
        self.0.receive(now_us, bytes)
    }

    fn wake_at_us(&self) -> u64 {
        self.0.wake_at_us()
    }

    fn is_done(&self) -> bool {
        ctrl_c::is_raised() || self.0.is_done()
    }

    fn emergency_stop(&mut self, now_us: u64) -> bool {
        self.0.emergency_stop(now_us)
    }

    fn disarm(&mut self, now_us: u64) -> bool {
        self.0.disarm(now_us)
    }
}
