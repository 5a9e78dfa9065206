//! The loop: events to viewers, their requests to the board.

use std::collections::VecDeque;
use std::convert::Infallible;
use std::time::{Duration, SystemTime};

use armbridge_client::ctrl_c;
use armbridge_client::event::Event;
use armbridge_client::event_queue::EventQueue;
use armbridge_client::session::Request;
use armbridge_link::message::{Command, Settings};
use armbridge_log::message_encoder::{Encoder, Message};
use armbridge_log::topics::Topic;
use armbridge_sim::link::LinkThread;

use super::board::Board;
use super::pending_requests::{Outcome, PendingRequests};
use super::server::{Server, ServerError};
use super::values;
use super::viewer::ViewerId;

/// Period of the loop: viewers get messages at most this old, at 1 kHz five at a time.
const LOOK: Duration = Duration::from_millis(5);

/// A time before this, in ns since 1970, is virtual.
const REAL_NS: u64 = 1_000_000_000_000_000_000;

/// Statistics of a server.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Served {
    /// Messages published.
    pub messages: u64,
    /// Events that the queue dropped.
    pub unseen: u64,
}

/// Serves viewers until ctrl-c, or until the link ends. When a viewer leaves that has armed
/// the arm, or its connection breaks, the arm is disarmed, also while others watch.
///
/// # Errors
/// If no viewer can connect any more.
pub fn run(
    session: &LinkThread,
    event_queue: &EventQueue,
    server: &mut Server,
) -> Result<Served, ServerError> {
    let mut live = Live {
        server,
        board: Board::default(),
        pending: PendingRequests::default(),
        encoder: Encoder::default(),
        later_ns: None,
        parameters: None,
        served: Served::default(),
    };
    let (mut events, mut requests) = (VecDeque::new(), Vec::new());
    // Viewers that have armed since the arm was last disarmed here.
    let mut operators: Vec<ViewerId> = Vec::new();
    while !session.is_over() && !ctrl_c::is_raised() {
        live.served.unseen += event_queue.take(&mut events);
        for event in &events {
            live.event(event);
        }
        let outcome = live.pending.settle(&live.board);
        live.apply(session, outcome);
        live.server.poll(&mut requests)?;
        for (viewer, request) in requests.drain(..) {
            let outcome = live.pending.take(viewer, request, &live.board);
            if outcome.requests.contains(&Request::Arm) && !operators.contains(&viewer) {
                operators.push(viewer);
            }
            live.apply(session, outcome);
        }
        if operators.iter().any(|viewer| !live.server.has(*viewer)) {
            operators.clear();
            session.request(Request::Command(Command::Park));
        }
        std::thread::sleep(LOOK);
    }
    Ok(live.served)
}

struct Live<'a> {
    server: &'a mut Server,
    board: Board,
    pending: PendingRequests,
    encoder: Encoder,
    /// Wall clock minus virtual clock, in ns.
    later_ns: Option<u64>,
    /// The latest message of that topic, published again for viewers that connect later.
    parameters: Option<Vec<u8>>,
    served: Served,
}

impl Live<'_> {
    fn apply(&mut self, session: &LinkThread, outcome: Outcome) {
        for request in outcome.requests {
            session.request(request);
        }
        for (viewer, reply) in outcome.replies {
            self.server.reply(viewer, reply);
        }
    }

    fn event(&mut self, event: &Event) {
        let before = self.board.status.settings;
        self.board.take(event);
        if self.board.status.settings != before {
            self.publish_changes(before.as_ref());
        }
        let later_ns = *self
            .later_ns
            .get_or_insert_with(|| later_than(event.host_ns));
        let event = Event {
            host_ns: event.host_ns.saturating_add(later_ns),
            ..*event
        };
        let Self {
            server,
            encoder,
            parameters,
            served,
            ..
        } = self;
        let mut put = |message: Message<'_>| -> Result<(), Infallible> {
            served.messages += 1;
            server.put(&message);
            match (message.topic, parameters.as_ref()) {
                (Topic::Parameters, _) => *parameters = Some(message.bytes.to_vec()),
                (Topic::Statistics, Some(bytes)) => server.put(&Message {
                    topic: Topic::Parameters,
                    bytes,
                    ..message
                }),
                _ => {}
            }
            Ok(())
        };
        match encoder.event(&event, &mut put) {
            Ok(()) => {}
            Err(never) => match never {},
        }
    }

    /// Publishes the parameters that have changed.
    fn publish_changes(&mut self, before: Option<&Settings>) {
        let Some(settings) = &self.board.status.settings else {
            return;
        };
        let changed: Vec<String> = before.map_or_else(Vec::new, |before| {
            let changed = armbridge_client::params::changed(before, settings);
            let keys = changed.into_iter();
            keys.map(|(parameter, _)| parameter.key.to_owned())
                .collect()
        });
        // None by name is all of them.
        self.server.publish(&values::parameters(settings, &changed));
    }
}

/// Wall clock minus `host_ns`; 0 if that is wall-clock time already. Viewers show the
/// present.
fn later_than(host_ns: u64) -> u64 {
    if host_ns > REAL_NS {
        return 0;
    }
    let since_1970 = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    (since_1970.unwrap_or_default().as_nanos() as u64).saturating_sub(host_ns)
}
