//! What was heard on the link, through the board's code again.

mod broken;
mod campaigns;
mod orders;
