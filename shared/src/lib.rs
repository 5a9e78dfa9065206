//! Everything in Armbridge that decides: the same code on the board, in the
//! emulator and on the host.
//!
//! This crate is *sans-io*. It never touches hardware, never reads a clock and
//! never allocates: time is passed in as microseconds of a monotonic clock
//! (`now_us: u64`), bytes go through `embedded-hal-nb` serial ports, and every
//! state machine is advanced by a `poll(now_us)` that returns at once.
//!
//! | module       | what lives there                                          |
//! |--------------|-----------------------------------------------------------|
//! | [`real`]     | the number type the mathematics is written over           |
//! | [`arm`]      | parameters, dynamics, linearisation, discretisation       |
//! | [`actuator`] | counts to radians, torque to PWM, per joint               |
//! | [`estimate`] | the arm's state, and what pushes it, from angle samples   |
//! | [`control`]  | torque from estimated state; trajectories                 |
//! | [`experiment`] | signals that drive the arm to be identified             |
//! | [`design`]   | gains from models: Riccati, pole placement, stability     |
//! | [`servo`]    | wire formats, register maps, the half-duplex bus master   |
//! | [`link`]     | messages between board and host, and their frames         |
//! | [`store`]    | settings in flash                                         |
//! | [`bridge`]   | the application: modes, supervisor, the tick, telemetry   |
//! | [`lockstep`] | virtual time for an emulated board                        |
//! | [`crc32`]    | the checksum of frames, settings, image and crash record  |
//!
//! Imports point down, in the order that `tests/layers.rs` holds: `bridge` uses
//! `supervisor`, `control_loop` and `sequencer`; these use `link`, whose messages carry
//! the configurations of `control` and `estimate`; all use `arm` or `actuator`. `servo`
//! uses `actuator` alone.
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

pub mod actuator;
pub mod arm;
pub mod bridge;
pub mod check_word;
pub mod control;
pub mod control_loop;
pub mod crc32;
pub mod design;
pub mod estimate;
pub mod experiment;
pub mod flow_token;
pub mod link;
pub mod lockstep;
pub mod real;
pub mod sequencer;
pub mod servo;
pub mod store;
pub mod supervisor;
mod trig;

/// Number of joints of the arm, and of servos on the bus.
pub const JOINTS: usize = 2;
