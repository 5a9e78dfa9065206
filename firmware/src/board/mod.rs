//! The boards; a build is for one of them.
//!
//! | board | chip | what it is |
//! |-------|------|------------|
//! | `feather_f405` | STM32F405RG | a small board; the default |
//! | `nucleo_f446ze` | STM32F446ZE | a board with a debug probe, for the vendor's shield |
//! | `mps2_an386` | Cortex-M4F of QEMU | the emulated board, in which time can be the bench's |
//!
//! `stm32` is what the first two share: a further board of the family is a file such as
//! theirs, a row in `boards.rs`, a feature in the manifest, and a program of one line.

#[cfg(feature = "feather-f405")]
pub mod feather_f405;
#[cfg(feature = "mps2-an386")]
pub mod mps2_an386;
#[cfg(feature = "nucleo-f446ze")]
pub mod nucleo_f446ze;
#[cfg(feature = "stm32")]
pub mod stm32;

#[cfg(feature = "feather-f405")]
use feather_f405::FeatherF405 as Chosen;
#[cfg(feature = "nucleo-f446ze")]
use nucleo_f446ze::NucleoF446ze as Chosen;

/// Crash handling of the chosen board.
#[cfg(feature = "mps2-an386")]
pub(crate) use mps2_an386::crash;
#[cfg(feature = "stm32")]
pub(crate) use stm32::crash;
