//! The host's servo tools: against lines that misbehave as told, and against
//! the virtual servos over TCP and a pseudo-terminal.

mod changes;
mod diagnosis;
mod fake;
mod live;
