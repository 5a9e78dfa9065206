//! JSON server: a board for programs in any language, one JSON object a line both ways.
//!
//! Each connection is a host of its own on a link that is served to several, with the same
//! rules: one commands, any number watch, each may stop. Heartbeats are sent for it as long as it is
//! connected; the arm is parked or the board disarmed when its connection ends, in whatever
//! way, and when it does not read its answers.
//!
//! ```text
//! -> {"do":"arm"}
//! <- {"ok":true}
//! -> {"id":7,"do":"regulate","angle_rad":[0.1]}
//! <- {"id":7,"ok":false,"error":"request","text":"`regulate`: invalid length 1, expected ..."}
//! ```
//!
//! Requests are carried out in order, each when the one before has been answered, except a stop,
//! which is carried out at once. The names of a block's columns are those of every export.
//!
//! | file         | contents                                                    |
//! |--------------|-------------------------------------------------------------|
//! | `request`    | requests, parsed from a line                                |
//! | `answer`     | answers and errors as lines                                 |
//! | `block`      | ticks as columns                                            |
//! | `board`      | a request carried out by a board client                     |
//! | `connection` | lines of a connection, in and out                           |

mod answer;
mod block;
mod board;
mod connection;
mod request;

use std::io;
use std::net::TcpListener;
use std::sync::Arc;

use armbridge_sim::link::BoardUri;

/// Connections at a time.
const CONNECTIONS_MAX: usize = 16;

/// Begins to serve the board at this link to programs that connect to the listener, on threads that
/// last as long as the program.
///
/// # Errors
/// If the system has no thread left.
pub fn begin(listener: TcpListener, link: BoardUri) -> io::Result<()> {
    // Each connection has a share of it.
    let shares = Arc::new(());
    let accept = move || {
        for stream in listener.incoming().flatten() {
            if Arc::strong_count(&shares) > CONNECTIONS_MAX {
                connection::refuse(stream, "too many programs are connected");
                continue;
            }
            let (link, share) = (link.clone(), Arc::clone(&shares));
            let serve = move || {
                connection::serve(stream, &link);
                drop(share);
            };
            // Without a thread the connection is closed.
            let _ = std::thread::Builder::new().name("json".into()).spawn(serve);
        }
    };
    let accepting = std::thread::Builder::new().name("json-accept".into());
    accepting.spawn(accept).map(drop)
}
