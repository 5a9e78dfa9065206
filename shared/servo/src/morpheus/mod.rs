//! Packets of the Morpheus servo firmware (V1.2), both directions.
//!
//! ```text
//! AA | LEN | DEST | SRC | D1 .. Dn | CRC      LEN = n + 2, n + 5 bytes in all
//! CRC = sum of the complements of LEN, DEST, SRC, D1..Dn, modulo 256
//! ```
//!
//! In a request D1 is the command; a reply is payload only, so the master must
//! remember its request. Servos parse every packet on the wire, their neighbours'
//! replies included, and several well formed packets make them stop receiving or
//! working:
//!
//! | packet                                   | effect on the servos              |
//! |------------------------------------------|-----------------------------------|
//! | LEN of 128 or more                       | no command is received until power-off |
//! | READ of no bytes, or whose first byte of reply is 0x83 | the others are deaf for 200 bytes |
//! | source address of a servo, or 255        | servos answer each other for ever |
//! | broadcast WRITE without data             | blocked for 266 ms, registers overwritten |
//! | SYNC_WR to the PWM register 0x10         | checksum ignored, some values ignored |
//! | any write to 0x00..=0x0A                 | EEPROM: deaf for 8.5 ms a byte, or reset |
//!
//! So there is no encoder of general packets here: [`Request`] lists what the
//! bridge sends, and [`safe_read::Plan`] the READs that are safe. Torque goes by SYNC_WR
//! to 0x0F with three bytes a servo, which honours the checksum and takes every
//! value.
//!
//! | part        | content                                                     |
//! |-------------|-------------------------------------------------------------|
//! | [`Morpheus`] | the codec: finds and parses packets                        |
//! | [`Request`] | requests of the bridge                                      |
//! | [`safe_read`] | readings of registers that deafen no servo                |
//! | `exchange`  | the packets of a tick, and response times of the servos     |
//!
//! # Off read-back
//!
//! A servo returns the low byte of its PWM only; the high byte always reads 0. Off is
//! 1000 = 0x03E8, so a servo that is off answers a low byte of 0xE8, but
//! so does one with a PWM of 232, 488, 744, 1256, 1512 or 1768. Other low bytes are
//! certainly not off. [`Firmware::decode_off`](super::Firmware::decode_off) is thus
//! evidence, not proof: combine it with a stop whose echo was undamaged and a ping
//! that was answered.

mod codec;
mod codes;
mod exchange;
pub mod frame;
mod request;
pub mod safe_read;

pub use super::ServoId;
pub use super::packet::REQUEST_MAX;
pub use super::protocol::PacketError;
pub use frame::{BROADCAST, Frame, HEADER, Morpheus, checksum};
pub use request::{MASTER, Request};

use super::protocol::Protocol;

/// Parser of the replies of a tick, of which a position is the longest.
pub type Parser = frame::Parser<{ Morpheus::TICK_REPLY_MAX }>;

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;

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
                Some(Err(PacketError::Checksum { id })) => found.push(Err(id)),
                Some(Err(PacketError::Header)) | None => {}
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
