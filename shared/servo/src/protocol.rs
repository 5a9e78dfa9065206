//! The codec of a servo bus protocol: the interface of a wire format for master and
//! transparent port.
//!
//! [`Protocol`] is implemented once for each wire format, by a unit type in the
//! format's own folder ([`Morpheus`], [`Protocol1`], [`Protocol2`]). It finds packets in a
//! stream, parses them in both directions, and builds the requests of the bridge. Another
//! protocol is another folder, a variant of [`Firmware`] and its line in `dispatch`.
//!
//! The codec works on borrowed bytes, allocates nothing and is dispatched
//! statically. [`Firmware`] has the same operations for a protocol that is known
//! only at run time.
//!
//! [`Morpheus`]: super::morpheus::Morpheus
//! [`Protocol1`]: super::protocol1::Protocol1
//! [`Protocol2`]: super::protocol2::Protocol2

use super::{Alarms, ControlMode, DecodeError, Firmware, Instruction, Query, ServoId};
use core::fmt::Debug;
use core::marker::PhantomData;
use heapless::Vec;

/// Length of the packet at the beginning of some bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// The first byte begins no packet.
    NoHeader,
    /// A header, but with a length that no packet has.
    BadLength,
    /// The length has not been received yet.
    Incomplete,
    /// The length in bytes, from the first of the header to the checksum.
    Whole(usize),
}

/// Reason why received bytes are no packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PacketError {
    /// A wrong checksum; or, in Protocol 2.0, a mark in the data without its stuffing.
    Checksum {
        /// The sender as received, which may be what is damaged.
        id: u8,
    },
    /// A header, but a length that no expected packet has, or another
    /// destination.
    Header,
}

/// A servo's reply, without header and checksum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reply<'a> {
    /// Servo that sent the reply.
    pub id: u8,
    /// Error bits; none from Morpheus, which has no error byte.
    pub alarms: Alarms,
    /// Register contents, or an acknowledgement.
    pub data: &'a [u8],
}

/// Wire format of a firmware, and the requests of the bridge in it.
pub trait Protocol: Clone + Debug {
    /// Fields of a packet, instruction or reply.
    type Frame<'a>: Copy;

    /// Firmware that uses the protocol.
    const FIRMWARE: Firmware;
    /// Bytes that begin a packet; they have the same value.
    const HEADER: &'static [u8];
    /// Index of the destination in a packet.
    const DESTINATION: usize;
    /// Bytes of a reply beside its data.
    const OVERHEAD: usize;
    /// Bytes of a READ.
    const READ_BYTES: usize;
    /// Bytes of the longest packet that may be on a bus.
    const FRAME_MAX: usize;
    /// Bytes of a reply to [`Protocol::ping_query`].
    const PONG_BYTES: u16;
    /// Bytes of the longest reply that the master decodes in a tick.
    const TICK_REPLY_MAX: usize;
    /// Destination of a packet to all servos.
    const BROADCAST: u8;
    /// Destination of replies to the bridge, where replies have one.
    const MASTER: Option<u8>;
    /// Bytes of a servo's registers, from address 0 on.
    const MEMORY_BYTES: u16;
    /// Address of the temperature, low byte first, and its number of bytes.
    const TEMPERATURE: (u16, u16);
    /// Address of a byte that is 0 in a servo that was reset since it was made ready for torque,
    /// and 255 in one that has switched its motor off by itself; `None` if there is none.
    const RESET_MARK: Option<u16>;
    /// Address of the two-byte position, if no READ may begin there.
    const UNREADABLE: Option<u16>;
    /// Data of a reply that rejects a request.
    const REFUSAL: &'static [u8];

    /// Length of the packet that these bytes begin with.
    fn extent(bytes: &[u8]) -> Extent;

    /// Fields of one whole packet, whatever its checksum; `None` if its length is
    /// not the number of these bytes.
    fn frame(packet: &[u8]) -> Option<Self::Frame<'_>>;

    /// Whether the checksum of a whole packet is right.
    fn is_intact(packet: &[u8]) -> bool;

    /// Whether a whole packet has stuffed bytes, beside which its contents are not in one piece.
    fn is_stuffed(_packet: &[u8]) -> bool {
        false
    }

