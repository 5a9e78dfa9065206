//! Idle request: a query for an idle slot, with its owner.

use super::force_off::OffCheck;
use super::health_poll::HealthRequest;
use super::setup_step::SetupStep;
use crate::servo::Query;

/// Whose a request in an idle slot is.
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
    /// A tick may begin late for it.
    pub(super) may_be_late: bool,
}
