//! The messages of a log as protobuf: Rust made of `host/log/proto/armbridge.proto`, and
//! its descriptors. `UPDATE_SNAPSHOT=1 cargo test -p armbridge-tests --test
//! sim schema` makes both again.

// Made by a program, from a file that is documented.
#[allow(missing_docs, clippy::all, clippy::pedantic, unreachable_pub)]
#[rustfmt::skip]
mod armbridge;

pub use self::armbridge::*;

/// A `FileDescriptorSet` of all messages of this module.
pub const DESCRIPTORS: &[u8] = include_bytes!("armbridge.bin");
