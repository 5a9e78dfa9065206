//! A station on a link in a thread of its own, with somebody who watches what it hears.

use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;

use armbridge_client::error::SessionError;
use armbridge_client::event::{Direction, EventKind, LinkDecoder};
use armbridge_client::session::{ChannelHost, Request, SessionHandle};
use armbridge_client::transport::{LinkOptions, LinkUri, drive};
use armbridge_client::{LinkError, Tap};
use armbridge_shared::link::message::{Command, Mode, ToHost};

use crate::served_board::{OFF, Served, until};

/// What was heard on the link.
#[derive(Clone, Debug, Default)]
pub struct Heard {
    /// Records.
    pub records: u64,
    /// Mode of the last record.
    pub mode: Option<Mode>,
    /// Times that the link broke.
    pub partings: u32,
    /// Frames lost.
    pub lost: u64,
    /// The board was armed after the link had broken.
    pub was_armed_after: bool,
}

#[derive(Default)]
struct Watcher(LinkDecoder, Arc<Mutex<Heard>>);

impl Tap for Watcher {
    fn bytes(&mut self, direction: Direction, host_ns: u64, bytes: &[u8]) {
        let heard = &mut *self.1.lock().unwrap();
        self.0
            .take(direction, host_ns, bytes, |event| match event.kind {
                EventKind::Received(_, ToHost::Record(record)) => {
                    heard.records += 1;
                    heard.mode = Some(record.mode);
                    heard.was_armed_after |= heard.partings > 0 && record.mode.is_armed();
                }
                EventKind::Lost(_, frames) => heard.lost += u64::from(frames),
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

/// How a host's thread ended.
pub type Ended = Result<(), LinkError<SessionError>>;

/// A station on a link.
pub struct Manned {
    /// Requests to the station.
    pub controls: SessionHandle,
    heard: Arc<Mutex<Heard>>,
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
        let heard = Arc::new(Mutex::new(Heard::default()));
        let thread = {
            let (link, heard) = (link.clone(), Arc::clone(&heard));
            std::thread::spawn(move || {
                let mut options = options(patience);
                options
                    .taps
                    .push(Box::new(Watcher(LinkDecoder::default(), heard)));
                drive(&link, options, station).1
            })
        };
        Self {
            controls,
            heard,
            thread,
        }
    }

    /// Requests.
    pub fn ask(&self, request: Request) {
        self.controls.request(request).unwrap();
    }

    /// Everything heard so far.
    pub fn heard(&self) -> Heard {
        self.heard.lock().unwrap().clone()
    }

    /// Has the arm held, with motors on.
    pub fn hold(&self, board: &Served) {
        until("idle", || self.heard().mode == Some(Mode::Idle));
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
