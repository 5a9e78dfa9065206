//! The link's events, through the board's code again.

mod campaigns;
mod commands;
mod damaged_logs;
