//! Host on a board in virtual time: the board's code in this process or the firmware
//! image under QEMU.

use std::error::Error;

use armbridge_client::simulation::SimulationEvent;
use armbridge_client::tap::Tapped;
use armbridge_client::{Host, LinkError};

use super::{Options, Pace};
use crate::board::Board;
use crate::cosim::{Cosim, CosimError, NoPortClient};
use crate::pacer::Pacer;

/// Longest interval between two calls of a paced host.
const CALL_INTERVAL_US: u64 = 20_000;

/// Like [`drive`](super::drive), on this board.
pub fn run<B: Board, H: Host>(
    board: B,
    options: Options,
    host: H,
) -> (H, Result<(), LinkError<H::Error>>)
where
    B::Error: Error + Send + Sync + 'static,
{
    let paced = Paced {
        host: Tapped::new(host, options.link.taps),
        pacer: match options.pace {
            Pace::Free => None,
            Pace::WallClock => Some(Pacer::begin()),
        },
        next_call_us: match options.pace {
            Pace::Free => u64::MAX,
            Pace::WallClock => 0,
        },
    };
    let client = options.client.unwrap_or_else(|| Box::new(NoPortClient));
    let mut cosim = Cosim::new(board, options.bench, paced).with_client(client);
    if let Some(interactions) = options.interactions {
        cosim = cosim.with_interactions(interactions);
    }
    let result = cosim.run().map_err(|error| match error {
        CosimError::Board(error) => LinkError::Link(error.into()),
        CosimError::Host(error) => LinkError::Host(error),
    });
    (cosim.host.host.host, result)
}

/// A host with an optional pacer.
struct Paced<H> {
    host: H,
    pacer: Option<Pacer>,
    next_call_us: u64,
}

impl<H: Host> Host for Paced<H> {
    type Error = H::Error;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], H::Error> {
        if let Some(pacer) = &mut self.pacer {
            self.next_call_us = now_us + CALL_INTERVAL_US;
            pacer.wait(now_us);
        }
        self.host.transmit(now_us)
    }

    fn receive(&mut self, now_us: u64, bytes: &[u8]) -> Result<(), H::Error> {
        self.host.receive(now_us, bytes)
    }

    fn wake_at_us(&self) -> u64 {
        self.host.wake_at_us().min(self.next_call_us)
    }

    fn is_done(&self) -> bool {
        self.host.is_done()
    }

    fn takes_true_states(&self) -> bool {
        self.host.takes_true_states()
    }

    fn simulated(&mut self, event: &SimulationEvent) {
        self.host.simulated(event);
    }
}
