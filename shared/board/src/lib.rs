//! The application of a board between a host and the servos of an arm.
//!
//! | module           | content                                             |
//! |------------------|-----------------------------------------------------|
//! | [`control_loop`] | outputs of a tick from its inputs, as plain values  |
//! | [`supervisor`]   | states of the board, and the permission to drive    |
//! | [`sequencer`]    | uses of the servo bus, in the order of their urgency |
//! | [`bridge`]       | these three and the link combined                   |
//! | [`store`]        | settings in flash                                   |
//! | [`flow_token`]   | evidence for the watchdog                           |
//! | [`lockstep`]     | virtual time for an emulated board                  |
//!
//! This crate is *sans-io*. It never touches hardware, never reads a clock and never
//! allocates: time is passed in as microseconds of a monotonic clock (`now_us: u64`), bytes go
//! through a [`Bus`](armbridge_servo::bus::Bus), and every state machine is advanced by a
//! `poll(now_us)` that returns at once.
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

pub mod bridge;
pub mod control_loop;
pub mod flow_token;
pub mod lockstep;
pub mod sequencer;
pub mod store;
pub mod supervisor;
