//! `armbridge foxglove`: the topics of a log, as they happen, on a Foxglove WebSocket server.
//!
//! ```text
//! link --bytes--> event queue --events--> this thread --messages--> server --> viewers
//!      <----------------- requests ---------------------------------------'
//! ```
//!
//! A slow viewer loses only messages of its own: the event queue and each viewer's backlog
//! are bounded and drop the oldest, and the link's thread never waits.
//!
//! The server is ours, not that of the `foxglove` crate, which takes any page of any site
//! for a viewer, has no token, and does not end a handshake; its messages are that crate's,
//! and its connections are `tungstenite`'s.
//!
//! | module               | content                                                |
//! |----------------------|--------------------------------------------------------|
//! | [`access`]           | who may connect, and who may command                   |
//! | [`server`]           | the server: handshakes, topics, services               |
//! | [`viewer`]           | a viewer: subscriptions, rights, what waits for it     |
//! | [`values`]           | the board's parameters as viewers have them, and back  |
//! | [`board`]            | the board's status and latest refusal                  |
//! | [`pending_requests`] | viewers' requests until their result is known          |
//! | [`run`]              | the loop over events and requests                      |

pub mod access;
pub mod board;
pub mod pending_requests;
pub mod run;
pub mod server;
pub mod values;
pub mod viewer;
