//! The control link between board and host.
//!
//! | module      | what                                                     |
//! |-------------|----------------------------------------------------------|
//! | [`message`] | messages                                                 |
//! | [`mode`]    | what the board is doing, and why it stopped              |
//! | [`limits`]  | what the supervisor allows                               |
//! | [`board`]   | report of a board                                        |
//! | `setup`     | what the application computes with                       |
//! | [`motion`]  | motions, as they are asked for                           |
//! | [`experiment`] | experiments, why one may not be, and how one ended    |
//! | [`schema`]  | the hash by which two builds know that they agree on it  |
//! | [`frame`]   | how it is put on a wire                                  |

pub mod board;
pub mod experiment;
pub mod frame;
pub mod limits;
pub mod message;
pub mod mode;
pub mod motion;
pub mod schema;
mod setup;
