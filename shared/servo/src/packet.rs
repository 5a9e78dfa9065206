//! Packets of the bridge: capacity, and the bytes on the wire.

use crate::JOINTS;

/// Longest request: [`Request::Drive`](super::morpheus::Request::Drive) for both servos.
pub const REQUEST_MAX: usize = 5 + 3 + 4 * JOINTS;

/// A packet of the bridge's own as it goes on the wire.
pub type Packet = heapless::Vec<u8, REQUEST_MAX>;
