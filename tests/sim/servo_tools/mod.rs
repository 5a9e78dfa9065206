//! The host's servo tools: against lines with scripted errors, and against
//! the virtual servos over TCP and a pseudo-terminal.

mod changes;
mod diagnosis;
mod live;
mod scripted_line;
