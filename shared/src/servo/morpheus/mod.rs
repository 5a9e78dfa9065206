//! Packets of the Morpheus servo firmware (V1.2), both directions.
//!
//! ```text
//! AA | LEN | DEST | SRC | D1 .. Dn | CRC      LEN = n + 2, n + 5 bytes in all
//! CRC = sum of the complements of LEN, DEST, SRC, D1..Dn, modulo 256
//! ```
//!
//! In a request D1 is the command; a reply is payload only, so the master must
//! remember what it asked. Servos take every packet on the wire for one that
//! may concern them, their neighbours' replies included, and several well
//! formed packets deafen or kill them:
//!
//! | packet                                   | what it does to the servos        |
//! |------------------------------------------|-----------------------------------|
//! | LEN of 128 or more                       | no command is heard until power-off |
//! | READ of no bytes, or whose first byte of reply is 0x83 | the others are deaf for 200 bytes |
//! | source address of a servo, or 255        | servos answer each other for ever |
//! | broadcast WRITE without data             | blocked for 266 ms, registers overwritten |
//! | SYNC_WR to the PWM register 0x10         | checksum ignored, some values ignored |
//! | any write to 0x00..=0x0A                 | EEPROM: deaf for 8.5 ms a byte, or reset |
//!
//! So there is no encoder of general packets here: [`Request`] lists what the
//! bridge sends, and [`safe_read::Plan`] what may be read. Torque goes by SYNC_WR
//! to 0x0F with three bytes a servo, which honours the checksum and takes every
//! value.
//!
//! | part        | what                                                        |
//! |-------------|-------------------------------------------------------------|
//! | [`Morpheus`] | the codec: finds packets and takes them apart              |
//! | [`Request`] | requests of the bridge                                      |
//! | [`safe_read`] | readings of registers that deafen no servo                |
//! | `exchange`  | the packets of a tick, and how long servos take             |
//!
//! # Off read-back
//!
//! A servo tells the low byte of its PWM only; the high byte always reads 0. Off is
//! 1000 = 0x03E8, so a low byte of 0xE8 is what a servo answers that is off, but
//! also one with a PWM of 232, 488, 744, 1256, 1512 or 1768. Other low bytes are
//! certainly not off. [`Firmware::judge_off`](super::Firmware::judge_off) is thus
//! evidence, not proof: combine it with a stop whose echo was undamaged and a ping
//! that was answered.

mod codec;
pub(super) mod exchange;
pub mod frame;
pub mod safe_read;

use super::Packet;
pub use super::ServoId;
pub use super::protocol::Damage;
use super::protocol::Protocol;
use crate::JOINTS;
use crate::actuator::Pwm;
pub use codec::Morpheus;
pub use frame::{BROADCAST, Frame, HEADER, checksum};

/// Our address. At least 0x20, so that no servo mistakes it for a register,
/// and never a servo's: [`ServoId`] excludes it.
pub const MASTER: u8 = 0xFE;

/// Longest request: [`Request::Drive`] for both servos.
pub const REQUEST_MAX: usize = 5 + 3 + 4 * JOINTS;
/// Finds the replies of a tick, of which a position is the longest.
pub type Parser = frame::Parser<{ Morpheus::TICK_REPLY_MAX }>;

/// Command codes of the firmware (`Serial.h`).
mod command {
    pub(super) const PING: u8 = 0x01;
    pub(super) const READ: u8 = 0x02;
    pub(super) const WRITE: u8 = 0x03;
    pub(super) const START: u8 = 0x06;
    pub(super) const CYCLE: u8 = 0x07;
    pub(super) const RESET: u8 = 0x09;
    pub(super) const SYNC_WR: u8 = 0x83;
}

/// Register addresses (`Eprom.h` of the firmware). Two bytes, low byte first, are
/// position, temperature and PWM.
mod register {
    pub(super) const POSITION: u8 = 0x0B;
    pub(super) const TEMPERATURE: u8 = 0x0E;
    /// High byte of the temperature: read-only, so that a write to it is void.
    /// SYNC_WR from here reaches the PWM register by the checked path.
    pub(super) const BEFORE_PWM: u8 = 0x0F;
    pub(super) const PWM: u8 = 0x10;
    /// After the last; a READ beyond it is refused.
    pub(super) const END: u8 = 0x12;
}

/// Everything the bridge says to Morpheus servos.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// "Are you there?" Answered with one byte.
    Ping(ServoId),
    /// Each servo answers in turn, 4.74 ms times its id later, and learns whom
    /// to follow in [`Request::Cycle`].
    Start,
    /// Every started servo sends its position, one after another in the order
    /// of their ids. High byte first, so never 0x83.
    Cycle,
    /// A PWM for each servo, by the checked SYNC_WR. No reply. Wants a pause of
    /// 20 µs before the next packet.
    Drive([(ServoId, Pwm); JOINTS]),
    /// PWM 1000 by broadcast WRITE: motors off in every control mode. No reply.
    StopAll,
    /// PWM 1001, by the unchecked SYNC_WR: the only thing that a servo still
    /// hears after a packet of LEN 128 or more. 1000 is ignored where the last
    /// such value was 1000, hence the step aside first. No reply.
    SideStep([ServoId; JOINTS]),
    /// PWM 1000 by the unchecked SYNC_WR, after [`Request::SideStep`].
    Release([ServoId; JOINTS]),
}

