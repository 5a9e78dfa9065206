//! Frames of another master, the client of the transparent port.
//!
//! A frame is parsed once; policy and passthrough depend on its fields, never on
//! offsets. [`ClientFrame::expected_reply`] gives the time for which the bus must
//! be left alone after it, [`ClientFrame::may_drive`] whether it may set a motor moving,
//! [`ClientFrame::wedges_servo`] whether it blocks a servo until power-off.

use super::dispatch::with_protocol;
use super::protocol::Protocol;
use super::stop::FLUSH;
use super::{DecodeError, ExpectedReply, Firmware, Instruction};

/// A complete packet of a client, parsed.
///
/// ```
/// use armbridge_servo::protocol1::{Instruction, register};
/// use armbridge_servo::{ClientRequest, Firmware};
///
/// let read = Instruction::Read { address: register::PRESENT_POSITION, count: 2 };
/// let drive = Instruction::Write { address: register::MOVING_SPEED, data: &[0, 2] };
/// let [read, drive] = [read, drive].map(|it| it.encode::<16>(1).unwrap());
/// let parse = |bytes| ClientRequest::parse(Firmware::Stock, bytes).unwrap();
///
/// assert!(!parse(&read).may_drive());
/// assert_eq!(parse(&read).expected_reply().reply_bytes, 8);
/// assert!(parse(&drive).may_drive());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClientRequest<'a> {
    /// Firmware whose protocol the packet uses.
    pub firmware: Firmware,
    /// Servo that is addressed, or the protocol's broadcast.
    pub destination: u8,
    /// Address of the client. Protocol 1.0 has none: the destination again.
    pub source: u8,
    /// Instruction, if a servo knows it.
    pub instruction: Result<Instruction<'a>, DecodeError>,
    /// Whether the checksum is right. A servo may obey a packet that is not:
    /// Morpheus applies a PWM before it looks.
    pub is_intact: bool,
    /// Bytes of the packet.
    pub bytes: &'a [u8],
    /// Bytes of all replies, and the longest time until they begin in µs.
    expected: (u16, u32),
    /// Whether the source is an address of a master.
    is_from_master: bool,
    /// Whether the packet is longer than any may be.
    is_overlong: bool,
}

impl<'a> ClientRequest<'a> {
    /// The request in these bytes; `None` if they are not one whole packet.
    pub fn parse(firmware: Firmware, bytes: &'a [u8]) -> Option<Self> {
        with_protocol!(firmware, P => Self::parse_as::<P>(bytes))
    }

    fn parse_as<P: Protocol>(bytes: &'a [u8]) -> Option<Self> {
        let frame = P::frame(bytes)?;
        let (destination, source) = P::addresses(&frame);
        let instruction = if P::is_stuffed(bytes) {
            Err(DecodeError::Stuffing)
        } else {
            P::instruction(&frame)
        };
        Some(Self {
            firmware: P::FIRMWARE,
            destination,
            source,
            instruction,
            is_intact: P::is_intact(bytes),
            bytes,
            expected: P::expected(instruction, destination == P::BROADCAST),
            is_from_master: P::is_master(source),
            is_overlong: bytes.len() > P::FRAME_MAX,
        })
    }

    /// Whether every servo is addressed.
    pub fn is_broadcast(&self) -> bool {
        self.destination == self.firmware.broadcast()
    }

    /// Whether the source is an address of a master, so that replies reach no
    /// servo. A Morpheus servo takes a reply that is addressed to it for a request.
    pub fn is_from_master(&self) -> bool {
        self.is_from_master
    }

    /// The replies to the packet: the bus must be idle for them, so that the next packet
    /// does not collide with them.
    pub fn expected_reply(&self) -> ExpectedReply {
        let (reply_bytes, latency_us) = self.expected;
        if reply_bytes == 0 {
            return ExpectedReply::NONE;
        }
        ExpectedReply {
            id: self.destination,
            reply_bytes,
            latency_us,
        }
    }

