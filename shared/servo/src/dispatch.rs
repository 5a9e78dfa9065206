//! Dispatch at run time: the operations of [`Protocol`], in the protocol of a firmware.

use super::morpheus::Morpheus;
use super::protocol::{Extent, PacketError, Parser, Protocol, Reply};
use super::protocol1::Protocol1;
use super::protocol2::{self, Protocol2};
use super::{ControlMode, Firmware, Query, ServoId};
use heapless::Vec;

/// Evaluates an expression in which `$P` is the [`Protocol`] of a firmware: the one
/// place that lists them.
macro_rules! with_protocol {
    ($firmware:expr, $P:ident => $body:expr) => {
        match $firmware {
            $crate::Firmware::Morpheus => {
                type $P = $crate::morpheus::Morpheus;
                $body
            }
            $crate::Firmware::Stock => {
                type $P = $crate::protocol1::Protocol1;
                $body
            }
            $crate::Firmware::XSeries => {
                type $P = $crate::protocol2::Protocol2;
                $body
            }
        }
    };
}
pub(super) use with_protocol;

/// The operations of [`Protocol`], in the protocol of the firmware.
impl Firmware {
    /// Destination of a packet to all servos.
    pub const fn broadcast(self) -> u8 {
        with_protocol!(self, P => P::BROADCAST)
    }

    /// Bytes of a reply beside its data.
    pub const fn reply_overhead(self) -> usize {
        with_protocol!(self, P => P::OVERHEAD)
    }

    /// Bytes of a READ.
    pub const fn read_bytes(self) -> usize {
        with_protocol!(self, P => P::READ_BYTES)
    }

    /// Bytes of a reply to [`Firmware::ping_query`].
    pub(super) const fn pong_bytes(self) -> u16 {
        with_protocol!(self, P => P::PONG_BYTES)
    }

    /// Bytes of the longest reply that the master decodes in a tick.
    pub(super) const fn tick_reply_max(self) -> usize {
        with_protocol!(self, P => P::TICK_REPLY_MAX)
    }

    /// Bytes of a servo's registers, from address 0 on.
    pub const fn memory_bytes(self) -> u16 {
        with_protocol!(self, P => P::MEMORY_BYTES)
    }

    /// Address of the two-byte position, if no READ may begin there.
    pub const fn unreadable(self) -> Option<u16> {
        with_protocol!(self, P => P::UNREADABLE)
    }

    /// Data of a reply that rejects a request.
    pub const fn refusal(self) -> &'static [u8] {
        with_protocol!(self, P => P::REFUSAL)
    }

    /// Address of the first byte of the register that has a byte at `address`.
    pub fn register_start(self, address: u16) -> u16 {
        with_protocol!(self, P => P::register_start(address))
    }

    /// Whether a servo can have this id.
    pub const fn has_id(self, id: u8) -> bool {
        match self {
            Self::Morpheus => ServoId::new(id).is_some(),
            Self::Stock => id < Protocol1::BROADCAST,
            Self::XSeries => id <= protocol2::frame::ID_MAX,
        }
    }

    /// Length of the packet that these bytes begin with.
    pub fn extent(self, bytes: &[u8]) -> Extent {
        with_protocol!(self, P => P::extent(bytes))
    }

    /// Reply packet to a master with this address; `None` if no servo has the id
    /// or the packet is longer than `N`.
    pub fn encode_reply<const N: usize>(self, reply: &Reply, to: u8) -> Option<Vec<u8, N>> {
        with_protocol!(self, P => P::encode_reply(reply, to))
    }

    /// Query of the presence test: see [`Firmware::is_pong`].
    pub fn ping_query(self, servo: ServoId) -> Query {
        with_protocol!(self, P => P::ping_query(servo))
    }

    /// Whether the data of a reply answer [`Firmware::ping_query`].
    pub fn is_pong(self, data: &[u8]) -> bool {
        with_protocol!(self, P => P::is_pong(data))
    }

    /// Position in counts, 0..=1023, from the data of a tick's reply.
    pub(super) fn position(self, data: &[u8]) -> Option<u16> {
        with_protocol!(self, P => P::position(data))
    }

    /// Query that reads registers; `None` if the servo has not all of them, if no single
    /// READ may have them, or if the packet is longer than `N`.
    pub fn read_query<const N: usize>(self, id: u8, address: u16, count: u16) -> Option<Query<N>> {
        with_protocol!(self, P => P::read_query(id, address, count))
    }

    /// Query that writes registers; `None` if the bridge writes none of these servos, or if the
    /// packet is longer than `N`.
    pub fn write_query<const N: usize>(
        self,
        id: u8,
        address: u16,
        data: &[u8],
    ) -> Option<Query<N>> {
        with_protocol!(self, P => P::write_query(id, address, data))
    }

    /// Contents of the registers of [`Firmware::read_query`], from the data of a reply;
    /// `None` if that is no reply to the query.
    pub fn read_reply(self, address: u16, count: u16, data: &[u8]) -> Option<&[u8]> {
        with_protocol!(self, P => P::read_reply(address, count, data))
    }

    /// Number of registers that a READ must have before the one at `address`.
    pub fn lead_bytes(self, address: u16) -> u16 {
        with_protocol!(self, P => P::lead_bytes(address))
    }

    /// Query that shows whether a servo's motor is off: see [`Firmware::decode_off`]. The mode of a
    /// servo that may not have been made ready is [`ControlMode::Pwm`].
    pub fn off_query(self, servo: ServoId, mode: ControlMode) -> Query {
        with_protocol!(self, P => P::off_query(servo, mode))
    }

    /// Whether the motor is off, from the data of the reply to
    /// [`Firmware::off_query`]; `None` if that is no reply to the query.
    ///
    /// The result is certain for a stock servo and, but for a current too small to move it, for an X
    /// servo. A Morpheus servo returns only the low byte
    /// of its PWM: see [`morpheus`](super::morpheus#off-read-back).
    pub fn decode_off(self, data: &[u8]) -> Option<bool> {
        with_protocol!(self, P => P::decode_off(data))
    }

    /// Query of the temperature: see [`Firmware::temperature`].
    pub fn temperature_query(self, servo: ServoId) -> Option<Query> {
        let (address, count) = with_protocol!(self, P => P::TEMPERATURE);
        self.read_query(servo.get(), address, count)
    }

    /// Temperature from the data of the reply to [`Firmware::temperature_query`]: °C of
    /// a stock or X servo, counts of a Morpheus servo's converter, which are 0 until its first
    /// conversion, half a second after power-up. `None` if there is none.
    pub fn temperature(self, data: &[u8]) -> Option<u16> {
        let (address, count) = with_protocol!(self, P => P::TEMPERATURE);
        let bytes = self.read_reply(address, count, data)?.iter().rev();
        let value = bytes.fold(0, |value, byte| value << 8 | u16::from(*byte));
        (value > 0 || self != Self::Morpheus).then_some(value)
    }

    /// Query of one byte that is 0 once a servo has been reset, and 255 once an X servo's
    /// watchdog has switched its motor off. `None` if the servo has no such register.
    pub fn reset_query(self, servo: ServoId) -> Option<Query> {
        let address = with_protocol!(self, P => P::RESET_MARK)?;
        self.read_query(servo.get(), address, 1)
    }
}

