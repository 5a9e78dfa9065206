//! Requests, each with its expected reply.

use super::packet::REQUEST_MAX;
use heapless::Vec;

/// The reply that is expected to a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ExpectedReply {
    /// Servo that replies; a reply of any other is not accepted.
    pub id: u8,
    /// Bytes of the whole reply packet; 0 if there will be none.
    pub reply_bytes: u16,
    /// Longest time in µs from the end of the packet to the start of the reply.
    pub latency_us: u32,
}

impl ExpectedReply {
    /// No reply.
    pub const NONE: Self = Self {
        id: 0,
        reply_bytes: 0,
        latency_us: 0,
    };
}

/// A request to one servo, of up to `N` bytes, and the size of its reply.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Query<const N: usize = REQUEST_MAX> {
    /// Bytes to send.
    pub packet: Vec<u8, N>,
    /// Servo that replies.
    pub id: u8,
    /// Bytes of the whole reply packet; 0 if there will be none.
    pub reply_bytes: u16,
}

impl<const N: usize> Query<N> {
    /// The expected reply of a servo that begins it within this time.
    pub const fn expected_reply(&self, latency_us: u32) -> ExpectedReply {
        ExpectedReply {
            id: self.id,
            reply_bytes: self.reply_bytes,
            latency_us,
        }
    }
}
