//! `armbridge foxglove`: the topics of a log, as they happen, on a Foxglove WebSocket server.
//!
//! ```text
//! link --bytes--> feed --events--> this thread --messages--> server --> viewers
//!      <-------------- requests ---------------- wishes ----/
//! ```
//!
//! Whoever is slow loses messages of its own: the feed and each viewer's backlog are
//! bounded and drop the oldest, and the link's thread never waits.
//!
//! | module      | what                                                             |
//! |-------------|------------------------------------------------------------------|
//! | [`server`]  | the server: channels, parameters, services                        |
//! | [`values`]  | the board's parameters as the viewer has them                     |
//! | [`board`]   | what is known of the board                                        |
//! | [`pending_requests`]    | what viewers wish, until the board has said what became of it     |
//! | [`run`]     | all of it together                                                |

pub mod board;
pub mod pending_requests;
pub mod run;
pub mod server;
pub mod values;
