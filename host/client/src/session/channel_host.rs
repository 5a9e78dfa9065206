//! A host that takes its requests from a channel, for dashboards and servers: what the
//! board says, they hear by a [`Tap`](crate::Tap).

use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};

use super::{Request, Session};
use crate::error::SessionError;
use crate::{Host, interrupt};

/// Sending end of the channel.
pub type Requests = Sender<Request>;

/// How often it looks for requests: a key press is obeyed at once, for the eye.
const LOOK_US: u64 = 10_000;

/// The host.
#[derive(Debug)]
pub struct ChannelHost {
    requests: Receiver<Request>,
    session: Session,
    look_us: u64,
}

impl ChannelHost {
    /// A host that has not spoken yet, and where to put requests to it. With all
    /// sender dropped, it leaves.
    pub fn new() -> (Self, Requests) {
        let (sender, requests) = channel();
        let host = Self {
            requests,
            session: Session::default(),
            look_us: 0,
        };
        (host, sender)
    }

    fn look(&mut self, now_us: u64) {
        if interrupt::is_raised() {
            self.session.request(now_us, Request::Leave);
        }
        loop {
            match self.requests.try_recv() {
                Ok(request) => self.session.request(now_us, request),
                Err(TryRecvError::Empty) => return,
                Err(TryRecvError::Disconnected) => {
                    self.session.request(now_us, Request::Leave);
                    return;
                }
            }
        }
    }
}

impl Host for ChannelHost {
    type Error = SessionError;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], SessionError> {
        self.look(now_us);
        self.look_us = now_us + LOOK_US;
        self.session.transmit(now_us)
    }

    fn receive(&mut self, now_us: u64, bytes: &[u8]) -> Result<(), SessionError> {
        self.session.receive_all(now_us, bytes)
    }

    fn wake_at_us(&self) -> u64 {
        self.look_us.min(self.session.wake_at_us())
    }

    fn is_done(&self) -> bool {
        self.session.is_done()
    }

    fn disconnected(&mut self, _now_us: u64) {
        self.session.disconnected();
    }
}
