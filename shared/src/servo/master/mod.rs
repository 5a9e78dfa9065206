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
//!
//! # Two firmwares, one bus
//!
//! [`Master::set_line`] sets the servos' firmware and baud rate. A tick
//! is SYNC_WR and CYCLE on Morpheus servos, one `SYNC_WRITE` and a READ a servo on
//! stock ones; everything above is the same.
//!
//! | module          | what                                                  |
//! |-----------------|-------------------------------------------------------|
//! | [`Transaction`] | what can be asked                                     |
//! | `table`         | its steps; those of a tick are with the protocol      |
//! | [`timing`]      | how long servos may take, how long the wire must rest |
//! | `collect`       | received bytes, decoded; why something is missing     |
//! | `echo`          | separates our own echo from a reply                   |
//! | `step`          | what a step does to port and pin                      |

mod collect;
mod echo;
mod line;
mod step;
mod table;
pub mod timing;

pub use super::ExpectedReply;
/// Former name of [`ExpectedReply`].
pub use super::ExpectedReply as Asked;
pub use super::exchange::Readiness;
pub use super::transaction::{Outcome, Transaction};
pub use collect::Payload;

use super::ServoId;
use super::exchange::{GUARD_US, Line};
use super::port::{SetBaud, bytes_us};
use super::protocol1::Alarms;
use super::{Firmware, Missing, Sample};
use crate::JOINTS;
use crate::actuator::Pwm;
use collect::Collect;
use core::convert::Infallible;
use echo::Echo;
use embedded_hal::digital::OutputPin;
use embedded_hal_nb::serial::{Read, Write};

/// Reads from the port in one poll: the longest transmission's echo and more.
const DRAIN_MAX: usize = 256;
/// Bytes of the longest foreign packet.
pub const ASK_MAX: usize = 260;
/// Bytes overheard between two polls.
const OVERHEARD_MAX: usize = 256;

/// What is known before anything is asked.
const NOT_ASKED: [Sample; JOINTS] = [Sample::Missing(Missing::NotAsked); JOINTS];

/// A transaction is already under way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Busy;

/// Why a foreign packet is not sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AskError {
    /// A transaction is under way.
    Busy,
    /// It is longer than [`ASK_MAX`].
    TooLong,
}

