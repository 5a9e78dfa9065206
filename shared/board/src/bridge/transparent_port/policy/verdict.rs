//! The verdict of the policy on a packet.

use crate::bridge::transparent_port::request::PendingRequest;
use crate::bridge::transparent_port::response::Bytes;
use armbridge_servo::ServoIds;

/// Treatment of a packet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The board queries the servos.
    Query(PendingRequest),
    /// The board answers in place of the servos.
    Answer(Bytes),
    /// The board refuses the packet, with this answer.
    Refuse(Bytes),
}

/// Whether a servo of this id is under control.
pub(super) fn is_controlled(controlled: ServoIds, id: u8) -> bool {
    controlled.iter().any(|servo| servo.get() == id)
}
