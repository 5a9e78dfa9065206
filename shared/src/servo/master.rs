//! The bus master: one transaction at a time, advanced by [`Master::poll`].
//!
//! The master owns the serial port and the direction pin of the half-duplex
//! line. It never blocks and never reads a clock: call `poll` when a byte has
//! arrived (or [`Master::bytes_wanted`] have), when a transmission is complete,
//! or at [`Master::wake_at_us`], whichever comes first. Being called more often
//! does no harm.
//!
//! # Turn-around
//!
//! A servo begins its reply 45 µs after the last stop bit of the request at the
//! earliest. The direction pin is lowered in the first poll after `flush`
//! reports that bit sent; be there within 40 µs. A servo holds the line for up
//! to 28 µs after its reply, and the master leaves it alone for [`GUARD_US`].

use super::BYTE_US;
use super::collect::{Awaited, Collect};
use super::echo::Echo;
use super::morpheus::{Packet, Request, ServoId};
use super::stop::{StopStep, stop_step};
use crate::JOINTS;
use crate::actuator::Pwm;
use crate::link::message::{Missing, Sample};
use core::convert::Infallible;
use embedded_hal::digital::{OutputPin, PinState};
use embedded_hal_nb::serial::{Read, Write};

/// Idle time before a request. The servo that spoke last hears nothing that
/// begins within 28 µs of its last stop bit; 50 µs are safe in PWM mode.
pub const GUARD_US: u64 = 50;

/// Pause between SYNC_WR and CYCLE. Of two packets closer than 20 µs a servo
/// processes only the newer. On the bench none is lost from 25 µs on, whatever
/// the phase of the two servos' loops; the rest is margin, 6 % of a tick at
/// 1 kHz, until real servos have been measured.
const DRIVE_GAP_US: u32 = 80;

/// From the end of CYCLE to the last byte of two replies takes 310 µs; with the
/// first servo dead its successor waits 169 µs more before it speaks.
const POSITIONS_WINDOW_US: u64 = 450;

/// A ping is answered within 87 µs, and the answer takes 60 µs.
const PING_WINDOW_US: u64 = 400;

/// START is answered 4.74 ms times the id later; rounded up.
const START_SLOT_US: u64 = 5_000;

/// Reads from the port in one poll: the longest transmission's echo and more.
const DRAIN_MAX: usize = 256;

/// What is known before anything is asked.
const NOBODY_ASKED: [Sample; JOINTS] = [Sample::Missing(Missing::NotAsked); JOINTS];

/// What can be asked of the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transaction {
    /// All motors off, whatever state the servos are in. Takes about 7 ms.
    Stop,
    /// Is the servo of this joint there?
    Ping {
        /// Index of the joint.
        joint: usize,
    },
    /// Line the servos up for the position chain.
    Start,
    /// Give each servo its PWM and collect all positions: the control tick.
    Drive([Pwm; JOINTS]),
}

/// How a transaction ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// What was asked.
    pub transaction: Transaction,
    /// Per joint: the position in counts for [`Transaction::Drive`]; for a ping
    /// or START, 0 if the servo answered. A stop asks nobody.
    pub samples: [Sample; JOINTS],
    /// From the first bit sent to the last byte heard, or to the end of the
    /// window if something is missing, in µs.
    pub bus_us: u32,
}

/// A transaction is already under way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Busy;

/// One step of a transaction.
enum Step {
    Send(Packet),
    Repeat(u8, u16),
    Pause { us: u32 },
    Listen(Awaited, u64),
}

