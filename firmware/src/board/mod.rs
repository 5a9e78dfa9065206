//! The boards; a build is for one of them.
//!
//! `stm32` is what boards of that family share.

#[cfg(feature = "feather-f405")]
pub mod feather_f405;
#[cfg(feature = "mps2-an386")]
pub mod mps2_an386;
#[cfg(feature = "feather-f405")]
pub mod stm32;

#[cfg(feature = "feather-f405")]
pub(crate) use feather_f405 as chosen;
#[cfg(feature = "mps2-an386")]
pub(crate) use mps2_an386 as chosen;
