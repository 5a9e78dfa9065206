//! The transparent port: raw servo-bus traffic, as through a `USB2Dynamixel`.
//!
//! A client of this port says what it would say to the bus. While nothing is
//! driven, that goes there as it is, but for what [`is_deafening`]. While a
//! control loop runs, it is judged, and what is harmless is asked by the board
//! itself, in what is left of the tick; the client can tell the difference only
//! by the time it takes.
//!
//! | part       | what                                                       |
//! |------------|------------------------------------------------------------|
//! | [`Framer`] | the client's bytes into whole packets                      |
//! | [`judge`]  | what may be done with one while a loop runs                |
//! | [`Job`]    | the board's own requests for it, each as long as time is   |
//!
//! Nothing here touches the bus or the port.

mod framer;
mod job;
#[cfg(test)]
mod packets;
mod policy;
mod voice;

pub use framer::{Framer, Item};
pub use job::{Ask, Job, Progress, Slack};
pub use policy::{Verdict, is_deafening, judge};
pub use voice::{BYTES_MAX, Bytes};
