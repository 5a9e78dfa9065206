//! The messages of a log as protobuf, in Rust, and their descriptors.
//!
//! | module       | made of                                                              |
//! |--------------|----------------------------------------------------------------------|
//! | this         | `host/log/proto/armbridge.proto`                                     |
//! | [`foxglove`] | the schemas of Foxglove's library (© Foxglove Technologies Inc, MIT) |
//! | [`google`]   | the times in those                                                   |
//!
//! `UPDATE_SNAPSHOT=1 cargo test -p armbridge-tests --test sim schema` makes them again.

// Made by a program, from a file that is documented.
#[allow(missing_docs, clippy::all, clippy::pedantic, unreachable_pub)]
#[rustfmt::skip]
mod armbridge;

pub use self::armbridge::*;

/// A `FileDescriptorSet` of all messages of this module.
pub const DESCRIPTORS: &[u8] = include_bytes!("armbridge.bin");

/// Messages that viewers draw: log lines, joint states, frames and shapes.
#[allow(missing_docs, clippy::all, clippy::pedantic, unreachable_pub)]
#[rustfmt::skip]
pub mod foxglove;

/// Packages of Google.
pub mod google {
    /// Timestamp and duration.
    #[allow(missing_docs, clippy::all, clippy::pedantic, unreachable_pub)]
    pub mod protobuf {
        include!("google.protobuf.rs");
    }
}

/// The `FileDescriptorSet` of Foxglove's messages that are topics.
pub(super) mod descriptors {
    pub(crate) const FRAME_TRANSFORMS: &[u8] = include_bytes!("foxglove.FrameTransforms.bin");
    pub(crate) const JOINT_STATES: &[u8] = include_bytes!("foxglove.JointStates.bin");
    pub(crate) const LOG: &[u8] = include_bytes!("foxglove.Log.bin");
    pub(crate) const SCENE_UPDATE: &[u8] = include_bytes!("foxglove.SceneUpdate.bin");
}
