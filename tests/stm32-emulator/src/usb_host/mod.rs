//! A USB host at the board's cable: attaches, enumerates, and carries the control link and
//! the serial port.
//!
//! It does what the hosts of Linux and Windows do, in their order: debounce, reset, device
//! descriptor, address, descriptors and strings, Microsoft's descriptors, configuration.
//! After that it polls the pipes. One transaction is on the bus at a time, for as long as
//! its bits take. Data toggles are kept on both sides, so that a packet with the wrong one
//! is lost as it would be.
//!
//! | module     | contents                                                      |
//! |------------|---------------------------------------------------------------|
//! | [`control`]| one control transfer, stage by stage                          |
//! | [`enumeration`] | what a host asks a new device, and what it learns        |
//! | [`pipe`]   | a bulk pipe: its bytes and its toggle                         |

pub mod control;
pub mod enumeration;
pub mod pipe;

use crate::peripherals::otg::Otg;
use crate::time::Time;
use control::Transfer;
use enumeration::{Descriptors, Step};
use pipe::Pipe;

/// Longest packet of a full-speed bulk endpoint.
const PACKET: usize = 64;
/// A bus reset: at least 10 ms (USB 2.0, section 7.1.7.5).
const RESET: Time = Time::from_us(10_000);
/// Recovery after a reset (section 7.1.7.5).
const RECOVERY: Time = Time::from_us(10_000);
/// Idle time after which a device is suspended (section 7.1.7.6).
const SUSPEND: Time = Time::from_us(3_000);
/// Token, handshake, and gaps of a transaction.
const OVERHEAD: Time = Time::from_us(8);
/// A byte at 12 Mbit/s, with stuffed bits on average.
const BYTE: Time = Time::from_ns(700);

/// State of the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// No device: nothing pulls D+ up.
    Detached,
    /// A device, until the host believes it.
    Debounce {
        /// End.
        until: Time,
    },
    /// The bus is being reset.
    Reset {
        /// End.
        until: Time,
    },
    /// Time for the device after a reset.
    Recovery {
        /// End.
        until: Time,
    },
    /// Control transfers of the enumeration.
    Enumerating,
    /// Configured: the pipes are open.
    Configured,
    /// Configured, and suspended.
    Suspended,
    /// The host gave up: a request was refused.
    Failed,
}

/// Times at which a host sees the bus change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Change {
    /// Time of the change.
    pub at: Time,
    /// State from then on.
    pub state: State,
}

/// The host.
#[derive(Clone, Debug)]
pub struct UsbHost {
    /// Time from the pull-up to the first reset: 100 ms at least (section 7.1.7.3).
    pub debounce: Time,
    /// The cable is plugged in.
    pub is_plugged: bool,
    /// The host does not poll its IN pipes: its program stalls.
    pub is_stalled: bool,
    /// Pipes of the control link.
    pub link: Pipes,
    /// Pipes of the serial port.
    pub serial: Pipes,
    state: State,
    changes: Vec<Change>,
    descriptors: Descriptors,
    step: Step,
    transfer: Option<Transfer>,
    /// Requests to be sent once configured.
    requests: Vec<(enumeration::Request, Vec<u8>)>,
    /// End of the transaction in progress, at which it takes effect.
    transaction: Option<Time>,
    free_at: Time,
    turn: usize,
    pull_up: bool,
    pull_up_edges: Vec<(Time, bool)>,
}

/// Both directions of a function.
#[derive(Clone, Debug, Default)]
pub struct Pipes {
    /// To the board.
    pub output: Pipe,
    /// From the board.
    pub input: Pipe,
}

impl UsbHost {
    /// A host with the cable plugged in.
    pub fn new(debounce: Time) -> Self {
        Self {
            debounce,
            is_plugged: true,
            is_stalled: false,
            link: Pipes::default(),
            serial: Pipes::default(),
            state: State::Detached,
            changes: Vec::new(),
            descriptors: Descriptors::default(),
            step: Step::first(),
            transfer: None,
            requests: Vec::new(),
            transaction: None,
            free_at: Time::ZERO,
            turn: 0,
            pull_up: false,
            pull_up_edges: Vec::new(),
        }
    }

    /// State of the bus.
    pub fn state(&self) -> State {
        self.state
    }

    /// All states so far.
    pub fn changes(&self) -> &[Change] {
        &self.changes
    }

    /// Descriptors of the device.
    pub fn descriptors(&self) -> &Descriptors {
        &self.descriptors
    }

    /// Changes of the device's pull-up so far.
    pub fn pull_up_edges(&self) -> &[(Time, bool)] {
        &self.pull_up_edges
    }

    /// Sends a class request to the serial port: line coding, control lines.
    pub fn request(&mut self, request: enumeration::Request, data: Vec<u8>) {
        self.requests.push((request, data));
    }

    /// Resets the bus again, as a host does that resumes from hibernation.
    pub fn reset(&mut self, now: Time) {
        self.begin_reset(now);
    }

    /// Configures the device a second time, without a reset; the host's toggles begin anew.
    pub fn configure_again(&mut self) {
        self.requests
            .push((Step::Configure.request(&self.descriptors), Vec::new()));
        self.open_pipes();
    }

    fn open_pipes(&mut self) {
        let endpoints = self.descriptors.endpoints();
        self.link.output.open(endpoints.link_out);
        self.link.input.open(endpoints.link_in);
        self.serial.output.open(endpoints.serial_out);
        self.serial.input.open(endpoints.serial_in);
    }

