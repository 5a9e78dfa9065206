//! Co-simulation: board, bus, arm and host in one virtual time.
//!
//! Time jumps to the next event: a byte on the wire, an alarm of the board, a message
//! of the host. Nothing sleeps, and there is no fixed step. Two runs with the same seed
//! are equal to the bit. The link between board and host takes no time.

use std::fmt;
use std::sync::mpsc::Receiver;

use armbridge_board::bridge::transparent_port::ClientLine;
use armbridge_client::Host;
use armbridge_client::simulation::SimulationEvent;
use armbridge_link::server::Touch;
use armbridge_servo::JOINTS;

use crate::Bench;
use crate::board::{Board, Input, Output, Wake};
use crate::plant::{Lead, Push};

/// User interaction with the simulated arm.
#[derive(Clone, Debug, PartialEq)]
pub enum Interaction {
    /// Pushes it, see [`Bench::push`].
    Push(Push),
    /// Leads it by hand through a path, see [`Bench::lead`].
    Lead(Lead),
    /// Moves it by hand to these angles in this time, see [`Bench::move_by_hand`].
    Move {
        /// In rad.
        to_rad: [f64; JOINTS],
        /// In µs.
        duration_us: u64,
    },
    /// Moves it by hand to its initial angles, see [`Bench::lift`].
    Lift,
    /// Lets go of it.
    Release,
}

impl From<Touch> for Interaction {
    /// Now.
    fn from(touch: Touch) -> Self {
        match touch {
            Touch::Push {
                joint,
                torque_nm,
                duration_us,
            } => Self::Push(Push {
                joint: usize::from(joint),
                torque_nm: f64::from(torque_nm),
                // A start that has passed is now.
                start_ns: 0,
                duration_ns: u64::from(duration_us) * 1_000,
            }),
            Touch::Move {
                angle_rad,
                duration_us,
            } => Self::Move {
                to_rad: angle_rad.map(f64::from),
                duration_us: u64::from(duration_us),
            },
            Touch::Lift => Self::Lift,
            Touch::Release => Self::Release,
        }
    }
}

/// Client of the board's transparent port.
pub trait PortClient: fmt::Debug {
    /// Settings of its serial port.
    fn line(&self) -> ClientLine;

    /// Bytes of it for which the board has no room yet, before each
    /// [`transmit`](PortClient::transmit): a client without end must wait for them.
    fn set_waiting(&mut self, _bytes: usize) {}

    /// Bytes that it sends now.
    fn transmit(&mut self, now_us: u64) -> Vec<u8>;

    /// Processes bytes from the board.
    fn receive(&mut self, now_us: u64, bytes: &[u8]);

    /// Latest time of the next call.
    fn wake_at_us(&self) -> u64;
}

impl PortClient for Box<dyn PortClient> {
    fn line(&self) -> ClientLine {
        (**self).line()
    }

    fn set_waiting(&mut self, bytes: usize) {
        (**self).set_waiting(bytes);
    }

    fn transmit(&mut self, now_us: u64) -> Vec<u8> {
        (**self).transmit(now_us)
    }

    fn receive(&mut self, now_us: u64, bytes: &[u8]) {
        (**self).receive(now_us, bytes);
    }

    fn wake_at_us(&self) -> u64 {
        (**self).wake_at_us()
    }
}

/// No client.
#[derive(Clone, Copy, Debug)]
pub struct NoPortClient;

impl PortClient for NoPortClient {
    fn line(&self) -> ClientLine {
        ClientLine::default()
    }

    fn transmit(&mut self, _now_us: u64) -> Vec<u8> {
        Vec::new()
    }

    fn receive(&mut self, _now_us: u64, _bytes: &[u8]) {}

    fn wake_at_us(&self) -> u64 {
        u64::MAX
    }
}

/// Reason for the early end of a run.
#[derive(Debug)]
pub enum CosimError<B, H> {
    /// The board can no longer run.
    Board(B),
    /// Error of the host.
    Host(H),
}

/// Board, bench and host, and their time.
#[derive(Debug)]
pub struct Cosim<B, H, C = NoPortClient> {
    /// The board.
    pub board: B,
    /// Servos and arm.
    pub bench: Bench,
    /// The host at the other end of the link.
    pub host: H,
    client: C,
    interactions: Option<Receiver<Interaction>>,
    /// State of the emergency stop switch.
    pub is_stop_pressed: bool,
    now_us: u64,
    wake: Wake,
    received: Vec<u8>,
    output: Output,
}

