//! Dynamixel AX-12A and X-series servos on a half-duplex bus: wire formats, bus master, stop
//! sequences.
//!
//! The crate is for firmware and programs that own a servo bus: it builds and parses packets
//! of both firmwares of an AX-12A and of the X series, times the transactions of a control
//! loop, and switches motors off in whatever state the servos are. A stock AX-12A speaks
//! Dynamixel Protocol 1.0; one with the open Morpheus firmware takes a PWM and reports its
//! position once a tick; the X series speaks Protocol 2.0.
//!
//! ```
//! use armbridge_servo::{Firmware, ReplyParser, ServoId};
//!
//! let servo = ServoId::new(1).unwrap();
//! let query = Firmware::Stock.temperature_query(servo).unwrap();
//! assert_eq!(query.packet, [0xFF, 0xFF, 1, 4, 2, 43, 1, 0xCC]);
//!
//! // The servo's status packet, after a byte of noise.
//! let mut parser = ReplyParser::<16>::new(Firmware::Stock);
//! let mut received = [0x7F, 0xFF, 0xFF, 1, 3, 0, 38, 0xD5].into_iter();
//! let celsius = received.find_map(|byte| match parser.push(byte)? {
//!     Ok(Some(reply)) if reply.id == servo.get() => Firmware::Stock.temperature(reply.data),
//!     _ => None,
//! });
//! assert_eq!(celsius, Some(38));
//! ```
//!
//! # Modules
//!
//! | module        | content                                                  |
//! |---------------|---------------------------------------------------------|
//! | [`Firmware`]  | firmware of a servo, which determines its protocol      |
//! | [`protocol`]  | the codec: finds, parses and builds packets             |
//! | `dispatch`    | the codec of a firmware that is known at run time       |
//! | `exchange`    | the part of a protocol that the master runs             |
//! | [`morpheus`]  | the Morpheus firmware's packets, only the harmless ones |
//! | [`protocol1`] | Dynamixel Protocol 1.0, of a stock AX-12A               |
//! | [`protocol2`] | Dynamixel Protocol 2.0, of the X series: packets, models, the tick |
//! | [`Alarms`]    | the seven bits of a status packet's error byte           |
//! | [`ClientFrame`] | a packet of another master, parsed                    |
//! | [`Pwm`]       | a PWM command                                           |
//! | [`ControlMode`] | what the counts of a command are, PWM or current       |
//! | [`Sample`]    | a servo's position in a tick, or the reason why it is missing |
//! | [`master`]    | one transaction at a time, advanced by `poll(now_us)`   |
//! | [`bus`]       | the half-duplex line, as the master uses it              |
//! | [`serial_bus`] | a line made of any serial port and pin                 |
//! | [`port`]      | a serial port whose speed can be changed                |
//! | [`stop`]      | the sequences that end with every motor off             |
//!
//! Two examples show the layers in use: [`Master`](master::Master), a control tick on a
//! scripted serial port, and `examples/scan.rs`, a search for servos through a USB adapter.
//!
//! # Units and conventions
//!
//! The bus is one wire, 8N1, at 1 Mbaud unless the servos are set to less: there a
//! byte takes 10 µs. A servo never sends without a request; a Morpheus servo never times
//! out, and obeys its last command for ever.
//!
//! Times are in µs of a monotonic clock (`now_us: u64`), speeds in bits per second, positions
//! in encoder counts, 0..=1023 of an AX-12A and 0..=4095 of an X servo, torques as [`Pwm`]
//! counts 0..=2000 with 1000 for off. A bus has up to [`JOINTS`] servos under control; codecs and
//! queries work with any number.
//!
//! # Contract
//!
//! The crate is `no_std` and *sans-io*: it allocates nothing, has no `unsafe`, never touches
//! hardware and never reads a clock. [`bus::Bus`] is the only interface to a line; `poll`
//! returns at once. No byte that a bus can deliver makes it panic: Armbridge links this code
//! into a firmware image in which a reachable panic is an error of the linker.
//!
//! # Features
//!
//! | feature    | effect                                                         |
//! |------------|----------------------------------------------------------------|
//! | `defmt`    | `defmt::Format` for the types that a board logs                |
//! | `postcard` | samples and [`Firmware`] can be parts of postcard messages     |
//!
//! None is on by default.
//!
//! # Versions
//!
//! Below 1.0 a breaking change raises the minor number. Rust 1.89 or later is required.

#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

pub mod bus;
pub mod master;
pub mod morpheus;
pub mod port;
pub mod protocol;
pub mod protocol1;
pub mod protocol2;
pub mod serial_bus;
pub mod stop;

mod alarms;
mod client_request;
mod control_mode;
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
pub use client_request::{ClientFrame, ClientRequest};
pub use control_mode::ControlMode;
pub use dispatch::ReplyParser;
pub use firmware::Firmware;
pub use id::{JOINTS, ServoId, ServoIds};
pub use instruction::{DecodeError, Instruction, SyncBlocks};
pub use packet::Packet;
pub use port::BYTE_US;
pub use pwm::Pwm;
pub use query::{ExpectedReply, Query};
pub use sample::{Missing, Sample};
