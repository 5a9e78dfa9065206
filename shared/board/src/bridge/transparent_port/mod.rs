//! The transparent port: raw bus traffic for another program, as through a
//! `USB2Dynamixel`.
//!
//! | state of the bridge      | service for the client                            |
//! |--------------------------|---------------------------------------------------|
//! | torque off, bus released | its packets on the bus unchanged, every received byte |
//! | ticks, torque on or not  | harmless requests, in the slack of a tick         |
//!
//! While ticks run, no packet of the client is sent on the bus unchanged: the board
//! makes its own queries for reads of the client, and refuses packets that would
//! move, re-address or reset a servo under control, with the servo's own answer.
//!
//! | part               | content                                                 |
//! |--------------------|---------------------------------------------------------|
//! | [`Framer`]         | the client's bytes as whole packets; half a packet times out |
//! | [`decide`]         | policy for packets while ticks run                      |
//! | [`PendingRequest`] | the board's own queries for a packet, each fitted to its slot |
//! | `response`         | replies in the name of a servo                          |
//! | [`PortEnd`]        | the queues between the tick and the board's second port |
//! | `relay`            | the bus while it is lent to the client                  |
//! | `client_service`   | service of the client in the idle slots of ticks        |

mod client_service;
mod endpoints;
mod framer;
#[cfg(test)]
mod packets;
mod policy;
mod relay;
mod request;
mod response;

pub(super) use endpoints::{BusSide, CLIENT_BYTES};
pub use endpoints::{ClientLine, PortEnd};
pub use framer::{FrameKind, Framer};
pub use policy::{Verdict, decide};
pub use request::{BusQuery, PendingRequest, Progress};
pub use response::{BYTES_MAX, Bytes};

use super::limits::CLAIM_US;
use armbridge_link::message::PortCounters;

/// Shortest time between two reports of the counters, in µs.
const REPORT_US: u64 = 100_000;

/// The transparent port's state, as the tick keeps it.
pub(super) struct TransparentPort<'a> {
    client: BusSide<'a>,
    framer: Framer,
    /// A whole packet that waits; the framer holds its bytes.
    waiting: Option<FrameKind>,
    /// The client's request under way.
    pending: Option<PendingRequest>,
    /// Time since which it waits, in µs.
    since_us: u64,
    /// Number of attempts.
    tries: u8,
    /// The request or packet at hand had to wait for a later tick.
    has_waited: bool,
    counters: Counters,
    reported_us: u64,
    /// The client has opened its port since the bus was released.
    was_open: bool,
    /// The host has asked for the bus: no client takes it before this time.
    claimed_until_us: u64,
    /// Time of the last relayed packet in µs, and whether one of them may have set a motor
    /// moving.
    relayed_us: u64,
    may_have_driven: bool,
}

/// The counters of packets, and whether one has changed since they were reported.
#[derive(Debug, Default)]
struct Counters {
    counts: PortCounters,
    has_changed: bool,
}

impl Counters {
    /// The counts, of which one is to be changed.
    fn change(&mut self) -> &mut PortCounters {
        self.has_changed = true;
        &mut self.counts
    }
}

impl<'a> TransparentPort<'a> {
    /// A port whose client has sent nothing yet.
    pub(super) fn new(client: BusSide<'a>) -> Self {
        Self {
            client,
            framer: Framer::default(),
            waiting: None,
            pending: None,
            since_us: 0,
            tries: 0,
            has_waited: false,
            counters: Counters::default(),
            reported_us: 0,
            was_open: false,
            claimed_until_us: 0,
            relayed_us: 0,
            may_have_driven: false,
        }
    }

    /// Whether a client's request waits for the slack of a tick.
    pub(super) fn is_waiting(&self) -> bool {
        self.pending.is_some()
    }

    /// Whether a client has had the bus since it was last taken back.
    pub(super) fn has_relayed(&self) -> bool {
        self.was_open || self.may_have_driven
    }

    /// Whether there is nothing of a client's to work on, and nothing to report.
    pub(super) fn is_quiet(&self) -> bool {
        self.client.is_empty()
            && self.waiting.is_none()
            && self.framer.is_empty()
            && !self.counters.has_changed
    }

    /// Notes that the bus is taken back from the client.
    pub(super) fn end_relay(&mut self) {
        self.was_open = false;
        self.may_have_driven = false;
    }

    fn count(&mut self, is_passed: bool) {
        let has_waited = core::mem::take(&mut self.has_waited);
        let counters = self.counters.change();
        let which = if is_passed {
            &mut counters.passed
        } else {
            &mut counters.refused
        };
        *which = which.wrapping_add(1);
        if is_passed && has_waited {
            counters.delayed = counters.delayed.wrapping_add(1);
        }
    }

    /// Keeps clients off the bus for a while after an order of the host.
    pub(super) fn claim(&mut self, now_us: u64) {
        self.claimed_until_us = now_us.saturating_add(CLAIM_US);
    }
}