/// Parser of replies of up to `N` bytes from servos whose firmware is known at run time.
#[derive(Clone, Debug)]
pub enum ReplyParser<const N: usize> {
    /// Parses replies of Morpheus servos.
    Morpheus(Parser<Morpheus, N>),
    /// Parses replies of stock servos.
    Stock(Parser<Protocol1, N>),
    /// Parses replies of X servos.
    XSeries(Parser<Protocol2, N>),
}

impl<const N: usize> ReplyParser<N> {
    /// A parser of replies to any address.
    pub const fn new(firmware: Firmware) -> Self {
        match firmware {
            Firmware::Morpheus => Self::Morpheus(Parser::new()),
            Firmware::Stock => Self::Stock(Parser::new()),
            Firmware::XSeries => Self::XSeries(Parser::new()),
        }
    }

    /// A parser of replies that are no longer than `longest` and go to the bridge, where
    /// a reply has its destination.
    pub const fn to_bridge(firmware: Firmware, longest: usize) -> Self {
        match firmware {
            Firmware::Morpheus => Self::Morpheus(Parser::limited(longest, Morpheus::MASTER)),
            Firmware::Stock => Self::Stock(Parser::limited(longest, Protocol1::MASTER)),
            Firmware::XSeries => Self::XSeries(Parser::limited(longest, Protocol2::MASTER)),
        }
    }

