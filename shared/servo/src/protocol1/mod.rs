//! Dynamixel Protocol 1.0, the protocol of a stock AX-12A (ROBOTIS e-Manual,
//! "DYNAMIXEL Protocol 1.0").
//!
//! ```text
//! instruction  FF FF | ID | LEN | INST  | P1 .. Pn | CHK     LEN = n + 2
//! status       FF FF | ID | LEN | ERROR | P1 .. Pn | CHK     n + 6 bytes in all
//! CHK = complement of the sum of ID, LEN, INST or ERROR, P1..Pn, modulo 256
//! ```
//!
//! | module          | content                                              |
//! |-----------------|------------------------------------------------------|
//! | [`Protocol1`]   | the codec: finds and parses packets                  |
//! | [`frame`]       | header, length and checksum, both directions         |
//! | [`Instruction`] | requests of a master                                 |
//! | [`Status`]      | status packets, the replies of a servo               |
//! | [`register`]    | addresses of a servo's registers                     |
//! | `exchange`      | the packets of a tick, and response times            |
//!
//! Of the packets to all servos ([`BROADCAST`]) only PING is answered, by every servo,
//! at the same time if there are several. Inside an
//! instruction packet a servo waits 100 ms for the next byte, then drops it.
//!
//! # Example
//!
//! ```
//! use armbridge_servo::protocol1::{Instruction, Parser, Status, register};
//!
//! let (address, count) = (register::PRESENT_POSITION, 2);
//! let read = Instruction::Read { address, count };
//! assert_eq!(read.encode::<8>(1).unwrap(), [0xFF, 0xFF, 1, 4, 2, 36, 2, 0xD2]);
//!
//! // The servo's answer, byte by byte as a receiver delivers it.
//! let mut parser = Parser::<16>::new();
//! let mut position = None;
//! for byte in [0xFF, 0xFF, 1, 4, 0, 0x07, 0x02, 0xF1] {
//!     if let Some(packet) = parser.push(byte) {
//!         let status = Status::decode(&packet.unwrap()).unwrap();
//!         assert!(status.id == 1 && status.alarms.is_empty());
//!         position = status.word();
//!     }
//! }
//! assert_eq!(position, Some(519));
//! ```

mod codec;
mod exchange;
pub mod frame;
mod instruction;
pub mod register;
mod status;

pub use super::instruction::{DecodeError, Instruction, SyncBlocks};
pub use super::protocol::PacketError;
pub(super) use codec::torque_off;
pub use exchange::{CONTROL_STEP_US, RETURN_DELAY_US};
pub use frame::{BROADCAST, Frame, Parser, Protocol1};
pub use status::Status;
