//! Simulation: virtual servos, bus, arm and faults, byte for byte and microsecond for
//! microsecond, and everything that serves or drives a simulated board.
//!
//! | module                   | contents |
//! |--------------------------|------|
//! | [`morpheus_servo`]       | the Morpheus firmware, byte for byte |
//! | [`stock_servo`]          | the stock firmware of an AX-12A, by its documents |
//! | [`x_servo`]              | the firmware of the X series, by its documents |
//! | `packet_receiver`        | decoder of packets of the stock and the X servo |
//! | `status_transmitter`     | transmitter of the stock and the X servo |
//! | `encoder`                | readings of the servos' encoders: resolution and range |
//! | [`half_duplex_bus`]      | the half-duplex bus between master and servos |
//! | [`servo_kind`]           | kinds of servos: firmware, id, rate |
//! | [`plant`]                | the arm: dynamics, friction, encoders, motors |
//! | [`faults`]               | faults of sensors and host |
//! | `uart`                   | the virtual board's serial port |
//! | [`mod@bench`]            | servos, wire and arm together |
//! | [`board`]                | the board's interface to the bench; the application core in this process |
//! | [`cosim`]                | board, bus, arm and host in one virtual time |
//! | [`emulator`]             | the firmware image under QEMU |
//! | [`link`]                 | a host driven over any link, including those of simulated boards |
//! | [`link_server`]          | a simulated board's link, for another program |
//! | [`raw_bus_server`]       | the virtual servos alone, for another program |
//! | [`usb2dynamixel_server`] | a simulated board's transparent port, for another program |
//! | [`environment`]        | environments for learned controllers |
//! | `pacer`                  | keeps virtual time from running ahead of the wall clock |
//! | [`fault_campaign`]       | thousands of runs with injected faults |
//!
//! Nothing here is a measurement on hardware.
#![forbid(unsafe_code)]

pub mod bench;
pub mod board;
pub mod cosim;
mod drivetrain;
#[cfg(unix)]
pub mod emulator;
mod encoder;
pub mod environment;
pub mod fault_campaign;
pub mod faults;
pub mod half_duplex_bus;
pub mod link;
pub mod link_server;
pub mod morpheus_servo;
mod nonblocking;
mod pacer;
mod packet_receiver;
pub mod plant;
pub mod raw_bus_server;
pub mod servo_kind;
mod status_transmitter;
pub mod stock_servo;
mod uart;
pub mod usb2dynamixel_server;
pub mod x_servo;

pub use bench::Bench;
