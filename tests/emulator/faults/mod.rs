//! For any failure around the emulated firmware, or in it, the stop sequence is on
//! the bus within its bound.
//!
//! | what fails              | time         | bound                               |
//! |-------------------------|--------------|-------------------------------------|
//! | the host's process dies | lockstep     | [`external`]                    |
//! | the bus falls silent    | lockstep     | [`external`]                    |
//! | garbage on the link     | both         | [`external`], [`flood`]         |
//! | a stop, and what else cuts the servos' supply | both | [`supply`], [`internal`] |
//! | panic, hard fault, stack overflow, hang | slow motion | [`internal`]      |
//!
//! In lockstep time is the bench's, so that bounds are kept to the µs however busy
//! the machine is. A board that fails in itself is reset, which no bench can
//! follow: there QEMU's clock counts instructions, and the bound is held against
//! the board's own clock, as it stands in its log.

mod driving_host;
mod external;
mod flood;
mod internal;
mod slow_motion;
mod stop;
mod supply;
mod tap;
