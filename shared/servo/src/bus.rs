//! The half-duplex line, as the bus master uses it: [`Bus`].
//!
//! A board implements [`Bus`] on its hardware, where DMA moves the bytes and the
//! transmit-complete interrupt releases the line; or it has a serial port with
//! `embedded-hal-nb`'s traits and a pin with `embedded-hal`'s, of which
//! [`SerialBus`](super::serial_bus::SerialBus) makes a bus.
//!
//! # Contract
//!
//! * One transmission at a time: the master sends only when the one before is
//!   [`Complete`](Transmission::Complete).
//! * No call blocks, and none is made from two contexts at once.
//! * A servo may begin to answer 45 µs after the last stop bit, so the line is released by
//!   then. A bus that [releases the line by itself](Bus::RELEASES_BY_ITSELF) does so whatever
//!   the master does; another does it in [`Bus::transmission`], which the master calls at the
//!   computed end of the transmission.
//! * An error of the receiver is reported in its place among the bytes, once. A byte that was
//!   damaged or lost is never passed on as an intact one.

use embedded_hal_nb::serial::ErrorKind;

/// Bytes of the longest transmission: the flush of the stop sequence is 210, a client's packet
/// up to 260.
pub const SEND_MAX: usize = 260;

/// Driver of the line after a transmission.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineAfter {
    /// The master still does: another transmission follows a pause, in which noise has no
    /// idle line to disturb.
    Driven,
    /// The servos may: it is released with the last stop bit.
    Released,
}

/// State of the last transmission.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transmission {
    /// The port is full: ask again in a byte's time.
    Waiting,
    /// All bytes are in the port, and the last stop bit has not left.
    Sending,
    /// The last stop bit has left, or nothing was sent.
    Complete,
}

/// Received since the last call: bytes, and then an error, if there was one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Received<'a> {
    /// Intact bytes, the oldest first.
    pub bytes: &'a [u8],
    /// Error of the receiver after these bytes. More may have been received after it.
    pub error: Option<ErrorKind>,
}

/// A half-duplex line; see the [module](self).
pub trait Bus {
    /// Whether the line is released, or left driven, without a call at the end of a
    /// transmission. The master then does not wait for that end, but for what follows it.
    const RELEASES_BY_ITSELF: bool;

    /// Fastest rate in bits per second that the port makes within 1.5 %.
    const BAUD_MAX: u32;

    /// Sends and receives at this many bits per second from now on. Called only
    /// while nothing is being sent.
    fn set_baud(&mut self, baud: u32);

    /// Drives the line and sends these bytes back to back, [`SEND_MAX`] at the most.
    fn send(&mut self, bytes: &[u8], after: LineAfter);

    /// Time in µs from the `now_us` of the present poll to the begin of the last transmission:
    /// what the processor took for it.
    fn send_delay_us(&self) -> u32 {
        0
    }

    /// State of the last transmission.
    fn transmission(&mut self) -> Transmission;

    /// Releases the line, whatever is being sent.
    fn release(&mut self);

    /// Takes what has been received since the last call, or a part of it: call it until
    /// there is neither a byte nor an error.
    fn received(&mut self) -> Received<'_>;
}
