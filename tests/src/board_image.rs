//! A board's own image, executed: its ELF file on the emulated chip, virtual servos and an
//! arm on its bus, and a host of the client library at its USB cable.

use std::fmt::Debug;

use armbridge_client::Host;
use armbridge_client::event::EventKind;
use armbridge_link::message::{BoardReport, Record, ToHost};
use armbridge_sim::Bench;
use armbridge_sim::half_duplex_bus::ReceivedByte;
use armbridge_stm32_emulator::chip::Board;
use armbridge_stm32_emulator::image::Image;
use armbridge_stm32_emulator::line::Line;
use armbridge_stm32_emulator::machine::Machine;
use armbridge_stm32_emulator::peripherals::rcc::Reset;
use armbridge_stm32_emulator::peripherals::usart::{Received, Sent};
use armbridge_stm32_emulator::time::Time;
use armbridge_stm32_emulator::usb_host::{State, UsbHost};

use crate::paths;
use crate::random::Random;
use crate::tapped_bench::TappedHost;

/// Time from the pull-up of D+ to the host's first reset: a tenth of what hosts wait.
const DEBOUNCE: Time = Time::from_us(10_000);
/// Interval at which the host's program is called.
const HOST_INTERVAL: Time = Time::from_us(250);

/// Interference at the board's receiver: bytes from nowhere, at random times, and bytes of servos
/// with a bit turned. Both as a receiver reports them: with noise, or without a stop bit.
#[derive(Debug)]
pub struct Interference {
    draw: Random,
    mean_us: u64,
    next: Time,
}

impl Interference {
    /// A byte each `mean_us` on average, and one byte of a servo in a hundred.
    pub fn new(seed: u64, mean_us: u64) -> Self {
        Self {
            draw: Random::new(seed),
            mean_us,
            next: Time::ZERO,
        }
    }

    /// A byte from nowhere, if one is due.
    fn spurious(&mut self, now: Time) -> Option<Received> {
        if now < self.next {
            return None;
        }
        let at = self.next;
        self.next = now + Time::from_us(12 + self.draw.below(2 * self.mean_us));
        Some(Received {
            at,
            byte: self.draw.byte(),
            framing_error: self.draw.once_in(2),
            noise: self.draw.once_in(2),
        })
    }

    /// Damages a byte of a servo, perhaps.
    fn damage(&mut self, byte: &mut Received) {
        if self.draw.once_in(100) {
            byte.byte ^= 1 << self.draw.below(8);
            byte.noise = self.draw.once_in(2);
        }
    }
}

/// Servos and arm at the bus of an emulated board.
#[derive(Debug)]
pub struct BenchLine {
    /// Servos and arm.
    pub bench: Bench,
    /// Bytes that the board sent.
    pub sent: Vec<Sent>,
    /// Interference, if there is any.
    pub interference: Option<Interference>,
    received: Vec<ReceivedByte>,
    baud: u32,
}

impl Line for BenchLine {
    fn send(&mut self, byte: Sent) {
        self.sent.push(byte);
        self.bench.send_byte(byte.at.as_ns(), byte.byte, byte.baud);
    }

    fn set_baud(&mut self, baud: u32) {
        if baud != self.baud && baud != 0 {
            self.baud = baud;
            self.bench.set_baud(baud);
        }
    }

    fn advance(&mut self, now: Time, received: &mut Vec<Received>) {
        self.bench.advance_ns(now.as_ns(), &mut self.received);
        for byte in self.received.drain(..) {
            let mut byte = Received {
                at: Time::from_ns(byte.end_ns),
                byte: byte.byte,
                framing_error: byte.framing_error,
                noise: false,
            };
            if let Some(interference) = &mut self.interference {
                interference.damage(&mut byte);
            }
            received.push(byte);
        }
        if let Some(interference) = &mut self.interference {
            received.extend(interference.spurious(now));
        }
    }

