//! Client library for an Armbridge board: links, the control link's protocol, sessions,
//! parameters by name, and the servo bus behind a board or an adapter.
//!
//! | module           | contents                                                   |
//! |------------------|------------------------------------------------------------|
//! | [`transport`]    | links by name; a [`Host`] driven over one                  |
//! | [`host`]         | the sans-io interface between a link and the code that uses it |
//! | [`session`]      | requests in order, arming, the emergency stop, leaving     |
//! | [`status`]       | latest message of each kind from a board                   |
//! | [`status_summary`] | the same in names, sentences and numbers            |
//! | [`event`]        | messages of a link, decoded from both directions' bytes    |
//! | [`event_queue`]  | the same, passed to another thread                         |
//! | [`telemetry`]    | records of the ticks, in blocks, for another thread        |
//! | [`setpoint_stream`] | setpoints as a program computes them, as commands       |
//! | [`board_clock`]  | the board's clock, as seen from the host                   |
//! | [`tap`]          | listeners to a link's bytes                                |
//! | [`simulation`]   | truth of a simulated arm, for those listeners              |
//! | [`params`]       | the board's settings as names with values                  |
//! | [`servo_bus`]    | servos found, read, written and reset, from the host       |
//! | [`servo_table`]  | servos' registers by name                                  |
//! | [`stdio`]        | standard output and error, which may be closed             |
//! | [`shell_text`]   | words of a command line                                    |
//! | [`flash_image`], [`image_list`] | a board's image in flash, and those of a release |
//! | [`ctrl_c`]       | signals that end the program, as a flag                    |
//! | [`enum_names`], [`fault_text`], [`refusal_text`], [`experiment_text`] | enums as names, and as sentences |
#![forbid(unsafe_code)]
// They panic where the output is gone: [`stdio`] does not.
#![deny(clippy::print_stderr, clippy::print_stdout)]

pub mod board_clock;
pub mod ctrl_c;
pub mod endpoint;
pub mod enum_names;
pub mod error;
pub mod event;
pub mod event_queue;
pub mod experiment_text;
pub mod fault_text;
pub mod flash_image;
pub mod host;
pub mod image_list;
pub mod number_text;
pub mod params;
#[cfg(unix)]
pub mod pty;
pub mod refusal_text;
pub mod servo_bus;
pub mod servo_table;
pub mod session;
pub mod setpoint_stream;
pub mod shell_text;
pub mod simulation;
pub mod status;
pub mod status_summary;
pub mod stdio;
pub mod tap;
pub mod tcp_pump;
pub mod telemetry;
pub mod toml_file;
pub mod transport;

pub use host::Host;
pub use session::{LinkStats, Session};
pub use tap::Tap;
pub use transport::LinkError;