impl<B: Board, H: Host> Cosim<B, H> {
    /// All three at time 0.
    pub fn new(board: B, bench: Bench, host: H) -> Self {
        Self {
            board,
            bench,
            host,
            client: NoPortClient,
            interactions: None,
            is_stop_pressed: false,
            now_us: 0,
            wake: Wake::default(),
            received: Vec::new(),
            output: Output::default(),
        }
    }

    /// The same, with a client at the transparent port.
    #[must_use]
    pub fn with_client<C: PortClient>(self, client: C) -> Cosim<B, H, C> {
        Cosim {
            client,
            board: self.board,
            bench: self.bench,
            host: self.host,
            interactions: self.interactions,
            is_stop_pressed: self.is_stop_pressed,
            now_us: self.now_us,
            wake: self.wake,
            received: self.received,
            output: self.output,
        }
    }
}

impl<B: Board, H: Host, C: PortClient> Cosim<B, H, C> {
    /// The same, with interactions, each executed at once.
    #[must_use]
    pub fn with_interactions(self, interactions: Receiver<Interaction>) -> Self {
        Self {
            interactions: Some(interactions),
            ..self
        }
    }

    /// Virtual time in µs.
    pub fn now_us(&self) -> u64 {
        self.now_us
    }

    /// Runs until the host is done.
    ///
    /// # Errors
    /// If the board can no longer run, or the host returns an error.
    pub fn run(&mut self) -> Result<(), CosimError<B::Error, H::Error>> {
        while !self.host.is_done() {
            self.step()?;
        }
        Ok(())
    }

    /// Advances to the next event.
    ///
    /// # Errors
    /// If the board can no longer run, or the host returns an error.
    pub fn step(&mut self) -> Result<(), CosimError<B::Error, H::Error>> {
        self.step_until(u64::MAX)
    }

    /// Advances to the next event, at most to `latest_us`.
    ///
    /// # Errors
    /// If the board can no longer run, or the host returns an error.
    pub fn step_until(&mut self, latest_us: u64) -> Result<(), CosimError<B::Error, H::Error>> {
        let Self {
            board,
            bench,
            host,
            client,
            interactions,
            received,
            output,
            is_stop_pressed,
            ..
        } = self;
        let others_us = host.wake_at_us().min(client.wake_at_us());
        let until_us = self.wake.at_us.min(others_us).min(latest_us);
        let until_us = until_us.max(self.now_us);
        received.clear();
        let now_us = bench.advance(until_us, self.wake.bus_bytes, received);

        for interaction in interactions.iter().flat_map(Receiver::try_iter) {
            match interaction {
                Interaction::Push(push) => bench.push(push),
                Interaction::Lead(lead) => bench.lead(&lead),
                Interaction::Move {
                    to_rad,
                    duration_us,
                } => bench.move_by_hand(to_rad, duration_us),
                Interaction::Lift => bench.lift(),
                Interaction::Release => bench.release(),
            }
        }
        // A tick begins at an alarm of the board.
        if now_us >= self.wake.at_us && host.takes_true_states() {
            host.simulated(&SimulationEvent::State(bench.true_state(now_us)));
        }
        while let Some(push) = bench.take_begun_push() {
            host.simulated(&SimulationEvent::Push(push));
        }
        let from_host = host.transmit(now_us).map_err(CosimError::Host)?;
        output.bus.clear();
        output.link.clear();
        output.client.clear();
        client.set_waiting(output.client_waiting);
        let from_client = client.transmit(now_us);
        let input = Input {
            bus: received,
            link: from_host,
            line: client.line(),
            client: &from_client,
            is_stop_pressed: *is_stop_pressed,
        };
        self.wake = board
            .run(now_us, input, output)
            .map_err(CosimError::Board)?;
        if output.bus_baud != 0 {
            bench.set_baud(output.bus_baud);
        }
        bench.send(now_us, &output.bus);
        client.receive(now_us, &output.client);
        host.receive(now_us, &output.link)
            .map_err(CosimError::Host)?;
        self.now_us = now_us;
        Ok(())
    }
}
