//! Simulation: virtual servos, bus, arm and faults, byte for byte and microsecond for
//! microsecond, and everything that serves or drives a simulated board.
//!
//! | module                   | what |
//! |--------------------------|------|
//! | [`morpheus_servo`]       | the Morpheus firmware, byte for byte |
//! | [`stock_servo`]          | the firmware that an AX-12A comes with, by its documents |
//! | [`half_duplex_bus`]      | the half-duplex bus between master and servos |
//! | [`servo_kind`]           | which servos there are: firmware, id, rate |
//! | [`plant`]                | the arm: dynamics, friction, encoders, motors |
//! | [`faults`]               | what can go wrong with sensors and host |
//! | [`uart`]                 | the virtual board's serial port |
//! | [`mod@bench`]            | servos, wire and arm together |
//! | [`board`]                | what the bench drives; the application core in this process |
//! | [`cosim`]                | board, bus, arm and host in one virtual time |
//! | [`emulator`]             | the firmware image under QEMU |
//! | [`link`]                 | a host driven over any link, a simulated board's too |
//! | [`link_server`]          | a simulated board's link, for another program |
//! | [`raw_bus_server`]       | the virtual servos alone, for another program |
//! | [`usb2dynamixel_server`] | a simulated board's transparent port, for another program |
//! | [`pacer`]                | virtual time held back to the wall clock |
//! | [`fault_campaign`]       | thousands of runs in which something goes wrong |
//!
//! Nothing here is a measurement on hardware.
#![forbid(unsafe_code)]

pub mod bench;
pub mod board;
pub mod cosim;
mod drivetrain;
#[cfg(unix)]
pub mod emulator;
pub mod fault_campaign;
pub mod faults;
pub mod half_duplex_bus;
pub mod link;
pub mod link_server;
pub mod morpheus_servo;
mod nonblocking;
pub mod pacer;
pub mod plant;
pub mod raw_bus_server;
pub mod servo_kind;
pub mod stock_servo;
pub mod uart;
pub mod usb2dynamixel_server;

pub use bench::Bench;
