//! The servo bus: wire formats and the half-duplex master.
//!
//! | module        | content                                                  |
//! |---------------|---------------------------------------------------------|
//! | [`Firmware`]  | firmware of a servo, which determines its protocol      |
//! | [`protocol`]  | the codec: finds, parses and builds packets             |
//! | `dispatch`    | the codec of a firmware that is known at run time       |
//! | `exchange`    | the part of a protocol that the master runs             |
//! | [`morpheus`]  | the Morpheus firmware's packets, only the harmless ones |
//! | [`protocol1`] | Dynamixel Protocol 1.0, of a stock AX-12A               |
//! | [`Alarms`]    | the seven bits of a status packet's error byte           |
//! | [`ClientFrame`] | a packet of another master, parsed                    |
//! | [`Pwm`]       | a PWM command                                           |
//! | [`Sample`]    | a servo's position in a tick, or the reason why it is missing |
//! | [`master`]    | one transaction at a time, advanced by `poll(now_us)`   |
//! | [`bus`]       | the half-duplex line, as the master uses it              |
//! | [`serial_bus`] | a line made of any serial port and pin                 |
//! | [`port`]      | a serial port whose speed can be changed                |
//! | [`stop`]      | the sequences that end with every motor off             |
//!
//! The bus is one wire, 8N1, at 1 Mbaud unless the servos are set to less: there a
//! byte takes 10 µs. A servo never sends without a request; a Morpheus servo never times
//! out, and obeys its last command for ever.

#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

pub mod bus;
pub mod master;
pub mod morpheus;
pub mod port;
pub mod protocol;
pub mod protocol1;
pub mod serial_bus;
pub mod stop;

mod alarms;
mod client;
mod dispatch;
mod exchange;
mod firmware;
mod id;
mod instruction;
mod packet;
mod pwm;
mod query;
mod sample;
mod transaction;

pub use alarms::Alarms;
pub use client::{ClientFrame, ClientRequest};
pub use dispatch::ReplyParser;
pub use firmware::Firmware;
pub use id::ServoId;
pub use instruction::{DecodeError, Instruction, SyncBlocks};
pub use packet::Packet;
pub use port::BYTE_US;
pub use pwm::Pwm;
pub use query::{ExpectedReply, Query};
pub use sample::{Missing, Sample};

/// Servos on the bus: one for each joint of the arm.
pub const JOINTS: usize = 2;
