//! Taps: listeners to the raw bytes of a link, such as recorders and dashboards, and to the
//! simulation behind it.

use armbridge_link::server::LinkRole;

use crate::Host;
use crate::event::Direction;
use crate::simulation::SimulationEvent;

/// Listener to the raw bytes of a link. It is called on the thread that serves the link,
/// and must not block.
pub trait Tap: Send {
    /// Bytes that were written or read at this time (ns since 1970, or of virtual time).
    fn bytes(&mut self, direction: Direction, host_ns: u64, bytes: &[u8]);

    /// The connection broke at this time.
    fn disconnected(&mut self, host_ns: u64);

    /// Whether it takes the events of a simulation.
    fn takes_simulation(&self) -> bool {
        false
    }

    /// Event of the simulation behind the link.
    fn simulated(&mut self, _event: &SimulationEvent) {}
}

/// A host in virtual time with listeners to its link.
pub struct Tapped<H> {
    /// The host.
    pub host: H,
    taps: Vec<Box<dyn Tap>>,
}

impl<H> Tapped<H> {
    /// Adds these listeners to the host.
    pub fn new(host: H, taps: Vec<Box<dyn Tap>>) -> Self {
        Self { host, taps }
    }
}

fn notify(taps: &mut [Box<dyn Tap>], direction: Direction, now_us: u64, bytes: &[u8]) {
    if !bytes.is_empty() {
        for tap in taps {
            tap.bytes(direction, now_us.saturating_mul(1_000), bytes);
        }
    }
}

impl<H: Host> Host for Tapped<H> {
    type Error = H::Error;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], H::Error> {
        let bytes = self.host.transmit(now_us)?;
        notify(&mut self.taps, Direction::ToBoard, now_us, bytes);
        Ok(bytes)
    }

    fn receive(&mut self, now_us: u64, bytes: &[u8]) -> Result<(), H::Error> {
        notify(&mut self.taps, Direction::ToHost, now_us, bytes);
        self.host.receive(now_us, bytes)
    }

    fn wake_at_us(&self) -> u64 {
        self.host.wake_at_us()
    }

    fn is_done(&self) -> bool {
        self.host.is_done()
    }

    fn link_role(&mut self, role: LinkRole) {
        self.host.link_role(role);
    }

    fn disconnected(&mut self, now_us: u64) {
        for tap in &mut self.taps {
            tap.disconnected(now_us.saturating_mul(1_000));
        }
        self.host.disconnected(now_us);
    }

    fn takes_true_states(&self) -> bool {
        self.taps.iter().any(|tap| tap.takes_simulation()) || self.host.takes_true_states()
    }

    fn simulated(&mut self, event: &SimulationEvent) {
        for tap in self.taps.iter_mut().filter(|tap| tap.takes_simulation()) {
            tap.simulated(event);
        }
        self.host.simulated(event);
    }
}

impl<H: std::fmt::Debug> std::fmt::Debug for Tapped<H> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Tapped")
            .field("host", &self.host)
            .finish_non_exhaustive()
    }
}