    /// Removes the stuffed bytes of a whole packet, and counts them out of its length; its
    /// checksum is wrong from then on. Whether all of them were there.
    fn unstuff<const N: usize>(_packet: &mut Vec<u8, N>) -> bool {
        true
    }

    /// Destination and source. They are the same address in a protocol that sends
    /// only one.
    fn addresses(frame: &Self::Frame<'_>) -> (u8, u8);

    /// Whether a master may have this address: replies to it concern no servo.
    fn is_master(source: u8) -> bool;

    /// Decodes the request of a frame from a master.
    ///
    /// # Errors
    /// [`DecodeError`] if no servo of this protocol knows it.
    fn instruction<'a>(frame: &Self::Frame<'a>) -> Result<Instruction<'a>, DecodeError>;

    /// Decodes a frame from a servo as a reply; `None` if no servo would send it.
    fn reply<'a>(frame: &Self::Frame<'a>) -> Option<Reply<'a>>;

    /// Reply packet to a master with this address; `None` if no servo has the id
    /// or the packet is longer than `N`.
    fn encode_reply<const N: usize>(reply: &Reply, to: u8) -> Option<Vec<u8, N>>;

    /// Bytes of all reply packets to an instruction, and the longest time until
    /// they begin, in µs; no bytes if none is sent.
    fn expected(instruction: Result<Instruction, DecodeError>, is_broadcast: bool) -> (u16, u32);

    /// Query of the presence test.
    fn ping_query(servo: ServoId) -> Query;

    /// Whether the data of a reply answer [`Protocol::ping_query`].
    fn is_pong(data: &[u8]) -> bool;

    /// Position in counts of the servo's encoder, from the data of a tick's reply.
    fn position(data: &[u8]) -> Option<u16>;

    /// Query that reads registers; `None` if the servo has not all of them, if no single
    /// READ may have them, or if the packet is longer than `N`.
    fn read_query<const N: usize>(id: u8, address: u16, count: u16) -> Option<Query<N>>;

    /// Query that writes registers; `None` if the bridge writes none of these servos, or if the
    /// packet is longer than `N`.
    fn write_query<const N: usize>(id: u8, address: u16, data: &[u8]) -> Option<Query<N>>;

    /// Contents of the registers of [`Protocol::read_query`], from the data of a reply;
    /// `None` if that is no reply to the query.
    fn read_reply(address: u16, count: u16, data: &[u8]) -> Option<&[u8]>;

    /// Number of registers that a READ must have before the one at `address`.
    fn lead_bytes(address: u16) -> u16;

    /// Address of the first byte of the register that has a byte at `address`.
    fn register_start(address: u16) -> u16;

    /// Query that shows whether the motor is off, of a servo whose commands are known to be of this
    /// mode.
    fn off_query(servo: ServoId, mode: ControlMode) -> Query;

    /// Whether the motor is off, from the data of the reply to
    /// [`Protocol::off_query`]; `None` if that is no reply to the query.
    fn decode_off(data: &[u8]) -> Option<bool>;
}

/// Address of the first byte of the register that has a byte at `address`, where no register has
/// more than two bytes; bit n of `words` is set if one of two begins at address n.
pub(super) fn word_start(words: u64, address: u16) -> u16 {
    let before = address.checked_sub(1);
    let has_word = |before: &u16| {
        let shifted = words.checked_shr(u32::from(*before));
        shifted.is_some_and(|words| words & 1 == 1)
    };
    before.filter(has_word).unwrap_or(address)
}

/// Parser of packets of up to `N` bytes in a stream, one byte at a time.
///
/// Bytes before a header are skipped. After a damaged packet the search goes on
/// with the next byte, so that garbage costs one packet at most: the one
/// that follows its last header.
#[derive(Clone, Debug)]
pub struct Parser<P, const N: usize> {
    bytes: Vec<u8, N>,
    /// Bytes of the longest packet that is expected.
    longest: usize,
    /// The only destination that is expected; `None` for any.
    only_to: Option<u8>,
    protocol: PhantomData<P>,
}

