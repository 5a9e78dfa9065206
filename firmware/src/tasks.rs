//! The loops of the bridge, the same on every board.
//!
//! [`RealTimeLoop`] runs in an interrupt handler above everything but the handlers of the
//! bus; [`link`] and [`mod@client`] are tasks of an executor, in thread mode.
//! They share only the channels behind [`Bridge`], [`LinkPort`] and [`PortEnd`],
//! and [`Signals`].
//!
//! | module      | content                                                    |
//! |-------------|------------------------------------------------------------|
//! | `tick`      | the real-time loop: stop switch, tick, watchdog            |
//! | `host_link` | bytes between host and bridge, and saving of settings      |
//! | `client`    | bytes between a client and the transparent port            |
//! | `stream`    | byte streams of a board, for both byte loops               |
//! | `signals`   | the signals of the real-time loop to the others            |
//!
//! # Delays of the tick
//!
//! The tick interrupts all code of lower priority. Only shared resources could delay it,
//! and it never waits for them:
//!
//! * Channels are lock-free queues for one writer and one reader. A full one
//!   refuses, an empty one returns nothing. Their size bounds the number of commands in an
//!   iteration, so a flood on the link costs the tick no more than that.
//! * A critical section masks all interrupts, on a single core, so that its length
//!   is the only delay; its holder is never interrupted. The longest are: a line
//!   of the log copied to RTT, which drops what does not fit instead of waiting for
//!   a reader; a packet of 64 bytes copied to the USB controller; a check of the
//!   timers of two tasks. Each is some hundred instructions, a few µs at 168 MHz.
//! * Above the tick is only the handler of the bus, some 35 instructions: where DMA moves the
//!   bytes, four times a tick; where interrupts do, at most every 5 µs (2 Mbaud).
//!
//! A critical section also delays the handler that releases the line after a transmission,
//! which a servo leaves 45 µs for.
//!
//! A tick that is late or stuck nevertheless does not feed the watchdog.
//!
//! [`Bridge`]: armbridge_board::bridge::Bridge
//! [`LinkPort`]: armbridge_board::bridge::LinkPort
//! [`PortEnd`]: armbridge_board::bridge::transparent_port::PortEnd

mod client;
mod host_link;
mod signals;
mod stream;
mod tick;

pub use client::client;
pub use host_link::link;
pub use signals::Signals;
pub use stream::{FromClient, FromHost, LineChanges, ToHost};
pub use tick::{RealTime, RealTimeLoop, Wait};
