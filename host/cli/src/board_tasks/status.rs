//! Status of board and link: a second of frames, and round trips.

use armbridge_client::session::Request;
use armbridge_client::transport::Intent;
use armbridge_link::message::{Command, Mode};

use super::{Task, TaskError, View};

/// Duration of listening: the board reports its servos' temperatures once a second.
const LISTEN_US: u64 = 1_200_000;
/// Time limit for the round trips.
const PINGS_US: u64 = 1_000_000;
/// Number of round trips.
const PINGS: usize = 10;

/// Listens, then measures round trips with a command without effect: idle.
#[derive(Debug, Default)]
pub struct Status {
    begun_us: Option<u64>,
    sent_us: Option<u64>,
    round_trips_us: Vec<u64>,
    /// Frames that had come when listening began, and those that came while it lasted.
    frames: [u64; 2],
    listened_us: u64,
    is_over: bool,
}

impl Status {
    /// Frames from the board in a second.
    pub fn frames_per_s(&self) -> f64 {
        let [_, frames] = self.frames;
        frames as f64 / (self.listened_us as f64 * 1e-6).max(1e-6)
    }

    /// Round trips in µs, shortest first.
    pub fn round_trips_us(&self) -> Vec<u64> {
        let mut sorted = self.round_trips_us.clone();
        sorted.sort_unstable();
        sorted
    }
}

impl Task for Status {
    fn look(&mut self, view: View<'_>) -> Result<(), TaskError> {
        let View { now_us, session } = view;
        if self.is_over || !session.is_greeted() {
            return Ok(());
        }
        let stats = session.stats();
        if self.begun_us.is_none() {
            self.frames[0] = stats.sent;
        }
        let listened_us = now_us - *self.begun_us.get_or_insert(now_us);
        self.frames[1] = stats.sent - self.frames[0];
        self.listened_us = listened_us;
        if listened_us < LISTEN_US {
            return Ok(());
        }
        if let Some(sent_us) = self.sent_us
            && session.take_answer().is_some()
        {
            self.sent_us = None;
            self.round_trips_us.push(now_us - sent_us);
        }
        // A command would take the bus from the transparent port.
        let may_ask = session.status().mode() != Some(Mode::Passthrough);
        let is_enough = self.round_trips_us.len() >= PINGS;
        if !may_ask || is_enough || listened_us > LISTEN_US + PINGS_US {
            self.is_over = true;
            session.request(now_us, Request::Leave);
        } else if self.sent_us.is_none() {
            self.sent_us = Some(now_us);
            // Without effect on a board that this session has found idle, or that parks the arm.
            session.request(now_us, Request::Command(Command::Park));
        }
        Ok(())
    }

    fn intent(&self) -> Intent {
        Intent::CommandOrObserve
    }

    fn disconnected(&mut self, _now_us: u64) {
        self.begun_us = None;
        self.sent_us = None;
    }
}