    /// Suspends the bus.
    pub fn suspend(&mut self, now: Time, otg: &mut Otg) {
        if self.state == State::Configured {
            self.transaction = None;
            self.free_at = now + SUSPEND;
            otg.suspend();
            self.enter(now, State::Suspended);
        }
    }

    /// Resumes the bus.
    pub fn resume(&mut self, now: Time, otg: &mut Otg) {
        if self.state == State::Suspended {
            otg.resume();
            self.free_at = now + RECOVERY;
            self.enter(now, State::Configured);
        }
    }

    fn enter(&mut self, now: Time, state: State) {
        self.state = state;
        self.changes.push(Change { at: now, state });
    }

    fn begin_reset(&mut self, now: Time) {
        self.transaction = None;
        self.transfer = None;
        self.step = Step::first();
        self.descriptors = Descriptors::default();
        let until = now + RESET;
        self.enter(now, State::Reset { until });
    }

    /// Watches the pull-up: a device comes and goes.
    pub fn watch(&mut self, now: Time, otg: &Otg) {
        let pull_up = self.is_plugged && otg.is_pulled_up();
        if pull_up == self.pull_up {
            return;
        }
        self.pull_up = pull_up;
        self.pull_up_edges.push((now, pull_up));
        if pull_up {
            let until = now + self.debounce;
            self.enter(now, State::Debounce { until });
        } else {
            self.transaction = None;
            self.transfer = None;
            self.link = Pipes::default();
            self.serial = Pipes::default();
            self.enter(now, State::Detached);
        }
    }

    /// Begins a transaction if one has something to do. To be called after each change of the
    /// device's registers.
    pub fn poll(&mut self, now: Time, otg: &Otg) {
        self.watch(now, otg);
        if self.transaction.is_none() && self.has_work(otg) {
            let bytes = PACKET as u64;
            let duration = Time::from_ns(BYTE.as_ns() * bytes) + OVERHEAD;
            self.transaction = Some(now.max(self.free_at) + duration);
        }
    }

    fn has_work(&self, otg: &Otg) -> bool {
        match self.state {
            State::Enumerating => true,
            State::Configured => {
                self.transfer.is_some()
                    || !self.requests.is_empty()
                    || (0..4).any(|turn| self.is_ready(turn, otg))
            }
            _ => false,
        }
    }

    /// Whether a pipe could move a packet: link out, link in, serial out, serial in.
    fn is_ready(&self, turn: usize, otg: &Otg) -> bool {
        let pipes = if turn < 2 { &self.link } else { &self.serial };
        if turn.is_multiple_of(2) {
            let pipe = &pipes.output;
            pipe.is_open() && !pipe.bytes.is_empty() && otg.is_out_ready(pipe.endpoint())
        } else {
            let pipe = &pipes.input;
            pipe.is_open() && !self.is_stalled && otg.is_in_ready(pipe.endpoint())
        }
    }

    /// Time of its next event.
    pub fn next(&self) -> Time {
        match self.state {
            State::Debounce { until } | State::Reset { until } | State::Recovery { until } => until,
            _ => self.transaction.unwrap_or(Time::NEVER),
        }
    }

    /// Executes what is due at `now`.
    pub fn advance(&mut self, now: Time, otg: &mut Otg) {
        match self.state {
            State::Debounce { until } if until <= now => self.begin_reset(now),
            State::Reset { until } if until <= now => {
                otg.bus_reset();
                otg.enumerated();
                let until = now + RECOVERY;
                self.enter(now, State::Recovery { until });
            }
            State::Recovery { until } if until <= now => self.enter(now, State::Enumerating),
            _ => {}
        }
        if self.transaction.is_some_and(|at| at <= now) {
            self.transaction = None;
            self.free_at = now;
            match self.state {
                State::Enumerating => self.enumerate(now, otg),
                State::Configured => self.serve(otg),
                _ => {}
            }
        }
        self.poll(now, otg);
    }

    /// A transaction of the enumeration.
    fn enumerate(&mut self, now: Time, otg: &mut Otg) {
        let transfer = match &mut self.transfer {
            Some(transfer) => transfer,
            none => none.insert(Transfer::new(
                self.step.request(&self.descriptors),
                Vec::new(),
            )),
        };
        let Some(result) = transfer.transact(otg) else {
            return;
        };
        self.transfer = None;
        self.free_at = now + self.step.pause();
        let Some(next) = self.step.take(result, &mut self.descriptors) else {
            self.enter(now, State::Failed);
            return;
        };
        match next {
            Step::Done => {
                self.open_pipes();
                self.enter(now, State::Configured);
            }
            next => self.step = next,
        }
    }

    /// A transaction of a request or of the pipes, which take turns.
    fn serve(&mut self, otg: &mut Otg) {
        if self.transfer.is_none() && !self.requests.is_empty() {
            let (request, data) = self.requests.remove(0);
            self.transfer = Some(Transfer::new(request, data));
        }
        if let Some(transfer) = &mut self.transfer {
            if transfer.transact(otg).is_some() {
                self.transfer = None;
            }
            return;
        }
        let turns = (1..=4).map(|ahead| (self.turn + ahead) % 4);
        let Some(turn) = turns.into_iter().find(|turn| self.is_ready(*turn, otg)) else {
            return;
        };
        self.turn = turn;
        let pipes = if turn < 2 {
            &mut self.link
        } else {
            &mut self.serial
        };
        if turn.is_multiple_of(2) {
            pipes.output.send(otg);
        } else {
            pipes.input.receive(otg);
        }
    }
}
