//! The part of a protocol that the bus master runs: steps of a tick, and how long
//! servos take.

use super::protocol::Protocol;
use super::transaction::Transaction;
use super::{ExpectedReply, Firmware, Packet, ServoId};
use crate::JOINTS;

/// Idle time before a request. The servo that sent last receives nothing that
/// begins within 28 µs of its last stop bit; 50 µs are safe in PWM mode.
pub const GUARD_US: u64 = 50;

/// A [`Protocol`] with which the master can run a control tick.
pub(super) trait Exchange: Protocol {
    /// Longest time in µs until a servo of unknown settings begins its reply.
    const LATENCY_US: u32;

    /// How much longer than its bytes the reply of a servo takes that bring-up has
    /// set, in µs.
    fn prepared_latency_us(baud: u32) -> u32;

    /// The shortest period in µs at which a tick's exchange with two servos, and
    /// the rest after it, is sure to be over.
    fn tick_us(baud: u32, readiness: Readiness) -> u32;

    /// Steps of a transaction that is another in each protocol; `None` ends it.
    fn step(transaction: Transaction, index: u8, line: &Line) -> Option<Step>;
}

/// One step of a transaction.
pub(super) enum Step {
    Send(Packet),
    /// Send the packet of [`Master::ask`](super::master::Master::ask).
    SendAsked,
    Repeat(u8, u16),
    Pause {
        us: u32,
    },
    /// Listen for replies, for this time in µs at the most.
    Listen(Awaited, u64),
}

/// How far stock servos are set up. Morpheus servos need no set-up.
///
/// How soon a servo answers does not depend on its torque: the return delay is EEPROM,
/// and outlasts a stop and a loss of supply. A client that has the bus may change it, and
/// after a client servos are searched for. Another servo that is fitted meanwhile may
/// answer later: it counts as silent until a search has found it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Readiness {
    /// Their settings are not known: an answer may come late.
    Unknown,
    /// They answer soon, and have let go of their shafts: no torque can be given.
    Released,
    /// They answer soon, and are in wheel mode with torque enabled.
    Prepared,
}

impl Readiness {
    /// Whether the short return delay is set.
    pub(in crate::servo) fn answers_soon(self) -> bool {
        self != Self::Unknown
    }
}

/// What the steps depend on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub(super) ids: [ServoId; JOINTS],
    pub(super) firmware: Firmware,
    pub(super) baud: u32,
    pub(super) available_us: u32,
    pub(super) readiness: Readiness,
}

/// Which replies are awaited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Awaited {
    /// Of the servo of this joint.
    One(usize, Answer),
    /// Of every servo, one after the other: Morpheus's chain.
    Each(Answer),
    /// To the packet of [`Transaction::Ask`].
    Reply(ExpectedReply),
}

/// What a reply of the bridge's own exchanges holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Answer {
    /// The servo is there.
    Pong,
    /// Its position.
    Position,
}
