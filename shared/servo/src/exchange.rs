//! The part of a protocol that the bus master runs: steps of a tick, and response
//! times of the servos.

use super::protocol::Protocol;
use super::transaction::Transaction;
use super::{ControlMode, ExpectedReply, Firmware, Packet, ServoIds};

/// Idle time before a request. The servo that sent last receives nothing that
/// begins within 28 µs of its last stop bit; 50 µs are safe in PWM mode.
pub const GUARD_US: u64 = 50;

/// A [`Protocol`] with which the master can run a control tick.
pub(super) trait Exchange: Protocol {
    /// Longest time in µs until a servo of unknown settings begins its reply.
    const LATENCY_US: u32;

    /// Idle time in µs before a request to the servo that sent last. Ticks ask the servos in
    /// turn, and need [`GUARD_US`] only.
    const SAME_SERVO_GUARD_US: u64;

    /// Longest time in µs that a reply to a request takes beyond its bytes, from a servo
    /// whose settings are known to be short or not.
    fn reply_latency_us(baud: u32, answers_soon: bool) -> u32;

    /// The shortest period in µs at which a tick's exchange with two servos, and
    /// the rest after it, is sure to be over.
    fn tick_us(baud: u32, readiness: Readiness) -> u32;

    /// Steps of a transaction that differs between protocols; `None` ends it.
    fn step(transaction: Transaction, index: u8, line: &Line) -> Option<Step>;
}

/// One step of a transaction.
pub(super) enum Step {
    Send(Packet),
    /// Send the packet of [`Master::request`](super::master::Master::request).
    SendRequest,
    Repeat(u8, u16),
    Pause {
        us: u32,
    },
    /// Listen for replies, for this time in µs at the most.
    Listen(ExpectedReplies, u64),
}

/// Set-up state of stock and X servos. Morpheus servos need no set-up.
///
/// The response time of a servo does not depend on its torque: the return delay is EEPROM,
/// and outlasts a stop and a loss of supply. A client that has the bus may change it, and
/// after a client servos are searched for. Another servo that is fitted meanwhile may
/// answer later: it counts as silent until a search has found it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Readiness {
    /// Their settings are not known: a reply may have the factory return delay.
    Unknown,
    /// The short return delay is set and torque is disabled: no torque can be given.
    Released,
    /// The short return delay is set, and wheel mode or the [`ControlMode`] with torque enabled.
    Prepared,
}

impl Readiness {
    /// Whether the short return delay is set.
    pub(crate) fn answers_soon(self) -> bool {
        self != Self::Unknown
    }
}

/// Parameters of the bus line, on which the steps depend.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub(super) ids: ServoIds,
    pub(super) firmware: Firmware,
    pub(super) baud: u32,
    pub(super) available_us: u32,
    pub(super) readiness: Readiness,
    /// What commands of prepared servos are.
    pub(super) mode: ControlMode,
    /// The shortest period of these, which every tick needs and divisions give.
    pub(super) least_period_us: u32,
}

/// Replies that the master listens for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ExpectedReplies {
    /// One reply, from the servo of this joint.
    Servo(usize, ReplyContent),
    /// A reply from every servo, one after the other: Morpheus's chain.
    Chain(ReplyContent),
    /// The positions of all X servos in one packet.
    Fast,
    /// The reply to the packet of [`Transaction::Request`].
    Request(ExpectedReply),
}

/// Content of a reply in the bridge's own exchanges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ReplyContent {
    /// The acknowledgement of a ping.
    Pong,
    /// The position.
    Position,
}
