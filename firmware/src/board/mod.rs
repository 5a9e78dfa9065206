//! The boards; a build is for one of them.

#[cfg(feature = "mps2-an386")]
pub mod mps2_an386;