impl Transaction {
    /// Steps as a table, built as they are needed; `None` ends the transaction.
    fn step(self, index: u8, ids: [ServoId; JOINTS]) -> Option<Step> {
        let send = |request: Request| Step::Send(request.encode());
        Some(match (self, index) {
            (Self::Stop, _) => match stop_step(index, ids)? {
                StopStep::Send(packet) => Step::Send(packet),
                StopStep::Repeat(byte, count) => Step::Repeat(byte, count),
                StopStep::Pause { us } => Step::Pause { us },
            },
            (Self::Ping { joint }, 0) => send(Request::Ping(*ids.get(joint)?)),
            (Self::Ping { joint }, 1) => Step::Listen(Awaited::Ping(joint), PING_WINDOW_US),
            (Self::Start, 0) => send(Request::Start),
            (Self::Start, 1) => {
                let last = ids.iter().map(|id| u64::from(id.get())).max().unwrap_or(0);
                Step::Listen(Awaited::Pings, (last + 1) * START_SLOT_US)
            }
            (Self::Drive([a, b]), 0) => {
                let [id_a, id_b] = ids;
                send(Request::Drive([(id_a, a), (id_b, b)]))
            }
            (Self::Drive(_), 1) => Step::Pause { us: DRIVE_GAP_US },
            (Self::Drive(_), 2) => send(Request::Cycle),
            (Self::Drive(_), 3) => Step::Listen(Awaited::Positions, POSITIONS_WINDOW_US),
            _ => return None,
        })
    }
}

/// What the master is doing on the wire.
#[derive(Debug)]
enum Phase {
    Idle,
    Pausing {
        until_us: u64,
    },
    Writing {
        packet: Packet,
        cursor: usize,
        repeats: u16,
        retry_us: u64,
    },
    Flushing {
        expected_us: u64,
    },
    Listening {
        collect: Collect,
        until_us: u64,
    },
}

/// The half-duplex bus master.
#[derive(Debug)]
pub struct Master<S, D> {
    serial: S,
    direction: D,
    ids: [ServoId; JOINTS],
    echo: Echo,
    phase: Phase,
    transaction: Transaction,
    next_step: u8,
    begun_us: u64,
    /// When the wire was last known to carry something.
    active_us: u64,
    samples: [Sample; JOINTS],
}