    /// Whether the packet could set a motor moving, now or later, or change a servo: true
    /// of every write and reset, and in doubt.
    ///
    /// PING, READ, START and CYCLE are harmless, unless their source may be a
    /// Morpheus servo (an address below 0x20, or broadcast): that servo would take
    /// the replies for requests, and a register's contents for an instruction.
    pub fn may_drive(&self) -> bool {
        use Instruction::{Cycle, FastSyncRead, Ping, Read, Start, SyncRead};
        let is_read_only = matches!(
            self.instruction,
            Ok(Ping | Read { .. } | SyncRead { .. } | FastSyncRead { .. } | Start | Cycle)
        );
        !(is_read_only && self.is_from_master)
    }

    /// Whether the packet makes every Morpheus servo that receives it ignore commands until
    /// power-off. Never send it, not even while nothing is driven.
    pub fn wedges_servo(&self) -> bool {
        self.is_overlong
    }
}

/// Bytes of a client that are sent on the bus together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClientFrame<'a> {
    /// A complete packet.
    Request(ClientRequest<'a>),
    /// Bytes that are no packet of any protocol here.
    Raw(&'a [u8]),
}

impl<'a> ClientFrame<'a> {
    /// The frame in these bytes: a packet of this firmware's protocol, if one is
    /// given.
    pub fn new(firmware: Option<Firmware>, bytes: &'a [u8]) -> Self {
        firmware
            .and_then(|firmware| ClientRequest::parse(firmware, bytes))
            .map_or(Self::Raw(bytes), Self::Request)
    }

    /// The packet, if it is one.
    pub fn request(&self) -> Option<&ClientRequest<'a>> {
        match self {
            Self::Request(request) => Some(request),
            Self::Raw(_) => None,
        }
    }

    /// The bytes as received.
    pub fn bytes(&self) -> &'a [u8] {
        match self {
            Self::Request(ClientRequest { bytes, .. }) | Self::Raw(bytes) => bytes,
        }
    }

    /// See [`ClientRequest::expected_reply`].
    pub fn expected_reply(&self) -> ExpectedReply {
        self.request()
            .map_or(ExpectedReply::NONE, ClientRequest::expected_reply)
    }

    /// See [`ClientRequest::may_drive`]. Raw bytes may be the rest of a packet that
    /// a servo still waits for; only a flush is known to be harmless.
    pub fn may_drive(&self) -> bool {
        match self {
            Self::Request(request) => request.may_drive(),
            Self::Raw(bytes) => bytes.iter().any(|byte| *byte != FLUSH),
        }
    }

    /// See [`ClientRequest::wedges_servo`].
    pub fn wedges_servo(&self) -> bool {
        self.request().is_some_and(ClientRequest::wedges_servo)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::master::timing::latency_us;
    use crate::{morpheus, protocol1};
    use std::vec::Vec;

    fn stock(id: u8, code: u8, parameters: &[u8]) -> Vec<u8> {
        let frame = protocol1::Frame {
            id,
            code,
            parameters,
        };
        frame.encode::<260>().unwrap().to_vec()
    }

    /// A Morpheus packet, of any length.
    fn morpheus(destination: u8, source: u8, data: &[u8]) -> Vec<u8> {
        let mut bytes = std::vec![0xAA, data.len() as u8 + 2, destination, source];
        bytes.extend_from_slice(data);
        bytes.push(morpheus::checksum(&bytes[1..]));
        bytes
    }

    fn frame(bytes: &[u8]) -> ClientFrame<'_> {
        let firmware = match bytes.first() {
            Some(0xAA) => Firmware::Morpheus,
            _ => Firmware::Stock,
        };
        ClientFrame::Request(ClientRequest::parse(firmware, bytes).unwrap())
    }

    #[test]
    fn replies_are_expected_where_servos_send_them() {
        let cases = [
            (stock(1, 1, &[]), 1, 6),
            (stock(1, 2, &[36, 8]), 1, 14),
            (stock(1, 3, &[25, 1]), 1, 6),
            (stock(1, 0x92, &[0]), 1, 6),
            // Of the packets to all servos, only PING is answered.
            (stock(0xFE, 1, &[]), 0xFE, 6),
            (stock(0xFE, 2, &[36, 8]), 0, 0),
            (stock(0xFE, 0x83, &[30, 1, 1, 0]), 0, 0),
            (morpheus(2, 0xFE, &[1]), 2, 6),
            (morpheus(2, 0xFE, &[2, 0, 11]), 2, 16),
            (morpheus(2, 0xFE, &[2, 0, 255]), 2, 255),
            (morpheus(2, 0xFE, &[3, 0x10, 0, 0]), 2, 6),
            (morpheus(0xFF, 0xFE, &[7]), 0xFF, 14),
            (morpheus(0xFF, 0xFE, &[3, 0x10, 0, 0]), 0, 0),
        ];
        for (bytes, id, reply_bytes) in cases {
            let frame = frame(&bytes);
            let firmware = frame.request().unwrap().firmware;
            let expected = ExpectedReply {
                id,
                reply_bytes,
                latency_us: if reply_bytes > 0 {
                    latency_us(firmware)
                } else {
                    0
                },
            };
            assert_eq!(frame.expected_reply(), expected, "{bytes:x?}");
        }
        let start = morpheus(0xFF, 0xFE, &[6]);
        assert_eq!(frame(&start).expected_reply().latency_us, 20_000);
        assert_eq!(
            ClientFrame::new(None, &start).expected_reply(),
            ExpectedReply::NONE
        );
    }

    #[test]
    fn only_reading_packets_are_known_not_to_drive() {
        for harmless in [
            stock(1, 1, &[]),
            stock(0xFE, 1, &[]),
            stock(1, 2, &[36, 2]),
            morpheus(1, 0xFE, &[1]),
            morpheus(1, 0x64, &[2, 0x0C, 4]),
            morpheus(0xFF, 0xFE, &[6]),
            morpheus(0xFF, 0xFE, &[7]),
        ] {
            assert!(!frame(&harmless).may_drive(), "{harmless:x?}");
        }
        for driving in [
            stock(1, 3, &[24, 0]),
            stock(1, 4, &[30, 0, 2]),
            stock(0xFE, 5, &[]),
            stock(1, 6, &[]),
            stock(1, 8, &[]),
            stock(1, 2, &[36, 2, 0]),
            stock(0xFE, 0x83, &[32, 2, 1, 0, 2]),
            stock(0xFE, 0x92, &[0, 2, 1, 36]),
            morpheus(1, 0xFE, &[3, 0x10, 0xE8, 3]),
            morpheus(0xFF, 0xFE, &[0x83, 0x10, 2, 1, 0xDC, 5]),
            morpheus(1, 0xFE, &[9]),
            morpheus(1, 0xFE, &[5]),
            morpheus(1, 0xFE, &[]),
            // Servo 2 would take the reply for a request.
            morpheus(1, 2, &[2, 0x0C, 4]),
            morpheus(1, 0xFF, &[1]),
        ] {
            assert!(frame(&driving).may_drive(), "{driving:x?}");
            let mut damaged = driving.clone();
            *damaged.last_mut().unwrap() ^= 1;
            assert!(frame(&damaged).may_drive(), "{damaged:x?}");
            assert!(!frame(&damaged).request().unwrap().is_intact);
        }
        assert!(!ClientFrame::new(None, &[0xFF; 210]).may_drive());
        assert!(ClientFrame::new(None, &[0xFF, 0xFF, 0]).may_drive());
    }

    #[test]
    fn packets_that_wedge_are_detected_by_their_length() {
        for (data, wedges) in [(125, false), (126, true), (198, true)] {
            let bytes = morpheus(1, 0xFE, &std::vec![0; data]);
            assert_eq!(frame(&bytes).wedges_servo(), wedges, "{data}");
        }
        assert!(!frame(&stock(1, 3, &[0; 253])).wedges_servo());
        assert_eq!(ClientRequest::parse(Firmware::Stock, &[0xFF; 6]), None);
        assert_eq!(
            ClientRequest::parse(Firmware::Morpheus, &[0xAA, 3, 1]),
            None
        );
    }
}
