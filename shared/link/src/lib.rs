//! Control link of an Armbridge board: messages, settings, and frames on a stream of bytes.
//!
//! The crate is for both ends of the link: firmware of a board that controls a two-joint arm,
//! and programs that command it or record its ticks. The link is any ordered stream of bytes,
//! as of a USB serial port or a socket. A host opens a session with a hello, sends heartbeats
//! and commands, and receives a record of each tick.
//!
//! ```
//! use armbridge_link::frame::{Decoder, Encoder};
//! use armbridge_link::message::{Command, ToBoard};
//! use armbridge_link::schema;
//!
//! // The host: an empty frame to get into step, a hello, and a command.
//! let mut encoder = Encoder::default();
//! let command = Command::Regulate([0.3, -0.25]);
//! let mut stream = vec![0];
//! stream.extend_from_slice(encoder.encode(&ToBoard::Hello(schema::HELLO)).1);
//! let (sequence, frame) = encoder.encode(&ToBoard::Command(command));
//! stream.extend_from_slice(frame);
//!
//! // The board: it acknowledges a command by the sequence number of its frame.
//! let mut decoder = Decoder::default();
//! let received: Vec<_> = stream.iter().filter_map(|byte| decoder.push::<ToBoard>(*byte)).collect();
//! let [Ok(hello), Ok(second)] = received[..] else { panic!("{received:?}") };
//! assert_eq!(hello.message, ToBoard::Hello(schema::HELLO));
//! assert_eq!(second.message, ToBoard::Command(command));
//! assert_eq!((second.sequence, second.lost), (sequence, 0));
//! ```
//!
//! # Modules
//!
//! | module      | content                                                  |
//! |-------------|----------------------------------------------------------|
//! | [`message`] | messages                                                 |
//! | [`record`]  | record of a tick: inputs, outputs, timing                |
//! | [`fault`]   | faults: name, cause and remedy of each                   |
//! | [`mode`]    | modes of the board                                       |
//! | [`limits`]  | limits of the monitors                                   |
//! | [`board`]   | report of a board                                        |
//! | `setup`     | parameters of control and estimation                     |
//! | [`motion`]  | requested motions                                        |
//! | [`experiment`] | experiments, why one may not be, and how one ended    |
//! | [`schema`]  | hash of the schema, compared by both sides               |
//! | [`frame`]   | framing on the wire                                      |
//! | [`crc32`]   | checksum of frames, settings, image and crash record     |
//! | [`server`]  | messages of a served link that no board sees             |
//!
//! `examples/client.rs` is a whole client: hello, heartbeats, records, goodbye.
//!
//! # Order of a session
//!
//! 1. The host sends [`ToBoard::Hello`](message::ToBoard::Hello), and repeats it until the board
//!    answers with its own. Motors go off. The board reports its settings, servos and state.
//! 2. [`Command::Arm`](message::Command::Arm) needs the session's number from the board's
//!    [`BoardReport`](message::BoardReport); then any command that drives may follow.
//! 3. The host sends a message, at least a heartbeat, more often than every
//!    [`hold_ms`](limits::Limits::hold_ms), after which the board brakes the arm; after
//!    [`silence_ms`](limits::Limits::silence_ms) it switches the motors off.
//! 4. [`ToBoard::Goodbye`](message::ToBoard::Goodbye) disarms.
//!
//! # Units and conventions
//!
//! Names carry units: rad, rad/s, N m, µs, ms, and counts of PWM or encoder. Joints count from
//! 0. On the wire messages are in the format of postcard, integers of a frame's header little
//! endian. No text is sent.
//!
//! # Contract
//!
//! The crate is `no_std` and *sans-io*: it allocates nothing, has no `unsafe`, and neither
//! reads nor writes a port. [`frame::MAX`] bounds every frame. No byte that a link can deliver
//! makes a decoder panic: Armbridge links this code into a firmware image in which a reachable
//! panic is an error of the linker.
//!
//! # Features
//!
//! | feature | effect                                                        |
//! |---------|---------------------------------------------------------------|
//! | `defmt` | `defmt::Format` for modes, faults and causes, for a board's log |
//!
//! It is off by default.
//!
//! # Versions
//!
//! Below 1.0 a breaking change raises the minor number. Two builds whose messages differ are
//! told apart by [`schema::HASH`], which both send in their hello, whatever their version
//! numbers. Rust 1.89 or later is required.

#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

pub mod board;
pub mod crc32;
pub mod experiment;
pub mod fault;
pub mod frame;
pub mod limits;
pub mod message;
pub mod mode;
pub mod motion;
pub mod record;
pub mod schema;
pub mod server;
mod setup;
