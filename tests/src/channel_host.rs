//! A session on a link in a thread of its own, with a tap on what it receives.

use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;

use armbridge_client::error::SessionError;
use armbridge_client::event::{Direction, EventKind, LinkDecoder};
use armbridge_client::session::{ChannelHost, Request, SessionHandle};
use armbridge_client::transport::{LinkOptions, LinkUri, drive};
use armbridge_client::{LinkError, Tap};
use armbridge_link::message::{Command, Mode, ToHost};

use crate::served_board::{OFF, Served, until};

/// Received on the link.
#[derive(Clone, Debug, Default)]
pub struct Received {
    /// Records.
    pub records: u64,
    /// Mode of the last record.
    pub mode: Option<Mode>,
    /// Time of the last record by the board's clock, in µs.
    pub board_us: u64,
    /// Time of the first record of a fault by the board's clock, in µs.
    pub stopped_us: u64,
    /// Times that the link broke.
    pub partings: u32,
    /// Frames lost.
    pub lost: u64,
    /// The board was armed after the link had broken.
    pub was_armed_after: bool,
}

#[derive(Default)]
struct Watcher(LinkDecoder, Arc<Mutex<Received>>);

impl Tap for Watcher {
    fn bytes(&mut self, direction: Direction, host_ns: u64, bytes: &[u8]) {
        let received = &mut *self.1.lock().unwrap();
        self.0
            .take(direction, host_ns, bytes, |event| match event.kind {
                EventKind::Received(_, ToHost::Record(record)) => {
                    received.records += 1;
                    received.mode = Some(record.mode);
                    received.board_us = record.input.start_us;
                    if received.stopped_us == 0 && matches!(record.mode, Mode::Fault(_)) {
                        received.stopped_us = record.input.start_us;
                    }
                    received.was_armed_after |= received.partings > 0 && record.mode.is_armed();
                }
                EventKind::Lost(_, frames) => received.lost += u64::from(frames),
                EventKind::Sent(..)
                | EventKind::Received(..)
                | EventKind::Damaged(..)
                | EventKind::Disconnected => {}
            });
    }

    fn disconnected(&mut self, _host_ns: u64) {
        self.0 = LinkDecoder::default();
        self.1.lock().unwrap().partings += 1;
    }
}

/// End of a host's thread.
pub type Ended = Result<(), LinkError<SessionError>>;

/// A station on a link.
pub struct Manned {
    /// Requests to the station.
    pub controls: SessionHandle,
    received: Arc<Mutex<Received>>,
    /// Ends with the link.
    pub thread: JoinHandle<Ended>,
}

/// Options of a link that is tried again for so long.
pub fn options(patience: Duration) -> LinkOptions {
    LinkOptions {
        patience,
        ..LinkOptions::default()
    }
}

impl Manned {
    /// On a link that is tried again for so long.
    pub fn on(link: &LinkUri, patience: Duration) -> Self {
        let (station, controls) = ChannelHost::new();
        let received = Arc::new(Mutex::new(Received::default()));
        let thread = {
            let (link, received) = (link.clone(), Arc::clone(&received));
            std::thread::spawn(move || {
                let mut options = options(patience);
                options
                    .taps
                    .push(Box::new(Watcher(LinkDecoder::default(), received)));
                drive(&link, options, station).1
            })
        };
        Self {
            controls,
            received,
            thread,
        }
    }

    /// Requests.
    pub fn ask(&self, request: Request) {
        self.controls.request(request).unwrap();
    }

    /// Everything received so far.
    pub fn received(&self) -> Received {
        self.received.lock().unwrap().clone()
    }

    /// Has the arm held, with motors on.
    pub fn hold(&self, board: &Served) {
        until("idle", || self.received().mode == Some(Mode::Idle));
        self.ask(Request::Arm);
        self.ask(Request::Command(Command::Regulate([0.0; 2])));
        board.until("motors are on", |seen| {
            seen.mode.drive().is_some() && seen.pwm != OFF
        });
    }

    /// Waits for the end.
    pub fn end(self) -> Ended {
        self.thread.join().unwrap()
    }
}
