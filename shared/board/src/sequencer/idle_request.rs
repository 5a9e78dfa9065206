//! Idle requests: queries for idle slots, each with its owner.

use super::force_off::OffCheck;
use super::health_poll::HealthRequest;
use super::setup_step::SetupStep;
use armbridge_servo::Query;

/// Owner of a request in an idle slot, who gets the reply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Owner {
    Off(OffCheck),
    Health(HealthRequest),
    SetUp(SetupStep),
    Client,
    /// A packet that is relayed: replies go to the client as they are received.
    Relay,
}

/// A request for an idle slot.
#[derive(Clone, Debug)]
pub(super) struct IdleRequest<const N: usize> {
    pub(super) query: Query<N>,
    pub(super) owner: Owner,
    /// Whether the next tick may begin late for the request.
    pub(super) may_be_late: bool,
}
