//! The bus master: one transaction at a time, advanced by [`Master::poll`].
//!
//! The master owns the [`Bus`], the half-duplex line. It never blocks and never reads a
//! clock: call `poll` when a byte has arrived (or [`Master::bytes_wanted`] have), or at
//! [`Master::wake_at_us`], whichever comes first. Being called more often does no harm.
//!
//! # Turn-around
//!
//! A servo begins its reply 45 µs after the last stop bit of the request at the
//! earliest, holds the line for up to 28 µs after its reply, and the master keeps the bus idle
//! for [`GUARD_US`].
//!
//! A bus that releases the line by itself needs no poll at the end of a transmission: pause
//! or receive window begin at its computed end, and a tick with Morpheus servos is three
//! polls: its begin, CYCLE, the end of the replies. Of another bus the master polls the end,
//! and times what follows from there; poll within 40 µs then.
//!
//! # Two firmwares, one bus
//!
//! [`Master::set_line`] sets the servos' firmware and baud rate. A tick
//! is SYNC_WR and CYCLE on Morpheus servos, one `SYNC_WRITE` and a READ a servo on
//! stock ones; everything above is the same.
//!
//! # Example
//!
//! A tick on a scripted line, at which two Morpheus servos answer CYCLE:
//!
//! ```
//! use armbridge_servo::bus::{Bus, LineAfter, Received, Transmission};
//! use armbridge_servo::master::{Master, Transaction};
//! use armbridge_servo::{Pwm, Sample, ServoId};
//!
//! const CYCLE: [u8; 6] = [0xAA, 3, 0xFF, 0xFE, 7, 0xF5];
//! const REPLIES: [u8; 14] = [0xAA, 4, 0xFE, 1, 1, 0xF4, 3, 0xAA, 4, 0xFE, 2, 1, 0xF5, 1];
//!
//! /// A line without echo, and whether replies wait on it.
//! struct Line(bool);
//!
//! impl Bus for Line {
//!     const RELEASES_BY_ITSELF: bool = true;
//!     const BAUD_MAX: u32 = 1_000_000;
//!     fn set_baud(&mut self, _baud: u32) {}
//!     fn send(&mut self, bytes: &[u8], _after: LineAfter) {
//!         self.0 = bytes == CYCLE;
//!     }
//!     fn transmission(&mut self) -> Transmission {
//!         Transmission::Complete
//!     }
//!     fn release(&mut self) {}
//!     fn received(&mut self) -> Received<'_> {
//!         let bytes: &[u8] = if std::mem::take(&mut self.0) { &REPLIES } else { &[] };
//!         Received { bytes, error: None }
//!     }
//! }
//!
//! let mut master = Master::new(Line(false), [1, 2].map(|id| ServoId::new(id).unwrap()));
//! let mut now_us = 0;
//! let mut run = |transaction| {
//!     master.begin(transaction, now_us).unwrap();
//!     loop {
//!         match master.poll(now_us) {
//!             Ok(outcome) => return outcome,
//!             // A board reads its clock here; time passes by itself.
//!             Err(_) => now_us = now_us.max(master.wake_at_us()),
//!         }
//!     }
//! };
//!
//! // First the stop sequence: it has no reply, and shows whether the line echoes.
//! run(Transaction::Stop);
//! let outcome = run(Transaction::Drive([Pwm::new(1_200).unwrap(), Pwm::OFF]));
//! assert_eq!(outcome.samples, [Sample::Counts(500), Sample::Counts(501)]);
//! ```
//!
//! | module          | content                                               |
//! |-----------------|-------------------------------------------------------|
//! | [`Transaction`] | requests on the bus                                   |
//! | `table`         | steps of a transaction; those of a tick are with the protocol |
//! | [`timing`]      | response times of servos, idle time of the bus        |
//! | `receiver`      | received bytes, decoded; causes of missing replies    |
//! | `echo`          | separation of our own echo from replies               |
//! | `step`          | effect of a step on the bus                           |

mod echo;
mod line;
mod receiver;
mod step;
mod table;
pub mod timing;

pub use super::ExpectedReply;
pub use super::exchange::Readiness;
pub use super::transaction::{Outcome, Transaction};
pub use receiver::Payload;

use super::bus::{Bus, SEND_MAX, Transmission};
use super::exchange::{GUARD_US, Line};
use super::port::bytes_us;
use super::{Alarms, Firmware, Missing, Sample, ServoIds};
use crate::{ControlMode, JOINTS, Pwm};
use core::convert::Infallible;
use echo::Echo;
use receiver::Receiver;
use timing::same_servo_guard_us;

