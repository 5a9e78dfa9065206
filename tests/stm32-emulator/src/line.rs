//! The servo bus as the board sees it: bytes that it sends and receives, with their times.

use crate::peripherals::usart::{Received, Sent};
use crate::time::Time;

/// Whatever is at the other end of the bus.
pub trait Line {
    /// The board sends a byte, which begins now.
    fn send(&mut self, byte: Sent);

    /// Sets the rate at which the board receives.
    fn set_baud(&mut self, baud: u32);

    /// Executes all events up to `now`, and appends the bytes that the board has received.
    fn advance(&mut self, now: Time, received: &mut Vec<Received>);

    /// Time of the next event.
    fn next(&self) -> Time;
}