/// What the master is doing on the wire.
#[derive(Debug)]
#[allow(clippy::large_enum_variant, reason = "there is no heap for a box")]
enum Phase {
    Idle,
    Pausing {
        until_us: u64,
    },
    Writing {
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
    line: Line,
    echo: Echo,
    phase: Phase,
    /// What is being sent, or was last.
    outgoing: heapless::Vec<u8, ASK_MAX>,
    /// What [`Master::ask`] was answered.
    reply: Option<Payload>,
    /// Whether bytes from the servos are kept for a client.
    listens_in: bool,
    overheard: heapless::Deque<u8, OVERHEARD_MAX>,
    transaction: Transaction,
    next_step: u8,
    begun_us: u64,
    /// When the wire was last known to carry something.
    active_us: u64,
    samples: [Sample; JOINTS],
    alarms: [Alarms; JOINTS],
}

impl<S, D> Master<S, D>
where
    S: Read<u8> + Write<u8> + SetBaud,
    D: OutputPin,
{
    /// A master for Morpheus servos at 1 Mbaud with these ids, joint by joint.
    /// The direction pin, high to send, is lowered at once.
    pub fn new(serial: S, direction: D, ids: [ServoId; JOINTS]) -> Self {
        let mut master = Self {
            serial,
            direction,
            line: Line {
                ids,
                firmware: Firmware::Morpheus,
                baud: super::port::BAUD_RATES[0],
                available_us: u32::MAX,
                readiness: Readiness::Unknown,
            },
            echo: Echo::default(),
            phase: Phase::Idle,
            outgoing: heapless::Vec::new(),
            reply: None,
            listens_in: false,
            overheard: heapless::Deque::new(),
            transaction: Transaction::Stop,
            next_step: 0,
            begun_us: 0,
            active_us: 0,
            samples: NOT_ASKED,
            alarms: [Alarms::NONE; JOINTS],
        };
        master.serial.set_baud(master.line.baud);
        master.drive_line(false);
        master
    }

    /// Whether bytes from the servos are kept for [`Master::overheard`], those
    /// that were not asked for too. What was kept is forgotten.
    pub fn listen_in(&mut self, on: bool) {
        self.listens_in = on;
        self.overheard.clear();
    }

    /// The oldest byte overheard and not yet taken.
    pub fn overheard(&mut self) -> Option<u8> {
        self.overheard.pop_front()
    }

    /// Sends a foreign packet and, if wanted, awaits a reply.
    ///
    /// # Errors
    /// [`AskError`]; nothing is sent then.
    pub fn ask(
        &mut self,
        packet: &[u8],
        asked: ExpectedReply,
        now_us: u64,
    ) -> Result<(), AskError> {
        if !self.is_idle() {
            return Err(AskError::Busy);
        }
        let outgoing = heapless::Vec::from_slice(packet).map_err(|_| AskError::TooLong)?;
        self.begin(Transaction::Ask(asked), now_us)
            .map_err(|Busy| AskError::Busy)?;
        self.outgoing = outgoing;
        Ok(())
    }

    /// What the last [`Master::ask`] was answered.
    pub fn reply(&self) -> Option<&Payload> {
        self.reply.as_ref()
    }

    /// Begins a transaction; poll it to its end.
    ///
    /// # Errors
    /// [`Busy`] while another is under way.
    pub fn begin(&mut self, transaction: Transaction, now_us: u64) -> Result<(), Busy> {
        if !matches!(self.phase, Phase::Idle) {
            return Err(Busy);
        }
        self.drain(now_us);
        self.transaction = transaction;
        self.next_step = 0;
        self.samples = NOT_ASKED;
        self.alarms = [Alarms::NONE; JOINTS];
        self.reply = None;
        self.begun_us = now_us.max(self.ready_at_us());
        self.phase = Phase::Pausing {
            until_us: self.begun_us,
        };
        Ok(())
    }

    /// Takes back an order to drive that has not been sent yet: it will be one to be off.
    pub fn withhold(&mut self) {
        if let (Transaction::Drive(pwm), 0) = (&mut self.transaction, self.next_step) {
            *pwm = [Pwm::OFF; JOINTS];
        }
    }

    /// Advances the transaction as far as it goes without waiting.
    ///
    /// # Errors
    /// `WouldBlock` while it is not over, or when there is none.
    pub fn poll(&mut self, now_us: u64) -> nb::Result<Outcome, Infallible> {
        if matches!(self.phase, Phase::Idle) {
            if self.listens_in {
                self.drain(now_us);
            }
            return Err(nb::Error::WouldBlock);
        }
        self.drain(now_us);
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
                    cursor,
                    repeats,
                    retry_us,
                } => {
                    while let Some(byte) = self.outgoing.get(*cursor) {
                        match self.serial.write(*byte) {
                            Err(nb::Error::WouldBlock) => {
                                *retry_us = now_us + bytes_us(1, self.line.baud);
                                return Err(nb::Error::WouldBlock);
                            }
                            // A byte the port refuses is a byte that is missing
                            // on the wire: the servos' checksum finds it.
                            Ok(()) | Err(nb::Error::Other(_)) => self.echo.sent(*byte),
                        }
                        *cursor += 1;
                        if *cursor == self.outgoing.len() && *repeats > 1 {
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
                        *expected_us = (*expected_us).max(now_us + bytes_us(1, self.line.baud));
                        return Err(nb::Error::WouldBlock);
                    }
                    Ok(()) | Err(nb::Error::Other(_)) => self.active_us = now_us,
                },
                Phase::Listening { collect, until_us } => {
                    if !collect.is_complete() && now_us < *until_us {
                        return Err(nb::Error::WouldBlock);
                    }
                    let echo = &self.echo;
                    collect.settle(
                        &mut self.samples,
                        &mut self.alarms,
                        echo.is_echoing(),
                        echo.is_disturbed(),
                    );
                    self.active_us = now_us;
                }
            }
            self.take_step(now_us);
        }
        Ok(Outcome {
            transaction: self.transaction,
            samples: self.samples,
            alarms: self.alarms,
            bus_us: now_us.saturating_sub(self.begun_us) as u32,
        })
    }

    /// Whether no transaction is under way.
    pub fn is_idle(&self) -> bool {
        matches!(self.phase, Phase::Idle)
    }

    /// When the wire has rested long enough for another request, in µs.
    pub fn ready_at_us(&self) -> u64 {
        self.active_us.saturating_add(GUARD_US)
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
            // The client wants every byte as it comes.
            _ if self.listens_in => Some(1),
            Phase::Listening { collect, .. } => Some(collect.bytes_wanted()),
            Phase::Idle
            | Phase::Pausing { .. }
            | Phase::Writing { .. }
            | Phase::Flushing { .. } => None,
        }
    }
}
