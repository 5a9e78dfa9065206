//! Host of a control link: the interface between a link and the code that uses it.
//!
//! Sans-io and clockless. The driver of the link takes bytes from a [`Host`], and passes it
//! the board's bytes and the time; so the same host runs over a serial port,
//! a socket, and in the virtual time of a simulation.

use std::convert::Infallible;

use crate::simulation::SimulationEvent;
use armbridge_link::server::LinkRole;

/// The host's end of a control link.
pub trait Host {
    /// Error that ends the run.
    type Error;

    /// Bytes for the board now.
    ///
    /// # Errors
    /// Error that ends the run.
    fn transmit(&mut self, now_us: u64) -> Result<&[u8], Self::Error>;

    /// Processes bytes from the board.
    ///
    /// # Errors
    /// Error that ends the run.
    fn receive(&mut self, now_us: u64, bytes: &[u8]) -> Result<(), Self::Error>;

    /// Latest time of the next call of [`transmit`](Host::transmit).
    fn wake_at_us(&self) -> u64;

    /// Whether there is nothing left to do.
    fn is_done(&self) -> bool;

    /// Another process asks for an emergency stop: true if the host sends it, with its next
    /// bytes. Otherwise the driver of the link sends it, out of the order of the host's
    /// frames.
    fn emergency_stop(&mut self, _now_us: u64) -> bool {
        false
    }

    /// Another process asks to disarm: true if the host does, with its next bytes. Otherwise
    /// the driver of the link ends the host's session with a hello.
    fn disarm(&mut self, _now_us: u64) -> bool {
        false
    }

    /// The server of the link announces the host's role; other links have no server.
    fn link_role(&mut self, _role: LinkRole) {}

    /// Notifies the host that the connection broke; later bytes belong to another one.
    fn disconnected(&mut self, _now_us: u64) {}

    /// Whether the states of a simulated arm are passed to [`simulated`](Host::simulated).
    fn takes_true_states(&self) -> bool {
        false
    }

    /// Event of the simulation behind the link.
    fn simulated(&mut self, _event: &SimulationEvent) {}
}

/// No host: sends nothing, ignores all bytes, and never ends.
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
