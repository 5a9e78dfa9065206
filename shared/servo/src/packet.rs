//! Packets of the bridge: capacity, and the bytes on the wire.

use crate::JOINTS;

/// Longest request: the goal PWM of all X servos.
pub const REQUEST_MAX: usize = 14 + 3 * JOINTS;

// That of Morpheus servos is shorter, see `morpheus::Request::Drive`.
const _: () = assert!(5 + 3 + 4 * JOINTS <= REQUEST_MAX);

/// A packet of the bridge's own as it goes on the wire.
pub type Packet = heapless::Vec<u8, REQUEST_MAX>;
