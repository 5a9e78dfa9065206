//! The link's events, through the board's code again.

mod broken;
mod campaigns;
mod orders;
