//! A host whose words somebody listens to, for those who drive a bench themselves;
//! [`drive`](crate::links::drive) does it for all others.

use crate::bench::cosim::Host;
use crate::bench::plant::Push;
use crate::links::Tap;
use crate::log::event::Direction;

/// A host in virtual time, and who listens.
pub struct Overheard<H> {
    /// The host.
    pub host: H,
    tap: Option<Box<dyn Tap>>,
}

impl<H> Overheard<H> {
    /// Nobody listens without a tap.
    pub fn new(host: H, tap: Option<Box<dyn Tap>>) -> Self {
        Self { host, tap }
    }
}

impl<H: Host> Host for Overheard<H> {
    type Error = H::Error;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], Self::Error> {
        let words = self.host.transmit(now_us)?;
        if let Some(tap) = &mut self.tap
            && !words.is_empty()
        {
            tap.bytes(Direction::ToBoard, now_us.saturating_mul(1_000), words);
        }
        Ok(words)
    }

    fn receive(&mut self, now_us: u64, bytes: &[u8]) -> Result<(), Self::Error> {
        if let Some(tap) = &mut self.tap {
            tap.bytes(Direction::ToHost, now_us.saturating_mul(1_000), bytes);
        }
        self.host.receive(now_us, bytes)
    }

    fn wake_at_us(&self) -> u64 {
        self.host.wake_at_us()
    }

    fn is_done(&self) -> bool {
        self.host.is_done()
    }

    fn parted(&mut self, now_us: u64) {
        self.host.parted(now_us);
    }

    fn take_pushes(&mut self) -> Vec<Push> {
        self.host.take_pushes()
    }
}

impl<H: std::fmt::Debug> std::fmt::Debug for Overheard<H> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Overheard")
            .field("host", &self.host)
            .finish_non_exhaustive()
    }
}
