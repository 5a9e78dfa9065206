//! A host in the sense of the control link: what is at the board's other end.
//!
//! Sans-io and clockless. Whatever drives the link asks a [`Host`] for bytes, hands it
//! what the board sent, and tells it the time; so the same host runs over a serial port,
//! a socket, and in the virtual time of a simulation.

use std::convert::Infallible;

/// The host's end of a control link.
pub trait Host {
    /// Why it gives up.
    type Error;

    /// Bytes for the board now.
    ///
    /// # Errors
    /// If the host gives up.
    fn transmit(&mut self, now_us: u64) -> Result<&[u8], Self::Error>;

    /// Takes what the board sent.
    ///
    /// # Errors
    /// If the host gives up.
    fn receive(&mut self, now_us: u64, bytes: &[u8]) -> Result<(), Self::Error>;

    /// When to call [`transmit`](Host::transmit) again, at the latest.
    fn wake_at_us(&self) -> u64;

    /// Whether there is nothing left to do.
    fn is_done(&self) -> bool;

    /// The connection broke; what comes from now on is of another one.
    fn disconnected(&mut self, _now_us: u64) {}
}

/// No host: sends nothing, takes everything, and never ends.
#[derive(Clone, Copy, Debug)]
pub struct NoHost;

impl Host for NoHost {
    type Error = Infallible;

    fn transmit(&mut self, _now_us: u64) -> Result<&[u8], Infallible> {
        Ok(&[])
    }

    fn receive(&mut self, _now_us: u64, _bytes: &[u8]) -> Result<(), Infallible> {
        Ok(())
    }

    fn wake_at_us(&self) -> u64 {
        u64::MAX
    }

    fn is_done(&self) -> bool {
        false
    }
}
