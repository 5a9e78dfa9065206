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
//! | [`frame`]       | header, length and checksum, both directions         |
//! | [`Instruction`] | what a master asks                                   |
//! | [`Status`]      | what a servo answers                                 |
//! | [`Alarms`]      | the seven bits of its error byte                     |
//!
//! To all servos at once ([`BROADCAST`]) nothing is answered but PING, which
//! every servo answers, at the same time if there are several. Inside an
//! instruction packet a servo waits 100 ms for the next byte, then drops it.

mod alarms;
pub mod frame;
mod instruction;
mod status;

pub use alarms::Alarms;
pub use frame::{BROADCAST, Damage, Frame, Parser};
pub use instruction::{Instruction, Misread, SyncBlocks};
pub use status::Status;

/// Registers that the bridge itself needs, by their place in
/// [`AX12A`](super::table::AX12A).
pub mod register {
    /// Return delay, in 2 µs.
    pub const RETURN_DELAY: u8 = 5;
    /// Angle limits, clockwise then counter-clockwise, two bytes each: all 0
    /// for wheel mode, in which the moving speed is the motor's duty.
    pub const ANGLE_LIMITS: u8 = 6;
    /// What the torque limit is at power-up, two bytes.
    pub const MAX_TORQUE: u8 = 14;
    /// When a status packet is sent: 0 after PING, 1 after READ too, 2 always.
    pub const STATUS_RETURN_LEVEL: u8 = 16;
    /// Torque on or off.
    pub const TORQUE_ENABLE: u8 = 24;
    /// Wheel mode: duty 0..=1023, bit 10 for clockwise. The torque limit follows.
    pub const MOVING_SPEED: u8 = 32;
    /// Position 0..=1023, two bytes.
    pub const PRESENT_POSITION: u8 = 36;
    /// One byte, in °C.
    pub const PRESENT_TEMPERATURE: u8 = 43;
}
