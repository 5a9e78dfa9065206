//! Replies to the client, in the name of the servo that it addressed.

use armbridge_servo::protocol::Reply;
use armbridge_servo::{Alarms, ClientRequest, Firmware};
use heapless::Vec;

/// Bytes of the longest packet to client or bus: a stock servo's whole table has 56, 40 bytes of
/// an X servo's with all the stuffing that they can have 64.
pub const BYTES_MAX: usize = 64;

/// A packet for the client or for the bus. Empty for no answer.
pub type Bytes = Vec<u8, BYTES_MAX>;

/// The servo that the client addressed, in the name of which the board answers. A packet
/// to all servos, or to an id that none can have, is answered with silence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Responder {
    pub(super) firmware: Firmware,
    /// Id of the servo.
    pub(super) id: u8,
    /// Address of the client, where the protocol has one.
    pub(super) client: u8,
}

impl Responder {
    pub(super) fn for_request(request: &ClientRequest) -> Self {
        Self {
            firmware: request.firmware,
            id: request.destination,
            client: request.source,
        }
    }

    /// The packet of a reply. Morpheus has no alarms.
    pub(super) fn reply(self, alarms: Alarms, data: &[u8]) -> Bytes {
        let reply = Reply {
            id: self.id,
            alarms,
            data,
        };
        let packet = self.firmware.encode_reply(&reply, self.client);
        packet.unwrap_or_default()
    }

    /// The refusal of an instruction that the servo does not know.
    pub(super) fn refusal(self) -> Bytes {
        self.reply(Alarms::INSTRUCTION, self.firmware.refusal())
    }
}
