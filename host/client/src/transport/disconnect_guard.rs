//! Guard of a connection: sends a goodbye if the host does not.
//!
//! A host that panics, returns an error, or is dropped during a run has not switched the
//! motors off. So any end of a connection without the host's goodbye sends a hello and a
//! goodbye: the hello, because its number makes the board accept the frames after it,
//! and because it already disarms a board. If the bytes do not arrive, the board detects
//! the silence, brakes after 0.1 s and switches off after 0.5 s.

use std::time::{Duration, Instant};

use armbridge_link::frame::Encoder;
use armbridge_link::message::ToBoard;
use armbridge_link::schema;
use armbridge_link::server::{FromServer, ToServer};

use super::clock::Clock;
use super::link_filter::LinkFilter;
use crate::Tap;
use crate::event::Direction;
use crate::servo_bus::Line;

/// Time for reading the board's last bytes. Closing a socket with unread bytes discards
/// those that were sent on it.
const LINGER: Duration = Duration::from_millis(30);

/// A line, its taps, and whether a goodbye is due.
pub(super) struct Connection<'a> {
    line: Box<dyn Line>,
    taps: &'a mut [Box<dyn Tap>],
    clock: &'a Clock,
    is_goodbye_owed: bool,
    filter: LinkFilter,
    /// Of messages to the link's server.
    encoder: Encoder,
}

impl<'a> Connection<'a> {
    pub(super) fn new(line: Box<dyn Line>, taps: &'a mut [Box<dyn Tap>], clock: &'a Clock) -> Self {
        Self {
            line,
            taps,
            clock,
            is_goodbye_owed: true,
            filter: LinkFilter::default(),
            encoder: Encoder::default(),
        }
    }

    /// The host does not command: it owes no goodbye.
    pub(super) fn observe(&mut self) {
        self.is_goodbye_owed = false;
    }

    /// Sends a message to the link's server.
    pub(super) fn send_to_server(&mut self, message: &ToServer) -> std::io::Result<()> {
        self.line.send(self.encoder.encode(message).1)
    }

    /// Sends bytes, to the taps first.
    pub(super) fn send(&mut self, bytes: &[u8]) -> std::io::Result<()> {
        if bytes.is_empty() {
            return Ok(());
        }
        let now_ns = self.clock.now_ns();
        for tap in &mut *self.taps {
            tap.bytes(Direction::ToBoard, now_ns, bytes);
        }
        self.line.send(bytes)
    }

    /// Bytes received from the board until then, which the taps receive first. Calls
    /// `on_server` with each message of the link's server.
    pub(super) fn receive(
        &mut self,
        until: Instant,
        on_server: impl FnMut(FromServer),
    ) -> std::io::Result<Vec<u8>> {
        let received = self.line.receive(until)?;
        let bytes = self.filter.pass(&received, on_server);
        if !bytes.is_empty() {
            let now_ns = self.clock.now_ns();
            for tap in &mut *self.taps {
                tap.bytes(Direction::ToHost, now_ns, &bytes);
            }
        }
        Ok(bytes)
    }

    /// Marks that the host has sent its last message.
    pub(super) fn close(mut self) {
        self.is_goodbye_owed = false;
        self.linger();
    }

    fn linger(&mut self) {
        let until = Instant::now() + LINGER;
        while Instant::now() < until && self.receive(until, |_| {}).is_ok() {}
    }
}

impl Drop for Connection<'_> {
    fn drop(&mut self) {
        if !self.is_goodbye_owed {
            return;
        }
        let mut encoder = Encoder::default();
        // An empty frame ends a partial frame in the board's receiver.
        let mut words = vec![0];
        for word in [ToBoard::Hello(schema::HELLO), ToBoard::Goodbye] {
            words.extend_from_slice(encoder.encode(&word).1);
        }
        // Best effort: see above.
        if self.send(&words).is_ok() {
            self.linger();
        }
    }
}
