//! A host that passes on the orders of other programs to its board.

use std::io;

use armbridge_link::frame::Encoder;
use armbridge_link::message::ToBoard;
use armbridge_link::schema;
use armbridge_link::server::LinkRole;

use super::listener::StopListener;
use super::{BoardKey, Order};
use crate::Host;
use crate::simulation::SimulationEvent;

/// A host, and the socket by which its board is stopped from a second terminal.
///
/// The host sends an order in its session, if it can; otherwise it is sent in front of the host's
/// bytes, out of the order of its frames.
pub struct StopRelay<H: Host> {
    /// The host.
    pub host: H,
    listener: Option<StopListener>,
    is_connected: bool,
    bytes: Vec<u8>,
    /// Error of the host, until the order that it ended with is answered.
    error: Option<H::Error>,
}

impl<H: Host> StopRelay<H> {
    /// No socket yet.
    pub fn new(host: H) -> Self {
        Self {
            host,
            listener: None,
            is_connected: true,
            bytes: Vec::new(),
            error: None,
        }
    }

    /// Whether an order waits for the board's report, which comes soon after the host's last
    /// message.
    fn is_waiting(&self) -> bool {
        self.listener.as_ref().is_some_and(StopListener::is_waiting)
    }

    /// The link is open, or open again.
    pub fn connected(&mut self) {
        self.is_connected = true;
    }

    /// Listens for orders, if it does not yet.
    ///
    /// # Errors
    /// If no socket can be made.
    pub fn listen(&mut self, board: &BoardKey) -> io::Result<()> {
        if self.listener.is_none() {
            self.listener = Some(StopListener::open(board)?);
        }
        Ok(())
    }
}

/// Bytes of an order that the host does not send.
fn frames(order: Order) -> Vec<u8> {
    // An empty frame ends a partial frame in the board's receiver.
    let mut bytes = vec![0];
    let mut encoder = Encoder::default();
    // A board that no host has greeted reports nothing: so a hello comes after the stop, which
    // needs none. It ends the host's session; of the two orders nothing is left to be driven.
    let hello = ToBoard::Hello(schema::HELLO);
    let messages: &[ToBoard] = match order {
        Order::Stop => &[ToBoard::Stop, hello],
        // A hello disarms.
        Order::Disarm => &[hello],
    };
    for message in messages {
        bytes.extend_from_slice(encoder.encode(message).1);
    }
    bytes
}

impl<H: Host> Host for StopRelay<H> {
    type Error = H::Error;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], H::Error> {
        let order = match &mut self.listener {
            Some(listener) if self.is_connected => listener.due(),
            Some(listener) => {
                listener.refuse();
                None
            }
            None => None,
        };
        if let Some(error) = self.error.take() {
            if !self.is_waiting() {
                return Err(error);
            }
            self.error = Some(error);
            return Ok(&[]);
        }
        let is_sent = match order {
            None => true,
            Some(Order::Stop) => self.host.emergency_stop(now_us),
            Some(Order::Disarm) => self.host.disarm(now_us),
        };
        let bytes = self.host.transmit(now_us)?;
        let Some(order) = order.filter(|_| !is_sent) else {
            return Ok(bytes);
        };
        self.bytes = frames(order);
        self.bytes.extend_from_slice(bytes);
        Ok(&self.bytes)
    }

    fn receive(&mut self, now_us: u64, bytes: &[u8]) -> Result<(), H::Error> {
        if let Some(listener) = &mut self.listener {
            listener.receive(bytes);
        }
        if self.error.is_some() {
            return Ok(());
        }
        match self.host.receive(now_us, bytes) {
            Err(error) if self.is_waiting() => {
                self.error = Some(error);
                Ok(())
            }
            result => result,
        }
    }

    fn wake_at_us(&self) -> u64 {
        self.host.wake_at_us()
    }

    fn is_done(&self) -> bool {
        self.host.is_done() && self.error.is_none() && !self.is_waiting()
    }

    fn emergency_stop(&mut self, now_us: u64) -> bool {
        self.host.emergency_stop(now_us)
    }

    fn disarm(&mut self, now_us: u64) -> bool {
        self.host.disarm(now_us)
    }

    fn link_role(&mut self, role: LinkRole) {
        self.host.link_role(role);
    }

    fn disconnected(&mut self, now_us: u64) {
        self.is_connected = false;
        self.host.disconnected(now_us);
    }

    fn takes_true_states(&self) -> bool {
        self.host.takes_true_states()
    }

    fn simulated(&mut self, event: &SimulationEvent) {
        self.host.simulated(event);
    }
}