/// Bytes and errors taken from the bus in one poll: the longest transmission's echo and more.
const DRAIN_MAX: usize = 256;
/// Bytes of the longest packet of [`Master::request`].
pub const REQUEST_BYTES_MAX: usize = SEND_MAX;
/// Bytes tapped between two polls.
const RX_TAP_BYTES: usize = 256;

/// Samples before a transaction has begun.
const NO_SAMPLES: [Sample; JOINTS] = [Sample::Missing(Missing::NotAsked); JOINTS];

/// A transaction is already under way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Busy;

/// Reason why a packet is not sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RequestError {
    /// A transaction is under way.
    Busy,
    /// The packet is longer than [`REQUEST_BYTES_MAX`].
    TooLong,
}

/// Phase of the step under way.
#[derive(Clone, Copy, Debug)]
enum Phase {
    Idle,
    /// The next step may begin from then on.
    Pausing {
        until_us: u64,
    },
    /// The end of the transmission is awaited; the time of the next look at it.
    Sending {
        until_us: u64,
    },
    Listening {
        until_us: u64,
    },
}

/// The half-duplex bus master.
#[derive(Debug)]
pub struct Master<B> {
    bus: B,
    line: Line,
    echo: Echo,
    phase: Phase,
    /// The bytes that are being sent, or were sent last; or those of a request to be sent.
    outgoing: heapless::Vec<u8, SEND_MAX>,
    /// Replies to the last request.
    receiver: Receiver,
    /// Whether bytes from the servos are kept in `rx_tap`, for a client.
    is_tapped: bool,
    rx_tap: heapless::Deque<u8, RX_TAP_BYTES>,
    transaction: Transaction,
    next_step: u8,
    begun_us: u64,
    /// Last known activity on the bus.
    active_us: u64,
    samples: [Sample; JOINTS],
    alarms: [Alarms; JOINTS],
}

impl<B: Bus> Master<B> {
    /// A master for Morpheus servos at 1 Mbaud with these ids, joint by joint. The line is
    /// released at once.
    pub fn new(bus: B, ids: impl Into<ServoIds>) -> Self {
        let mut master = Self {
            bus,
            line: Line {
                ids: ids.into(),
                firmware: Firmware::Morpheus,
                baud: super::port::BAUD_RATES[0],
                available_us: u32::MAX,
                readiness: Readiness::Unknown,
                mode: ControlMode::default(),
                least_period_us: 0,
            },
            echo: Echo::default(),
            phase: Phase::Idle,
            outgoing: heapless::Vec::new(),
            receiver: Receiver::default(),
            is_tapped: false,
            rx_tap: heapless::Deque::new(),
            transaction: Transaction::Stop,
            next_step: 0,
            begun_us: 0,
            active_us: 0,
            samples: NO_SAMPLES,
            alarms: [Alarms::NONE; JOINTS],
        };
        master.note_least_period();
        master.bus.set_baud(master.line.baud);
        master.bus.release();
        master
    }

    /// Sets whether bytes from the servos, requested or not, are kept for
    /// [`Master::take_tapped`]. Bytes kept so far are dropped.
    pub fn set_rx_tap(&mut self, on: bool) {
        self.is_tapped = on;
        self.rx_tap.clear();
    }

    /// Takes the oldest tapped byte.
    pub fn take_tapped(&mut self) -> Option<u8> {
        self.rx_tap.pop_front()
    }

    /// Sends a packet and, if a reply is expected, awaits it.
    ///
    /// # Errors
    /// [`RequestError`]; nothing is sent then.
    pub fn request(
        &mut self,
        packet: &[u8],
        expected: ExpectedReply,
        now_us: u64,
    ) -> Result<(), RequestError> {
        if !self.is_idle() {
            return Err(RequestError::Busy);
        }
        if packet.len() > SEND_MAX {
            return Err(RequestError::TooLong);
        }
        self.begin(Transaction::Request(expected), now_us)
            .map_err(|Busy| RequestError::Busy)?;
        self.set_outgoing(packet);
        Ok(())
    }

