//! A host in a world of virtual time: the bench, with the board's code in this process
//! or the firmware image under QEMU.

use std::fmt::Display;

use super::{LinkError, Options, Pace, Tap};
use crate::bench::board::Board;
use crate::bench::cosim::{Cosim, CosimError, Host};
use crate::bench::plant::Push;
use crate::held::Held;
use crate::log::event::Direction;

/// How often a host that is held back to the wall clock is asked at the least.
const ASK_US: u64 = 20_000;

/// Like [`drive`](super::drive), on this board.
pub fn run<B: Board, H: Host>(
    board: B,
    options: Options,
    host: H,
) -> (H, Result<(), LinkError<H::Error>>)
where
    B::Error: Display,
{
    let Options {
        bench,
        pace,
        taps,
        client,
        ..
    } = options;
    let visitor = Visitor {
        host,
        taps,
        held: match pace {
            Pace::Free => None,
            Pace::WallClock => Some(Held::begin()),
        },
        ask_us: 0,
        words: Vec::new(),
    };
    let mut cosim = Cosim::new(board, bench, visitor);
    if let Some(client) = client {
        cosim = cosim.with_client(client);
    }
    let result = cosim.run().map_err(|error| match error {
        CosimError::Board(error) => LinkError::Link(error.to_string()),
        CosimError::Host(error) => LinkError::Host(error),
    });
    (cosim.host.host, result)
}

/// The firmware image, booted; what it logs is left to `armbridge emulate` to show.
#[cfg(unix)]
pub(super) fn emulated(
    image: Option<&std::path::Path>,
) -> Result<crate::emulator::EmulatedBoard, crate::emulator::QemuError> {
    use crate::emulator::{EmulatedBoard, Qemu, QemuOptions, Time, log, qemu};

    let options = QemuOptions {
        image: image.map_or_else(qemu::default_image, Into::into),
        time: Time::Lockstep,
        icount: false,
        provoke: None,
    };
    let qemu = Qemu::start(&options)?;
    // Read all the same: a full socket would hold up the board.
    log::spawn(&options.image, qemu.log.try_clone()?, drop)?;
    EmulatedBoard::new(qemu)
}

/// A host with taps, held back to the wall clock or not.
struct Visitor<H> {
    host: H,
    taps: Vec<Box<dyn Tap>>,
    /// Whether it is.
    held: Option<Held>,
    ask_us: u64,
    words: Vec<u8>,
}

impl<H> Visitor<H> {
    fn notify_taps(&mut self, direction: Direction, now_us: u64, bytes: &[u8]) {
        if !bytes.is_empty() {
            for tap in &mut self.taps {
                tap.bytes(direction, now_us * 1_000, bytes);
            }
        }
    }

    /// Waits for the wall clock.
    fn hold_back(&mut self, now_us: u64) {
        if let Some(held) = &mut self.held {
            self.ask_us = now_us + ASK_US;
            held.wait(now_us);
        }
    }
}

impl<H: Host> Host for Visitor<H> {
    type Error = H::Error;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], H::Error> {
        self.hold_back(now_us);
        self.words.clear();
        self.words.extend_from_slice(self.host.transmit(now_us)?);
        let words = std::mem::take(&mut self.words);
        self.notify_taps(Direction::ToBoard, now_us, &words);
        self.words = words;
        Ok(&self.words)
    }

    fn receive(&mut self, now_us: u64, bytes: &[u8]) -> Result<(), H::Error> {
        self.notify_taps(Direction::ToHost, now_us, bytes);
        self.host.receive(now_us, bytes)
    }

    fn wake_at_us(&self) -> u64 {
        let asked_us = self.held.as_ref().map_or(u64::MAX, |_| self.ask_us);
        self.host.wake_at_us().min(asked_us)
    }

    fn is_done(&self) -> bool {
        self.host.is_done()
    }

    fn take_pushes(&mut self) -> Vec<Push> {
        self.host.take_pushes()
    }

    fn lifts_arm(&mut self) -> bool {
        self.host.lifts_arm()
    }
}
