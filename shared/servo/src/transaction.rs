//! Transactions of the bus, and their outcomes.

use super::{Alarms, ExpectedReply, Sample};
use crate::{JOINTS, Pwm};

/// Requests on the bus. The servos' firmware is that of
/// [`Master::set_line`](super::master::Master::set_line).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transaction {
    /// All motors off, whatever runs on the servos and whatever state they are
    /// in. Takes about 8 ms at 1 Mbaud.
    Stop,
    /// All motors off that accept a plain command, with either firmware. Takes
    /// 0.4 ms at 1 Mbaud; the cases it does not cover are in [`stop`](super::stop).
    BriefStop,
    /// Presence test of the servo of this joint.
    Ping {
        /// Index of the joint.
        joint: usize,
    },
    /// Position chain of Morpheus servos: each learns its predecessor.
    Start,
    /// The control tick: a PWM for each servo, then all positions. Stock
    /// servos that are not prepared are given none.
    Drive([Pwm; JOINTS]),
    /// The control tick with motors off, for servos in any state: Morpheus
    /// servos are given PWM 1000, stock ones torque enable 0, prepared or not,
    /// and drive again only when torque is enabled again.
    HoldOff,
    /// All positions, and one servo switched off with the only packet that a wedged
    /// servo accepts. That servo applies changes only, so that first it is given a
    /// thousandth of the torque. Stock servos know no such state: to them the same
    /// as [`Transaction::Drive`] with motors off.
    StopWedged {
        /// Index of the servo's joint.
        joint: usize,
        /// Whether this is the step aside, the thousandth, and not off.
        is_side_step: bool,
    },
    /// The packet of [`Master::request`](super::master::Master::request).
    Request(ExpectedReply),
}

/// Result of a transaction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// The transaction.
    pub transaction: Transaction,
    /// Per joint: the position in counts for a tick; for a ping or START, 0 if the
    /// servo answered. A stop expects no reply.
    pub samples: [Sample; JOINTS],
    /// Per joint: the alarms in all replies of a stock servo.
    pub alarms: [Alarms; JOINTS],
    /// Duration in µs, from the first bit sent to the last byte received, or to the end
    /// of the window if something is missing.
    pub bus_us: u32,
}

impl Transaction {
    /// Whether the transaction gives no motor a torque.
    pub fn is_off(self) -> bool {
        match self {
            Self::Drive(pwm) => pwm == [Pwm::OFF; JOINTS],
            Self::Stop
            | Self::BriefStop
            | Self::Ping { .. }
            | Self::Start
            | Self::HoldOff
            | Self::StopWedged { .. } => true,
            Self::Request(_) => false,
        }
    }
}