impl<P: Protocol, const N: usize> Default for Parser<P, N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<P: Protocol, const N: usize> Parser<P, N> {
    /// A parser for packets to any destination.
    pub const fn new() -> Self {
        Self::limited(N, None)
    }

    /// A parser for packets to this address only; fewer stray headers mislead it.
    pub const fn to(address: u8) -> Self {
        Self::limited(N, Some(address))
    }

    /// A parser for packets that are not longer than this and go to this address,
    /// if one is given.
    pub(super) const fn limited(longest: usize, only_to: Option<u8>) -> Self {
        let longest = if longest < N { longest } else { N };
        Self {
            bytes: Vec::new(),
            longest: if longest < P::FRAME_MAX {
                longest
            } else {
                P::FRAME_MAX
            },
            only_to,
            protocol: PhantomData,
        }
    }

    /// Takes one byte; `Some` when it ends a packet, intact or not.
    pub fn push(&mut self, byte: u8) -> Option<Result<P::Frame<'_>, PacketError>> {
        if self.is_whole() {
            self.bytes.clear();
        }
        // There is room: packets longer than N are refused.
        let _ = self.bytes.push(byte);
        match self.extent_of(&self.bytes) {
            Extent::Whole(length) if self.bytes.len() >= length => {}
            Extent::Whole(_) | Extent::Incomplete => return None,
            extent => {
                // The byte that ended the packet may begin the next one.
                let ends = self.bytes.iter().rev().take(P::HEADER.len());
                let begun = ends.take_while(|byte| P::HEADER.contains(byte)).count();
                self.bytes.truncate(begun);
                return (extent == Extent::BadLength).then_some(Err(PacketError::Header));
            }
        }
        let (_, id) = P::addresses(&P::frame(&self.bytes)?);
        if !(P::is_intact(&self.bytes) && P::unstuff(&mut self.bytes)) {
            return Some(Err(PacketError::Checksum { id }));
        }
        P::frame(&self.bytes).map(Ok)
    }

    /// Takes one byte like [`Parser::push`], of a stream from servos: `None` stands
    /// for an intact packet that no servo would send.
    pub(super) fn push_reply(
        &mut self,
        byte: u8,
    ) -> Option<Result<Option<Reply<'_>>, PacketError>> {
        let found = self.push(byte)?;
        Some(found.map(|frame| P::reply(&frame)))
    }

    /// Takes a whole intact packet at the beginning of bytes from servos, and returns
    /// the bytes after it; see [`ReplyParser::whole_reply`](super::ReplyParser::whole_reply).
    pub(super) fn whole_reply<'a>(&self, bytes: &'a [u8]) -> Option<(Option<Reply<'a>>, &'a [u8])> {
        if self.bytes_held() > 0 {
            return None;
        }
        let Extent::Whole(length) = self.extent_of(bytes) else {
            return None;
        };
        let (packet, rest) = bytes.split_at_checked(length)?;
        let frame = P::frame(packet).filter(|_| P::is_intact(packet) && !P::is_stuffed(packet))?;
        Some((P::reply(&frame), rest))
    }

    /// Length of the packet that these bytes begin with; [`Extent::BadLength`] if it is not
    /// expected.
    fn extent_of(&self, bytes: &[u8]) -> Extent {
        let destination = bytes.get(P::DESTINATION);
        let is_to_other = destination
            .zip(self.only_to)
            .is_some_and(|(destination, only)| *destination != only);
        match P::extent(bytes) {
            Extent::Incomplete | Extent::Whole(_) if is_to_other => Extent::BadLength,
            Extent::Whole(length) if length > self.longest => Extent::BadLength,
            extent => extent,
        }
    }

    /// Whether the last byte pushed was the last of a packet.
    fn is_whole(&self) -> bool {
        P::extent(&self.bytes) == Extent::Whole(self.bytes.len())
    }

    /// The bytes of a packet that has begun, or that has ended with the last byte.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Bytes of a packet that has begun and not ended.
    pub fn bytes_held(&self) -> usize {
        if self.is_whole() { 0 } else { self.bytes.len() }
    }

    /// Forgets a packet that has begun.
    pub fn reset(&mut self) {
        self.bytes.clear();
    }
}
