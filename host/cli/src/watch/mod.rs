//! `armbridge watch`: a dashboard on a terminal.
//!
//! | module      | what                                                            |
//! |-------------|-----------------------------------------------------------------|
//! | [`model`]   | the board's and the link's state, from the link's events         |
//! | [`view`]    | a picture of it, on any terminal from 80x24 on                   |
//! | [`keys`]    | what keys do                                                     |
//! | [`hand`]    | hands on a simulated arm                                         |
//! | [`playback`] | the motion of the last float, replayed                          |
//! | [`screen`]  | the terminal                                                     |

pub mod hand;
pub mod keys;
pub mod model;
pub mod playback;
pub mod screen;
pub mod view;
