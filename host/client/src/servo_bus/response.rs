//! Received bytes of an exchange: echo, packets, and the rest.

use armbridge_servo::protocol::PacketError;
use armbridge_servo::protocol1::frame::FRAME_MAX;
use armbridge_servo::{Alarms, Firmware, ReplyParser};

use super::diagnosis::{Diagnosis, REFUSING, Refusal};
use super::request::Request;

/// Payload of a Morpheus refusal.
const NOK: [u8; 1] = [0x08];

/// An intact packet from a servo.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Packet {
    /// Its id.
    pub from: u8,
    /// Alarms; Morpheus has none.
    pub alarms: Alarms,
    /// Payload.
    pub data: Vec<u8>,
}

/// Decoder of the bytes that follow one request.
#[derive(Debug)]
pub(super) struct Response<'a> {
    /// Expected echo.
    echo: &'a [u8],
    echoed: usize,
    echo_is_damaged: bool,
    parser: Box<ReplyParser<FRAME_MAX>>,
    pub(super) packets: Vec<Packet>,
    damaged: Option<u8>,
    /// Bytes after the echo.
    bytes: usize,
}

impl<'a> Response<'a> {
    /// Before the first byte. `echo` is the expected echo.
    pub(super) fn new(firmware: Firmware, echo: &'a [u8]) -> Self {
        Self {
            echo,
            echoed: 0,
            echo_is_damaged: false,
            parser: Box::new(ReplyParser::to_bridge(firmware, FRAME_MAX)),
            packets: Vec::new(),
            damaged: None,
            bytes: 0,
        }
    }

    pub(super) fn push(&mut self, byte: u8) {
        if let Some(sent) = self.echo.get(self.echoed) {
            self.echo_is_damaged |= *sent != byte;
            self.echoed += 1;
            return;
        }
        self.bytes += 1;
        match self.parser.push(byte) {
            Some(Ok(Some(reply))) => self.packets.push(Packet {
                from: reply.id,
                alarms: reply.alarms,
                data: reply.data.to_vec(),
            }),
            Some(Err(PacketError::Checksum { id })) => self.damaged = Some(id),
            Some(Ok(None) | Err(PacketError::Header)) | None => {}
        }
    }

    /// Bytes of an incomplete packet.
    fn partial_bytes(&self) -> usize {
        self.parser.bytes_held()
    }

    /// Whether the echo is complete, if there is one.
    pub(super) fn is_echoed(&self) -> bool {
        self.echoed == self.echo.len()
    }

    /// Whether there is a packet, and no byte after it.
    pub(super) fn has_complete_packet(&self) -> bool {
        !self.packets.is_empty() && self.partial_bytes() == 0
    }

    /// The one reply to `request`, or the error.
    pub(super) fn answer(mut self, request: &Request) -> Result<Packet, Diagnosis> {
        let (Some(packet), true) = (self.packets.pop(), self.packets.is_empty()) else {
            return Err(self.missing_reply());
        };
        if packet.from != request.id {
            return Err(Diagnosis::WrongId {
                answered: packet.from,
            });
        }
        if self.damaged.is_some() {
            return Err(Diagnosis::Several);
        }
        let refusing = packet.alarms.and(REFUSING);
        if !refusing.is_empty() {
            return Err(Refusal::Alarms(refusing).into());
        }
        if request.firmware == Firmware::Morpheus && packet.data == NOK {
            return Err(Refusal::Nok.into());
        }
        match request.wanted(&packet.data) {
            Some(wanted) => Ok(Packet {
                data: wanted.to_vec(),
                ..packet
            }),
            None => Err(Diagnosis::UnexpectedContent { id: packet.from }),
        }
    }

    /// Reason for which there is not exactly one packet.
    pub(super) fn missing_reply(&self) -> Diagnosis {
        let bytes = self.bytes;
        match self.damaged {
            _ if !self.packets.is_empty() => Diagnosis::Several,
            Some(id) => Diagnosis::BadChecksum { id },
            None if bytes > 0 && self.partial_bytes() == bytes => Diagnosis::Short { bytes },
            None if bytes > 0 => Diagnosis::Garbage { bytes },
            None if self.echoed == 0 => Diagnosis::Silence,
            None if self.echo_is_damaged => Diagnosis::EchoDamaged,
            None => Diagnosis::EchoOnly,
        }
    }
}