    fn next(&self) -> Time {
        let bench = match self.bench.next_event_ns() {
            u64::MAX => Time::NEVER,
            ns => Time::from_ns(ns),
        };
        let interference = self.interference.as_ref();
        bench.min(interference.map_or(Time::NEVER, |interference| interference.next))
    }
}

/// A board that executes its image, and a host with a tap.
pub struct BoardRun<H> {
    /// The board.
    pub machine: Machine<BenchLine>,
    /// The host.
    pub host: TappedHost<H>,
    /// Why the host gave up, if it did.
    pub host_error: Option<String>,
}

/// The current image of a board.
///
/// # Panics
/// If it was not built.
pub fn image(name: &str) -> Image {
    let path = paths::firmware(name);
    let file = std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    Image::parse(&file).expect("an ELF file")
}

impl<H: Host> BoardRun<H>
where
    H::Error: Debug,
{
    /// A board with this image, its power still off.
    pub fn new(board: Board, image: &Image, bench: Bench, host: H) -> Self {
        let line = BenchLine {
            bench,
            sent: Vec::new(),
            interference: None,
            received: Vec::new(),
            baud: 0,
        };
        Self {
            machine: Machine::new(board, image, line, UsbHost::new(DEBOUNCE)),
            host: TappedHost::new(host),
            host_error: None,
        }
    }

    /// The same, powered up.
    ///
    /// # Panics
    /// If it has no vector table.
    #[must_use]
    pub fn powered_up(mut self) -> Self {
        self.machine.reset(Reset::PowerUp).expect("a vector table");
        self
    }

    /// Executes until `is_met`, which is asked at each call of the host, but not beyond a
    /// time in ms. False if it was not met.
    ///
    /// # Panics
    /// If the machine cannot go on.
    pub fn run_until(&mut self, latest_ms: u64, mut is_met: impl FnMut(&Self) -> bool) -> bool {
        let latest = Time::from_us(1_000 * latest_ms);
        while !is_met(self) {
            if self.machine.now() >= latest {
                return false;
            }
            let until = latest.min(self.machine.now() + HOST_INTERVAL);
            if let Err(halt) = self.machine.run(until) {
                panic!("{halt:x?} at {:.3} ms", self.machine.now().as_ms());
            }
            self.exchange();
        }
        true
    }

    /// Executes for a time in ms.
    pub fn run_for(&mut self, ms: u64) {
        let latest_ms = self.machine.now().as_us() / 1_000 + ms;
        self.run_until(latest_ms, |_| false);
    }

    /// Lets host and board talk.
    fn exchange(&mut self) {
        let now_us = self.machine.now().as_us();
        let usb = &mut self.machine.system.usb;
        if usb.state() != State::Configured || self.host_error.is_some() {
            return;
        }
        let received: Vec<u8> = usb.link.input.bytes.drain(..).collect();
        let result = if received.is_empty() {
            Ok(())
        } else {
            self.host.receive(now_us, &received)
        };
        match result.and_then(|()| self.host.transmit(now_us).map(<[u8]>::to_vec)) {
            Ok(bytes) => usb.link.output.bytes.extend(bytes),
            Err(error) => self.host_error = Some(format!("{error:?}")),
        }
        self.machine.system.touch();
    }

    /// Records that the host has received.
    pub fn records(&self) -> impl DoubleEndedIterator<Item = Record> {
        self.host
            .events
            .iter()
            .filter_map(|event| match event.kind {
                EventKind::Received(_, ToHost::Record(record)) => Some(record),
                _ => None,
            })
    }

    /// The last report of the board on itself.
    pub fn report(&self) -> Option<BoardReport> {
        let mut reports = self
            .host
            .events
            .iter()
            .filter_map(|event| match event.kind {
                EventKind::Received(_, ToHost::Board(report)) => Some(report),
                _ => None,
            });
        reports.next_back()
    }
}
