//! Dynamixel Protocol 2.0, the protocol of the X series (ROBOTIS e-Manual, "DYNAMIXEL
//! Protocol 2.0").
//!
//! ```text
//! instruction  FF FF FD 00 | ID | LEN_L LEN_H | INST | P1 .. Pn         | CRC_L CRC_H
//! status       FF FF FD 00 | ID | LEN_L LEN_H | 55   | ERR | P1 .. Pn   | CRC_L CRC_H
//! fast status  FF FF FD 00 | FE | LEN_L LEN_H | 55   | ERR | ID | data  | CRC_L CRC_H
//!                                                    | ERR | ID | data  | CRC_L CRC_H ..
//! LEN = bytes from INST on, the CRC included; CRC of all bytes before it
//! ```
//!
//! In the bytes from INST to the last parameter, FF FF FD is followed by one more FD, which LEN
//! and CRC count. A fast status packet is the answer of several servos to one instruction: each
//! adds its part and a CRC of all bytes so far, none is stuffed.
//!
//! | module          | content                                              |
//! |-----------------|------------------------------------------------------|
//! | [`frame`]       | header, length, stuffing: packets in both directions |
//! | [`crc`]         | CRC-16 of a packet                                   |
//! | [`Instruction`] | requests of a master                                 |
//! | [`Status`]      | status packets, the replies of a servo               |
//! | [`FastStatus`]  | the joint reply to a fast read                       |
//! | [`register`]    | addresses of the registers of the X series           |
//! | [`model`]       | models, found by their number, with their units      |
//!
//! # Example
//!
//! ```
//! use armbridge_servo::protocol2::{Instruction, Parser, Status, model, register};
//!
//! let read = Instruction::Read { address: register::PRESENT_POSITION, count: 4 };
//! let packet = read.encode::<16>(1).unwrap();
//! assert_eq!(
//!     packet,
//!     [0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x07, 0x00, 0x02, 0x84, 0x00, 0x04, 0x00, 0x1D, 0x15]
//! );
//!
//! // The answer of an XM430, byte by byte as a receiver delivers it.
//! let answer = [
//!     0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x08, 0x00, 0x55, 0x00, 0xA6, 0x00, 0x00, 0x00, 0x8C, 0xC0,
//! ];
//! let mut parser = Parser::<32>::new();
//! let mut position = None;
//! for byte in answer {
//!     if let Some(packet) = parser.push(byte) {
//!         let status = Status::decode(&packet.unwrap()).unwrap();
//!         assert!(status.id == 1 && status.is_sound());
//!         position = status.parameters.try_into().ok().map(i32::from_le_bytes);
//!     }
//! }
//! assert_eq!(position, Some(166));
//!
//! let model = model::find(1020).unwrap();
//! assert_eq!((model.name, model.counts_per_turn), ("XM430-W350", 4096));
//! ```

mod codec;
pub mod crc;
mod exchange;
mod fast_status;
pub mod frame;
mod instruction;
pub mod model;
pub mod register;
mod status;

pub use super::protocol::PacketError;
pub(super) use codec::{ends_with_part, position_parts, positions_bytes, torque_off};
pub use exchange::RETURN_DELAY_US;
pub use fast_status::{FastStatus, Part, PartError};
pub use frame::{BROADCAST, Frame, Parser, Protocol2};
pub use instruction::{BulkItem, Instruction, InstructionError};
pub use status::{Status, StatusError};
