//! Servo bus from the host: servos found, read, written, renamed and reset.
//!
//! Raw bus bytes go through any stream that behaves as a `USB2Dynamixel`: the
//! board's transparent port, such an adapter or a U2D2 itself, or the virtual
//! servos of `armbridge serve servos`.
//!
//! | module            | contents                                                 |
//! |-------------------|----------------------------------------------------------|
//! | [`port`]          | a line by its name, opened                               |
//! | [`serial_device`] | a serial device, opened exclusively at a rate            |
//! | [`mod@line`]      | byte streams with timed reads and a baud rate            |
//! | [`request`]       | requests to a servo of either firmware                   |
//! | [`master`]        | one exchange: a request and its reply                    |
//! | [`diagnosis`]     | error of an exchange, and its likely cause               |
//! | [`servo`]         | registers by name, on whichever firmware the servo runs  |
//! | [`change`]        | id, baud rate and factory settings                       |
//! | [`reading`]       | results of reading and writing a register                |
//! | [`scan`]          | search for servos                                        |
//!
//! Accesses are slow, for a bus without a running control loop. Packets
//! that block the receivers of Morpheus servos ([`armbridge_servo::morpheus`]) are not
//! sent; where a Protocol 1.0 packet could begin to look like one, the servos'
//! receivers are flushed after it.

pub mod change;
pub mod diagnosis;
pub mod line;
pub mod master;
pub mod port;
pub mod reading;
pub mod request;
pub mod scan;
pub mod serial_device;
pub mod servo;

mod response;

pub use diagnosis::Diagnosis;
pub use line::Line;
pub use master::{BusError, BusMaster};
pub use port::Port;
pub use request::moves;
pub use response::Packet;
pub use servo::Servo;
