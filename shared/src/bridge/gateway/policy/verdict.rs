//! The verdict on a packet.

use crate::JOINTS;
use crate::bridge::gateway::request::PendingRequest;
use crate::bridge::gateway::response::Bytes;
use crate::servo::ServoId;

/// Treatment of a packet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The board asks the servos.
    Ask(PendingRequest),
    /// The board answers with what the servos would.
    Answer(Bytes),
    /// The board refuses it, with this answer.
    Refuse(Bytes),
}

/// Whether a servo of this id is under control.
pub(super) fn is_controlled(controlled: [ServoId; JOINTS], id: u8) -> bool {
    controlled.iter().any(|servo| servo.get() == id)
}