impl Request {
    /// The bytes on the wire.
    pub fn encode(&self) -> Packet {
        use command::{CYCLE, PING, START, SYNC_WR, WRITE};
        let [off_low, off_high] = Pwm::OFF.counts().to_le_bytes();
        match *self {
            Self::Ping(id) => packet(id.get(), &[PING]),
            Self::Start => packet(BROADCAST, &[START]),
            Self::Cycle => packet(BROADCAST, &[CYCLE]),
            Self::StopAll => packet(BROADCAST, &[WRITE, register::PWM, off_low, off_high]),
            Self::Drive([a, b]) => {
                let ([a_low, a_high], [b_low, b_high]) =
                    (a.1.counts().to_le_bytes(), b.1.counts().to_le_bytes());
                let (a, b) = (a.0.get(), b.0.get());
                #[rustfmt::skip]
                let data = [SYNC_WR, register::BEFORE_PWM, 3,
                    a, 0, a_low, a_high,
                    b, 0, b_low, b_high];
                packet(BROADCAST, &data)
            }
            Self::SideStep(ids) => unchecked_sync(ids, Pwm::OFF.counts() + 1),
            Self::Release(ids) => unchecked_sync(ids, Pwm::OFF.counts()),
        }
    }
}

/// SYNC_WR of one value to the PWM register. Private: taken without regard to
/// its checksum, it must never carry a torque.
fn unchecked_sync([a, b]: [ServoId; JOINTS], pwm: u16) -> Packet {
    let [low, high] = pwm.to_le_bytes();
    #[rustfmt::skip]
    let data = [command::SYNC_WR, register::PWM, 2, a.get(), low, high, b.get(), low, high];
    packet(BROADCAST, &data)
}

/// Frames `data`; the caller's data always fits [`REQUEST_MAX`].
fn packet(destination: u8, data: &[u8]) -> Packet {
    let frame = Frame {
        destination,
        source: MASTER,
        data,
    };
    // Capacity is REQUEST_MAX, the longest request there is.
    frame.encode().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;

    fn id(id: u8) -> ServoId {
        ServoId::new(id).unwrap()
    }

    /// All but the last were recorded on a bus with the firmware, which did as
    /// it should; the last was computed from the packet layout.
    #[test]
    fn requests_encode_as_recorded() {
        let drive = Request::Drive(
            [(1, 1500), (2, 900)].map(|(servo, pwm)| (id(servo), Pwm::new(pwm).unwrap())),
        );
        #[rustfmt::skip]
        let vectors: [(Request, &[u8]); 6] = [
            (Request::Ping(id(1)), &[0xAA, 3, 1, 0xFE, 1, 0xF9]),
            (Request::Start, &[0xAA, 3, 0xFF, 0xFE, 6, 0xF6]),
            (Request::Cycle, &[0xAA, 3, 0xFF, 0xFE, 7, 0xF5]),
            (
                Request::StopAll,
                &[0xAA, 6, 0xFF, 0xFE, 3, 0x10, 0xE8, 3, 0xF8],
            ),
            (
                drive,
                &[0xAA, 13, 0xFF, 0xFE, 0x83, 0x0F, 3, 1, 0, 0xDC, 5, 2, 0, 0x84, 3, 0xE8],
            ),
            (
                Request::Release([id(1), id(2)]),
                &[
                    0xAA, 11, 0xFF, 0xFE, 0x83, 0x10, 2, 1, 0xE8, 3, 2, 0xE8, 3, 0x7E,
                ],
            ),
        ];
        for (request, bytes) in vectors {
            assert_eq!(request.encode(), bytes, "{request:?}");
        }
    }

    #[test]
    fn parser_finds_replies_in_noise() {
        let stream = [
            0x00, 0xAA, 0xAA, 4, 0xFE, 1, 1, 0xF4, 3, // position 500 of servo 1
            0xAA, 200, 0xAA, 4, 0xFE, 2, 1, 0xF5, 2, // bad checksum (01 is right)
            0xAA, 3, 0xFE, 2, 1, 0xF8, // ping of servo 2
        ];
        let mut parser = Parser::to(MASTER);
        let mut found = std::vec::Vec::new();
        for byte in stream {
            match parser.push(byte) {
                Some(Ok(frame)) => found.push(Ok((frame.source, frame.data.to_vec()))),
                Some(Err(Damage::Checksum { id })) => found.push(Err(id)),
                Some(Err(Damage::Header)) | None => {}
            }
        }
        assert_eq!(found.len(), 3);
        let (_, position) = found[0].as_ref().unwrap();
        assert_eq!(Morpheus::position(position), Some(500));
        assert_eq!(found[1], Err(2));
        let (source, pong) = found[2].as_ref().unwrap();
        assert!(Morpheus::is_pong(pong) && *source == 2);
        assert_eq!(parser.bytes_held(), 0);
    }
}