    /// Takes one byte; `Some` when it ends a packet, intact or not: a reply, or `None`
    /// for an intact packet that no servo would send.
    pub fn push(&mut self, byte: u8) -> Option<Result<Option<Reply<'_>>, PacketError>> {
        match self {
            Self::Morpheus(parser) => parser.push_reply(byte),
            Self::Stock(parser) => parser.push_reply(byte),
            Self::XSeries(parser) => parser.push_reply(byte),
        }
    }

    /// Takes the packet that these bytes begin with, if they have the whole of it and it is
    /// intact, as [`ReplyParser::push`] would byte by byte, and returns the bytes after it.
    /// `None`, and nothing is taken, otherwise, or if a packet has begun already.
    pub fn whole_reply<'a>(&self, bytes: &'a [u8]) -> Option<(Option<Reply<'a>>, &'a [u8])> {
        match self {
            Self::Morpheus(parser) => parser.whole_reply(bytes),
            Self::Stock(parser) => parser.whole_reply(bytes),
            Self::XSeries(parser) => parser.whole_reply(bytes),
        }
    }

    /// Bytes of a packet that has begun and not ended.
    pub fn bytes_held(&self) -> usize {
        match self {
            Self::Morpheus(parser) => parser.bytes_held(),
            Self::Stock(parser) => parser.bytes_held(),
            Self::XSeries(parser) => parser.bytes_held(),
        }
    }

    /// The bytes of a packet that has begun, or that has ended with the last byte.
    pub(super) fn bytes(&self) -> &[u8] {
        match self {
            Self::Morpheus(parser) => parser.bytes(),
            Self::Stock(parser) => parser.bytes(),
            Self::XSeries(parser) => parser.bytes(),
        }
    }

    /// Forgets a packet that has begun.
    pub fn reset(&mut self) {
        match self {
            Self::Morpheus(parser) => parser.reset(),
            Self::Stock(parser) => parser.reset(),
            Self::XSeries(parser) => parser.reset(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn servo() -> ServoId {
        ServoId::new(1).unwrap()
    }

    #[test]
    fn pings_are_as_recorded() {
        let [morpheus, stock, _] = Firmware::ALL.map(|firmware| firmware.ping_query(servo()));
        assert_eq!(morpheus.packet, [0xAA, 3, 1, 0xFE, 1, 0xF9]);
        assert_eq!(stock.packet, [0xFF, 0xFF, 1, 2, 1, 0xFB]);
        assert_eq!((morpheus.reply_bytes, stock.reply_bytes), (6, 6));
        assert!(Firmware::Morpheus.is_pong(&[1]) && !Firmware::Morpheus.is_pong(&[8]));
        assert!(Firmware::Stock.is_pong(&[]));
    }

    #[test]
    fn a_morpheus_servo_is_off_if_the_low_byte_of_its_pwm_says_so() {
        let firmware = Firmware::Morpheus;
        let query = firmware.off_query(servo(), ControlMode::Pwm);
        // From the high byte of the temperature on, which is never 0x83.
        assert_eq!(query.packet, [0xAA, 5, 1, 0xFE, 2, 0x0F, 2, 0xE3]);
        assert_eq!((query.id, query.reply_bytes), (1, 7));
        let judge = |pwm: u16| firmware.decode_off(&[1, pwm.to_le_bytes()[0]]);
        let off = (0..=2000).filter(|pwm| judge(*pwm) == Some(true));
        assert!(off.eq([232, 488, 744, 1000, 1256, 1512, 1768]));
        assert_eq!(judge(1001), Some(false));
        // NOK, the wrong length, another register's contents.
        for data in [&[8][..], &[1, 0xE8, 0], &[4, 0xE8], &[]] {
            assert_eq!(firmware.decode_off(data), None, "{data:x?}");
        }
    }

    #[test]
    fn a_stock_servo_is_off_without_torque_or_still_in_wheel_mode() {
        let firmware = Firmware::Stock;
        let query = firmware.off_query(servo(), ControlMode::Pwm);
        // READ of 28 bytes from address 6 on.
        assert_eq!(query.packet, [0xFF, 0xFF, 1, 4, 2, 6, 28, 0xD6]);
        assert_eq!((query.id, query.reply_bytes), (1, 34));
        let judge = |limits: [u16; 2], torque: u8, speed: u16| {
            let mut memory = [0; 50];
            memory[6..8].copy_from_slice(&limits[0].to_le_bytes());
            memory[8..10].copy_from_slice(&limits[1].to_le_bytes());
            memory[24] = torque;
            memory[32..34].copy_from_slice(&speed.to_le_bytes());
            firmware.decode_off(&memory[6..34])
        };
        let (wheel, joint) = ([0, 0], [0, 1023]);
        assert_eq!(judge(wheel, 0, 1023), Some(true));
        assert_eq!(judge(joint, 0, 0), Some(true));
        assert_eq!(judge(wheel, 1, 0), Some(true));
        assert_eq!(judge(wheel, 1, 1 << 10), Some(true));
        assert_eq!(judge(wheel, 1, 1), Some(false));
        assert_eq!(judge(wheel, 1, 1 << 10 | 1), Some(false));
        // The highest speed.
        assert_eq!(judge(joint, 1, 0), Some(false));
        assert_eq!(judge(wheel, 2, 0), None);
        assert_eq!(firmware.decode_off(&[0; 27]), None);
        assert_eq!(firmware.decode_off(&[]), None);
    }

    #[test]
    fn an_x_servo_is_off_without_a_pwm_or_by_current_with_next_to_none() {
        let firmware = Firmware::XSeries;
        let parameters = |mode| firmware.off_query(servo(), mode).packet[8..12].to_vec();
        assert_eq!(parameters(ControlMode::Pwm), [124, 0, 2, 0]);
        assert_eq!(parameters(ControlMode::Current), [124, 0, 4, 0]);
        let judge = |pwm: i16, current: Option<i16>| {
            let current = current.map(i16::to_le_bytes);
            let data = [
                &pwm.to_le_bytes()[..],
                current.as_ref().map_or(&[], |bytes| bytes),
            ];
            firmware.decode_off(&data.concat())
        };
        assert_eq!(judge(0, None), Some(true));
        assert_eq!(judge(1, None), Some(false));
        assert_eq!(judge(0, Some(300)), Some(true));
        assert_eq!(
            [20, -20].map(|counts| judge(90, Some(counts))),
            [Some(true); 2]
        );
        assert_eq!(
            [21, -21].map(|counts| judge(90, Some(counts))),
            [Some(false); 2]
        );
        assert_eq!(firmware.decode_off(&[0]), None);
        assert_eq!(firmware.decode_off(&[0; 3]), None);
    }
}
