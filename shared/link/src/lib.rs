//! The control link between board and host.
//!
//! | module      | content                                                  |
//! |-------------|----------------------------------------------------------|
//! | [`message`] | messages                                                 |
//! | [`mode`]    | modes of the board, causes of faults                     |
//! | [`limits`]  | limits of the monitors                                   |
//! | [`board`]   | report of a board                                        |
//! | `setup`     | parameters of control and estimation                     |
//! | [`motion`]  | requested motions                                        |
//! | [`experiment`] | experiments, why one may not be, and how one ended    |
//! | [`schema`]  | hash of the schema, compared by both sides               |
//! | [`frame`]   | framing on the wire                                      |
//! | [`crc32`]   | checksum of frames, settings, image and crash record     |
//! | [`server`]  | messages of a served link that no board sees             |

#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

pub mod board;
pub mod crc32;
pub mod experiment;
pub mod frame;
pub mod limits;
pub mod message;
pub mod mode;
pub mod motion;
pub mod schema;
pub mod server;
mod setup;
