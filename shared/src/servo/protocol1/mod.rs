//! Dynamixel Protocol 1.0, what a stock AX-12A speaks (ROBOTIS e-Manual,
//! "DYNAMIXEL Protocol 1.0").
//!
//! ```text
//! instruction  FF FF | ID | LEN | INST  | P1 .. Pn | CHK     LEN = n + 2
//! status       FF FF | ID | LEN | ERROR | P1 .. Pn | CHK     n + 6 bytes in all
//! CHK = complement of the sum of ID, LEN, INST or ERROR, P1..Pn, modulo 256
//! ```
//!
//! | module          | what                                                 |
//! |-----------------|------------------------------------------------------|
//! | [`Protocol1`]   | the codec: finds packets and takes them apart        |
//! | [`frame`]       | header, length and checksum, both directions         |
//! | [`Instruction`] | what a master asks                                   |
//! | [`Status`]      | what a servo answers                                 |
//! | [`Alarms`]      | the seven bits of its error byte                     |
//! | [`register`]    | addresses of a servo's registers                     |
//! | `exchange`      | the packets of a tick, and how long servos take      |
//!
//! To all servos at once ([`BROADCAST`]) nothing is answered but PING, which
//! every servo answers, at the same time if there are several. Inside an
//! instruction packet a servo waits 100 ms for the next byte, then drops it.

mod alarms;
mod codec;
mod exchange;
pub mod frame;
mod instruction;
pub mod register;
mod status;

pub use super::instruction::{DecodeError, Instruction, SyncBlocks};
pub use super::protocol::Damage;
pub use alarms::Alarms;
pub(super) use codec::torque_off;
pub use exchange::RETURN_DELAY_US;
pub use frame::{BROADCAST, Frame, Parser, Protocol1};
pub use status::Status;
