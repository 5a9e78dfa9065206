//! What the board says of itself, and how the link does.

use armbridge_shared::link::message::{Command, Mode};

use super::{GaveUp, Task, View};
use armbridge_client::station::Request;

/// How long the board is listened to: it tells its servos' temperatures once a second.
const LISTEN_US: u64 = 1_200_000;
/// How long it may take to answer what measures the link.
const PINGS_US: u64 = 1_000_000;
/// How many round trips are measured.
const PINGS: usize = 10;

/// Listens, and measures round trips by asking for what is so already: to be idle.
#[derive(Debug, Default)]
pub struct Status {
    begun_us: Option<u64>,
    is_asking: bool,
    round_trips_ns: Vec<u64>,
    is_over: bool,
}

impl Status {
    /// Round trips in ns, shortest first.
    pub fn round_trips_ns(&self) -> Vec<u64> {
        let mut sorted = self.round_trips_ns.clone();
        sorted.sort_unstable();
        sorted
    }
}

impl Task for Status {
    fn look(&mut self, view: View<'_>) -> Result<(), GaveUp> {
        let View {
            now_us,
            model,
            desk,
        } = view;
        if self.is_over || !desk.is_greeted() {
            return Ok(());
        }
        let listened_us = now_us - *self.begun_us.get_or_insert(now_us);
        if listened_us < LISTEN_US {
            return Ok(());
        }
        if self.is_asking && desk.take_answer().is_some() {
            self.is_asking = false;
            self.round_trips_ns.extend(model.link.round_trip_ns);
        }
        // To ask would take the bus from whoever has it.
        let may_ask = model.mode() != Some(Mode::Passthrough);
        let is_enough = self.round_trips_ns.len() >= PINGS;
        if !may_ask || is_enough || listened_us > LISTEN_US + PINGS_US {
            self.is_over = true;
            desk.ask(now_us, Request::Leave);
        } else if !self.is_asking {
            self.is_asking = true;
            desk.ask(now_us, Request::Command(Command::Idle));
        }
        Ok(())
    }

    fn parted(&mut self, _now_us: u64) {
        self.begun_us = None;
        self.is_asking = false;
    }
}