impl<S, D> Master<S, D>
where
    S: Read<u8> + Write<u8>,
    D: OutputPin,
{
    /// A master for the servos with these ids, joint by joint. The direction
    /// pin, high to send, is lowered at once.
    pub fn new(serial: S, direction: D, ids: [ServoId; JOINTS]) -> Self {
        let mut master = Self {
            serial,
            direction,
            ids,
            echo: Echo::default(),
            phase: Phase::Idle,
            transaction: Transaction::Stop,
            next_step: 0,
            begun_us: 0,
            active_us: 0,
            samples: NOBODY_ASKED,
        };
        master.drive_line(false);
        master
    }

    /// Begins a transaction; poll it to its end.
    ///
    /// # Errors
    /// [`Busy`] while another is under way.
    pub fn begin(&mut self, transaction: Transaction, now_us: u64) -> Result<(), Busy> {
        if !matches!(self.phase, Phase::Idle) {
            return Err(Busy);
        }
        self.drain();
        self.transaction = transaction;
        self.next_step = 0;
        self.samples = NOBODY_ASKED;
        self.begun_us = now_us.max(self.active_us.saturating_add(GUARD_US));
        self.phase = Phase::Pausing {
            until_us: self.begun_us,
        };
        Ok(())
    }

    /// Advances the transaction as far as it goes without waiting.
    ///
    /// # Errors
    /// `WouldBlock` while it is not over, or when there is none.
    pub fn poll(&mut self, now_us: u64) -> nb::Result<Outcome, Infallible> {
        if matches!(self.phase, Phase::Idle) {
            return Err(nb::Error::WouldBlock);
        }
        self.drain();
        // Every turn of the loop takes the transaction a step further, and a
        // transaction has few steps: this ends.
        loop {
            match &mut self.phase {
                Phase::Idle => break,
                Phase::Pausing { until_us } if now_us < *until_us => {
                    return Err(nb::Error::WouldBlock);
                }
                Phase::Pausing { .. } => {}
                Phase::Writing {
                    packet,
                    cursor,
                    repeats,
                    retry_us,
                } => {
                    while let Some(byte) = packet.get(*cursor) {
                        match self.serial.write(*byte) {
                            Err(nb::Error::WouldBlock) => {
                                *retry_us = now_us + BYTE_US;
                                return Err(nb::Error::WouldBlock);
                            }
                            // A byte the port refuses is a byte that is missing
                            // on the wire: the servos' checksum finds it.
                            Ok(()) | Err(nb::Error::Other(_)) => self.echo.sent(*byte),
                        }
                        *cursor += 1;
                        if *cursor == packet.len() && *repeats > 1 {
                            *repeats -= 1;
                            *cursor = 0;
                        }
                    }
                    self.phase = Phase::Flushing {
                        expected_us: self.active_us,
                    };
                    continue;
                }
                Phase::Flushing { expected_us } => match self.serial.flush() {
                    Err(nb::Error::WouldBlock) => {
                        *expected_us = (*expected_us).max(now_us + BYTE_US);
                        return Err(nb::Error::WouldBlock);
                    }
                    Ok(()) | Err(nb::Error::Other(_)) => self.active_us = now_us,
                },
                Phase::Listening { collect, until_us } => {
                    if !collect.is_complete() && now_us < *until_us {
                        return Err(nb::Error::WouldBlock);
                    }
                    let echo = &self.echo;
                    self.samples = collect.samples(echo.is_echoing(), echo.is_disturbed());
                    self.active_us = now_us;
                }
            }
            self.take_step(now_us);
        }
        Ok(Outcome {
            transaction: self.transaction,
            samples: self.samples,
            bus_us: now_us.saturating_sub(self.begun_us) as u32,
        })
    }

    /// Whether no transaction is under way.
    pub fn is_idle(&self) -> bool {
        matches!(self.phase, Phase::Idle)
    }

    /// When to poll again at the latest; `u64::MAX` when there is nothing to do.
    pub fn wake_at_us(&self) -> u64 {
        match self.phase {
            Phase::Idle => u64::MAX,
            Phase::Pausing { until_us } | Phase::Listening { until_us, .. } => until_us,
            Phase::Writing { retry_us, .. } => retry_us,
            Phase::Flushing { expected_us } => expected_us,
        }
    }

    /// How many bytes make it worth to poll before [`Master::wake_at_us`];
    /// `None` if none do. Polling at every byte is as good, and costs more.
    pub fn bytes_wanted(&self) -> Option<usize> {
        match &self.phase {
            Phase::Listening { collect, .. } => Some(collect.bytes_wanted()),
            Phase::Idle
            | Phase::Pausing { .. }
            | Phase::Writing { .. }
            | Phase::Flushing { .. } => None,
        }
    }

    /// Enters the next step, or ends the transaction.
    fn take_step(&mut self, now_us: u64) {
        let step = self.transaction.step(self.next_step, self.ids);
        self.next_step += 1;
        self.phase = match step {
            Some(Step::Send(packet)) => self.send(packet, 1, now_us),
            Some(Step::Repeat(byte, count)) => self.send(Packet::from_iter([byte]), count, now_us),
            Some(Step::Pause { us }) => Phase::Pausing {
                until_us: now_us + u64::from(us),
            },
            Some(Step::Listen(awaited, window_us)) => {
                self.drive_line(false);
                Phase::Listening {
                    collect: Collect::new(awaited),
                    until_us: now_us + window_us,
                }
            }
            None => {
                self.drive_line(false);
                self.echo.settle();
                Phase::Idle
            }
        };
    }

    fn send(&mut self, packet: Packet, repeats: u16, now_us: u64) -> Phase {
        self.drive_line(true);
        self.echo.begin();
        self.active_us = now_us + packet.len() as u64 * u64::from(repeats) * BYTE_US;
        Phase::Writing {
            packet,
            cursor: 0,
            repeats,
            retry_us: now_us,
        }
    }

    /// Takes what the receiver has, but no more than a receive buffer's worth:
    /// a port that reports errors for ever must not hold up the tick.
    fn drain(&mut self) {
        for _ in 0..DRAIN_MAX {
            match (self.serial.read(), &mut self.phase) {
                (Err(nb::Error::WouldBlock), _) => return,
                (Ok(byte), _) if self.echo.claims(byte) => {}
                (Ok(byte), Phase::Listening { collect, .. }) => collect.byte(byte, self.ids),
                (Err(nb::Error::Other(_)), Phase::Listening { collect, .. }) => {
                    collect.line_error();
                }
                // Outside a window: nobody was asked, nothing is believed.
                (Ok(_) | Err(nb::Error::Other(_)), _) => {}
            }
        }
    }

    /// Turns the line driver on or off. A pin that fails has no remedy here;
    /// the missing replies show it.
    fn drive_line(&mut self, on: bool) {
        let _ = self.direction.set_state(PinState::from(on));
    }
}