    /// Reply to the last [`Master::request`].
    pub fn reply(&self) -> Option<&Payload> {
        self.receiver.reply()
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
        self.begun_us = now_us.max(match transaction {
            Transaction::Request(expected) => self.ready_at_us(expected.id),
            _ => self.active_us.saturating_add(GUARD_US),
        });
        self.transaction = transaction;
        self.next_step = 0;
        self.samples = NO_SAMPLES;
        self.alarms = [Alarms::NONE; JOINTS];
        self.receiver.forget_reply();
        self.phase = Phase::Pausing {
            until_us: self.begun_us,
        };
        Ok(())
    }

    /// Replaces a drive command that has not been sent yet by motors off.
    pub fn cancel_drive(&mut self) {
        if let (Transaction::Drive(pwm), 0) = (&mut self.transaction, self.next_step) {
            *pwm = [Pwm::OFF; JOINTS];
        }
    }

    /// Advances the transaction as far as it goes without waiting.
    ///
    /// # Errors
    /// `WouldBlock` while it is not over, or when there is none.
    pub fn poll(&mut self, now_us: u64) -> nb::Result<Outcome, Infallible> {
        if self.is_idle() {
            if self.is_tapped {
                self.drain(now_us);
            }
            return Err(nb::Error::WouldBlock);
        }
        self.drain(now_us);
        // Every iteration advances the transaction by a step, and a transaction has few
        // steps: the loop ends.
        while !self.is_idle() {
            match self.phase {
                Phase::Idle => {}
                Phase::Pausing { until_us } => {
                    if now_us < until_us {
                        return Err(nb::Error::WouldBlock);
                    }
                    // A transmission that takes longer than computed is not cut short.
                    if self.bus.transmission() != Transmission::Complete {
                        let until_us = now_us + bytes_us(1, self.line.baud);
                        self.phase = Phase::Pausing { until_us };
                        return Err(nb::Error::WouldBlock);
                    }
                }
                Phase::Sending { until_us } => match self.bus.transmission() {
                    Transmission::Complete => self.active_us = now_us,
                    transmission => {
                        let soon_us = now_us + bytes_us(1, self.line.baud);
                        let until_us = match transmission {
                            Transmission::Waiting => soon_us,
                            _ => until_us.max(self.active_us).max(soon_us),
                        };
                        self.phase = Phase::Sending { until_us };
                        return Err(nb::Error::WouldBlock);
                    }
                },
                Phase::Listening { until_us } => {
                    if !self.receiver.is_complete() && now_us < until_us {
                        return Err(nb::Error::WouldBlock);
                    }
                    self.receiver.take_begun_parts(self.line.ids);
                    let echo = &self.echo;
                    self.receiver.finish(
                        &mut self.samples,
                        &mut self.alarms,
                        echo.is_echoing(),
                        echo.is_disturbed(),
                    );
                    self.active_us = now_us;
                }
            }
            self.enter_step(now_us);
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

    /// Time in µs at which the bus has been idle long enough for a request to this servo.
    pub fn ready_at_us(&self, id: u8) -> u64 {
        let guard_us = if self.last_id() == Some(id) {
            same_servo_guard_us(self.firmware())
        } else {
            GUARD_US
        };
        self.active_us.saturating_add(guard_us)
    }

    /// The servo that was asked last.
    fn last_id(&self) -> Option<u8> {
        let joint = match self.transaction {
            Transaction::Request(expected) => return Some(expected.id),
            Transaction::Ping { joint } => joint,
            Transaction::Drive(_)
            | Transaction::HoldOff
            | Transaction::StopWedged { .. }
            | Transaction::Start => self.line.ids.len() - 1,
            Transaction::Stop | Transaction::BriefStop => return None,
        };
        self.line.ids.get(joint).map(|id| id.get())
    }

    /// Latest time of the next poll; `u64::MAX` when there is nothing to do.
    pub fn wake_at_us(&self) -> u64 {
        match self.phase {
            Phase::Idle => u64::MAX,
            Phase::Pausing { until_us }
            | Phase::Sending { until_us }
            | Phase::Listening { until_us } => until_us,
        }
    }

    /// Number of received bytes that makes a poll before [`Master::wake_at_us`] useful;
    /// `None` if none does. Polling at every byte has the same result, and costs more.
    pub fn bytes_wanted(&self) -> Option<usize> {
        match self.phase {
            // The client wants every byte as it comes.
            _ if self.is_tapped => Some(1),
            Phase::Listening { .. } => Some(self.receiver.bytes_wanted() + self.echo.bytes_due()),
            Phase::Idle | Phase::Pausing { .. } | Phase::Sending { .. } => None,
        }
    }
}
