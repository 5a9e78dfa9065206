//! States of the sequencer, and events of a poll.

use super::health_poll::Health;
use super::setup_step::SetupStep;
use crate::checkpoints::Checkpoints;
use armbridge_link::message::Missing;
use armbridge_servo::master::Outcome;
use armbridge_servo::{Firmware, JOINTS};

/// State of the sequencer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum State {
    /// The search for the servos is under way.
    Search(SearchStep),
    /// Motors are commanded off repeatedly.
    ForceOff,
    /// Motors are driven.
    Drive,
    /// The bus is lent to a client.
    Passthrough,
}

/// Step of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SearchStep {
    /// Stop sequence at the present speed.
    Stop,
    /// Ping of this joint's servo, in the protocol of this firmware.
    Ping {
        /// Index of the joint.
        joint: usize,
        /// Firmware whose protocol is used.
        firmware: Firmware,
    },
    /// Position chain of Morpheus servos.
    Start,
    /// Set-up of stock servos: read, made ready, or restored.
    SetUp(SetupStep),
}

/// Event of a poll.
#[derive(Clone, Copy, Debug)]
pub enum BusEvent {
    /// A tick's exchange is over; the tick's checkpoints, its own passed.
    Sampled(Outcome, Checkpoints),
    /// A step of a search or a stop is over; torque is off.
    Searching,
    /// The servos have been found and set up: ticks may begin.
    LinedUp,
    /// Stock servos have been restored: the bus is the client's.
    Restored,
    /// The servos run another firmware than before.
    FirmwareChanged,
    /// The servos run different firmwares; none is driven.
    Mixed([Firmware; JOINTS]),
    /// This joint's servo did not answer.
    Absent(usize, Missing),
    /// This joint's servo rejects its settings.
    Unprepared(usize),
    /// A health poll has been answered.
    Health(Health),
    /// The client's request has ended: see [`BusSequencer::reply`](super::BusSequencer::reply).
    Client,
    /// An idle slot has been used.
    Served,
}
