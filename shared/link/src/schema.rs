//! Hash of the message schema, by which two builds check that they are compatible.
//!
//! Computed at compile time from the shape of every message type: names and
//! order of fields and variants, and their types. It changes when, and only
//! when, the encoding may.

use super::message::{Hello, ToBoard, ToHost};
use postcard_schema::key::Key;

/// Hash over [`ToBoard`] and [`ToHost`].
pub const HASH: [u8; 8] = {
    let board = Key::for_path::<ToBoard>("armbridge/to-board").to_bytes();
    let host = Key::for_path::<ToHost>("armbridge/to-host").to_bytes();
    let mut hash = [0; 8];
    let mut i = 0;
    while i < 8 {
        hash[i] = board[i] ^ host[i];
        i += 1;
    }
    hash
};

/// Version of this crate.
pub const VERSION: [u8; 3] = [
    number(env!("CARGO_PKG_VERSION_MAJOR")),
    number(env!("CARGO_PKG_VERSION_MINOR")),
    number(env!("CARGO_PKG_VERSION_PATCH")),
];

/// The hello of this build.
pub const HELLO: Hello = Hello {
    schema: HASH,
    version: VERSION,
};

const fn number(digits: &str) -> u8 {
    let mut value = 0;
    let mut i = 0;
    while i < digits.len() {
        value = value * 10 + (digits.as_bytes()[i] - b'0');
        i += 1;
    }
    value
}
