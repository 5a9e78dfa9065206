//! Simulation: virtual servos, bus, arm and faults, byte for byte and microsecond for
//! microsecond, and everything that serves or drives a simulated board.
//!
//! | module     | what                                                        |
//! |------------|-------------------------------------------------------------|
//! | [`servo`]  | the Morpheus firmware, byte for byte                        |
//! | [`stock`]  | the firmware that an AX-12A comes with, by its documents    |
//! | [`wire`]   | the half-duplex bus between master and servos               |
//! | [`kind`]   | which servos there are: firmware, id, rate                  |
//! | [`plant`]  | the arm: dynamics, friction, encoders, motors               |
//! | [`faults`] | what can go wrong with sensors and host                     |
//! | [`uart`]   | the virtual board's serial port                             |
//! | [`mod@bench`]  | servos, wire and arm together                               |
//! | [`board`]  | what the bench drives; the application core in this process |
//! | [`cosim`]  | board, bus, arm and host in one virtual time                |
//! | [`emulator`] | the firmware image under QEMU                             |
//! | [`link`]   | a host driven over any link, a simulated board's too        |
//! | [`link_server`] | a simulated board's link, for another program          |
//! | [`raw_bus_server`] | the virtual servos alone, for another program       |
//! | [`usb2dynamixel_server`] | a simulated board's transparent port, for another program |
//! | [`pacer`]  | virtual time held back to the wall clock                    |
//! | [`fault_campaign`] | thousands of runs in which something goes wrong     |
//!
//! Nothing here is a measurement on hardware.
#![forbid(unsafe_code)]

pub mod bench;
pub mod board;
pub mod cosim;
#[cfg(unix)]
pub mod emulator;
pub mod fault_campaign;
pub mod faults;
mod joints;
pub mod kind;
pub mod link;
pub mod link_server;
pub mod pacer;
pub mod plant;
pub mod raw_bus_server;
pub mod servo;
pub mod stock;
pub mod uart;
pub mod usb2dynamixel_server;
pub mod wire;

pub use bench::Bench;
