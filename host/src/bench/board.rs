//! What the bench drives: a board that runs when it is told to.

use armbridge_shared::bridge::{Bridge, BridgeEnd, LinkEnd, LinkPort, Progress};
use armbridge_shared::link::message::{Mode, Refusal};

use super::uart::{Direction, Uart};

/// What a board wrote while it ran.
#[derive(Debug, Default)]
pub struct Output {
    /// Bytes for the servo bus, sent back to back from the time of the run.
    pub bus: Vec<u8>,
    /// Bytes for the host.
    pub link: Vec<u8>,
}

/// When a board wants to run again: at a time, or when so many bytes have come
/// from the bus, whichever is first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wake {
    /// At the latest, in µs.
    pub at_us: u64,
    /// After so many bytes, if any number will do.
    pub bus_bytes: Option<usize>,
}

/// A board in virtual time.
pub trait Board {
    /// Why the board can no longer be run.
    type Error;

    /// Hands over what has arrived, and runs the board at `now_us` until it has
    /// nothing left to do. Returns when it wants to run again.
    ///
    /// # Errors
    /// If the board is gone.
    fn run(
        &mut self,
        now_us: u64,
        from_bus: &[u8],
        from_host: &[u8],
        output: &mut Output,
    ) -> Result<Wake, Self::Error>;
}

/// The application core in this process: the same code as on a board, in the
/// order in which a board's priorities run it.
pub struct VirtualBoard<'a> {
    uart: Uart,
    bridge: Bridge<'a, Uart, Direction>,
    port: LinkPort<'a>,
}

impl<'a> VirtualBoard<'a> {
    /// A board just out of reset, with both ends of its mailboxes.
    ///
    /// # Errors
    /// If the default set-up has no controller.
    pub fn new((bridge, link): (BridgeEnd<'a>, LinkEnd<'a>)) -> Result<Self, Refusal> {
        let uart = Uart::default();
        Ok(Self {
            bridge: Bridge::new(uart.clone(), Direction, bridge, 0)?,
            port: LinkPort::new(link),
            uart,
        })
    }

    /// What the bridge is doing.
    pub fn mode(&self) -> Mode {
        self.bridge.mode()
    }
}

impl Board for VirtualBoard<'_> {
    type Error = std::convert::Infallible;

    fn run(
        &mut self,
        now_us: u64,
        from_bus: &[u8],
        from_host: &[u8],
        output: &mut Output,
    ) -> Result<Wake, Self::Error> {
        self.port.receive(from_host);
        self.uart.deliver(now_us, from_bus);
        while let Ok(progress) = self.bridge.poll(now_us) {
            if progress == Progress::Sampled {
                self.bridge.decide();
                self.bridge.publish(0);
            }
        }
        while let Some(frame) = self.port.transmit() {
            output.link.extend_from_slice(frame);
        }
        self.uart.take_sent(&mut output.bus);
        let wake_us = self.bridge.wake_at_us();
        let sent_us = self.uart.transmit_complete_us();
        Ok(Wake {
            at_us: sent_us.map_or(wake_us, |sent_us| wake_us.min(sent_us)),
            bus_bytes: self.bridge.bytes_wanted(),
        })
    }
}
