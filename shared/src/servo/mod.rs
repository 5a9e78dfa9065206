//! The servo bus: wire formats and the half-duplex master.
//!
//! | module        | what                                                    |
//! |---------------|---------------------------------------------------------|
//! | [`Firmware`]  | which program runs on a servo                           |
//! | [`protocol`]  | the codec: finds, parses and builds packets             |
//! | [`morpheus`]  | the Morpheus firmware's packets, only the harmless ones |
//! | [`protocol1`] | Dynamixel Protocol 1.0, what a stock AX-12A speaks      |
//! | [`ClientFrame`] | a packet of another master, parsed                    |
//! | [`Sample`]    | a servo's position in a tick, or why it is missing      |
//! | [`master`]    | one transaction at a time, advanced by `poll(now_us)`   |
//! | [`port`]      | a serial port whose speed can be changed                |
//! | [`stop`]      | the sequences that end with every motor off             |
//!
//! The bus is one wire, 8N1, at 1 Mbaud unless the servos are set to less: there a
//! byte takes 10 µs. A servo never speaks unasked; a Morpheus servo never times
//! out, and obeys its last command for ever.

pub mod master;
pub mod morpheus;
pub mod port;
pub mod protocol;
pub mod protocol1;
pub mod stop;

mod client;
mod firmware;
mod id;
mod instruction;
mod query;
mod sample;

pub use client::{ClientFrame, ClientRequest};
pub use firmware::{Firmware, ReplyParser};
pub use id::ServoId;
pub use instruction::{Instruction, Misread, SyncBlocks};
pub use query::{ExpectedReply, Query};
pub use sample::{Missing, Sample};

/// Time of one byte on the wire: ten bits at 1 Mbaud.
pub const BYTE_US: u64 = 10;

/// A packet of the bridge's own as it goes on the wire.
pub type Packet = heapless::Vec<u8, { morpheus::REQUEST_MAX }>;
