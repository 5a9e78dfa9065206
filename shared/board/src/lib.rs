//! Application of an Armbridge board: control loop, supervisor, bus sequencer, settings in flash.
//!
//! The crate is the board between a host and the two AX-12A servos of an arm, without the
//! hardware: firmware gives it a bus, a clock and flash, a simulator or a replay gives it
//! simulated ones, and each gets the same outputs. It can also be used in parts: the control
//! loop closes around any plant that has two such servos.
//!
//! The supervisor permits to drive the motors, and the control loop obeys it in each tick:
//!
//! ```
//! use armbridge_board::checkpoints::Checkpoints;
//! use armbridge_board::supervisor::{Event, Supervisor};
//! use armbridge_board::tick::{ControlLoop, DriveRequest, Instant, LoopConfig, step};
//! use armbridge_link::message::{Sample, Settings};
//! use armbridge_link::record::TickInput;
//!
//! let config = LoopConfig::build(&Settings::default()).unwrap();
//! let (mut control, mut supervisor) = (ControlLoop::new(&config), Supervisor::default());
//! let upright = DriveRequest::Regulate([0.0, 0.0]);
//! control.request(&config, &upright, Instant::default()).unwrap();
//! let mut tick = |supervisor: &Supervisor| {
//!     let samples = [Sample::Counts(530), Sample::Counts(500)];
//!     let permission = supervisor.permission();
//!     let input = TickInput { samples, permission, ..TickInput::AT_REST };
//!     step(&config, &mut control, &input, &mut Checkpoints::default()).pwm
//! };
//!
//! assert_eq!(tick(&supervisor), [1000; 2]);
//! for event in [Event::BusReady, Event::Arm] {
//!     supervisor.apply(event).unwrap();
//!     assert_eq!(tick(&supervisor), [1000; 2]);
//! }
//! supervisor.apply(Event::Drive).unwrap();
//! assert_ne!(tick(&supervisor), [1000; 2]);
//! supervisor.apply(Event::Disarm).unwrap();
//! assert_eq!(tick(&supervisor), [1000; 2]);
//! ```
//!
//! # Modules
//!
//! | module           | content                                             |
//! |------------------|-----------------------------------------------------|
//! | [`tick`]         | outputs of a tick from its inputs, as plain values  |
//! | [`supervisor`]   | states of the board, and the permission to drive    |
//! | [`sequencer`]    | uses of the servo bus, in the order of their urgency |
//! | [`bridge`]       | these three and the link combined                   |
//! | [`store`]        | settings in flash                                   |
//! | [`checkpoints`]  | evidence for the watchdog                           |
//! | [`lockstep`]     | virtual time for an emulated board                  |
//!
//! Begin with [`tick`] for control alone, and with [`bridge::Bridge`] for a board.
//!
//! # Units and conventions
//!
//! Angles in rad, speeds in rad/s, torques in N m, times in µs of a clock that never goes back
//! (`now_us: u64`). A tick begins by sending the command that the tick before decided. Numbers
//! are `f32` throughout.
//!
//! # Contract
//!
//! This crate is *sans-io*. It never touches hardware, never reads a clock and never
//! allocates: time is an argument, bytes go through a [`Bus`](armbridge_servo::bus::Bus),
//! settings through an [`embedded_storage::nor_flash::NorFlash`], and every state machine is
//! advanced by a `poll(now_us)` that returns at once. It is `no_std` and has no `unsafe`.
//!
//! Equal inputs give equal outputs, to the bit, on a Cortex-M4F and on a PC. Nothing that bus,
//! host or client can send makes it panic: Armbridge links this code into a firmware image in
//! which a reachable panic is an error of the linker.
//!
//! # Features
//!
//! | feature | effect                                                        |
//! |---------|---------------------------------------------------------------|
//! | `defmt` | `defmt::Format` for the types of the crates below that a board logs |
//!
//! It is off by default.
//!
//! # Versions
//!
//! Below 1.0 a breaking change raises the minor number. Rust 1.89 or later is required.
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

pub mod bridge;
pub mod checkpoints;
pub mod lockstep;
pub mod sequencer;
pub mod store;
pub mod supervisor;
pub mod tick;
