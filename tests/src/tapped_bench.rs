//! A bench with a tap on its link, and a host with a script of actions.

use std::collections::VecDeque;

use armbridge_analysis::plan_runner::{PlanRunner, Script};
use armbridge_board::bridge::Channels;
use armbridge_client::Host;
use armbridge_client::event::{Direction, Event, EventKind, LinkDecoder};
use armbridge_client::session::{BoardMessage, CommandLink};
use armbridge_link::message::{Command, Mode, Record, ToBoard, ToHost};
use armbridge_log::replay::{Changes, Replayer, Report, Verdict};
use armbridge_sim::Bench;
use armbridge_sim::board::VirtualBoard;
use armbridge_sim::cosim::Cosim;
use armbridge_sim::plant::{Plant, PlantConfig};

/// Host with a tap: every message between it and the board.
pub struct TappedHost<H> {
    /// The host.
    pub host: H,
    decoder: LinkDecoder,
    /// Events of the link, in order.
    pub events: Vec<Event>,
    outgoing: Vec<u8>,
}

impl<H> TappedHost<H> {
    /// No events yet.
    pub fn new(host: H) -> Self {
        Self {
            host,
            decoder: LinkDecoder::default(),
            events: Vec::new(),
            outgoing: Vec::new(),
        }
    }
}

impl<H: Host> Host for TappedHost<H> {
    type Error = H::Error;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], H::Error> {
        self.outgoing.clear();
        self.outgoing.extend_from_slice(self.host.transmit(now_us)?);
        let events = &mut self.events;
        let push = |event| events.push(event);
        self.decoder
            .take(Direction::ToBoard, now_us * 1_000, &self.outgoing, push);
        Ok(&self.outgoing)
    }

    fn receive(&mut self, now_us: u64, bytes: &[u8]) -> Result<(), H::Error> {
        let events = &mut self.events;
        let push = |event| events.push(event);
        self.decoder
            .take(Direction::ToHost, now_us * 1_000, bytes, push);
        self.host.receive(now_us, bytes)
    }

    fn wake_at_us(&self) -> u64 {
        self.host.wake_at_us()
    }

    fn is_done(&self) -> bool {
        self.host.is_done()
    }
}

/// Events of a plan runner's run on the bench.
///
/// # Panics
/// If the runner gives up.
pub fn recorded(config: PlantConfig, seed: u64, script: Script) -> Vec<Event> {
    let mut channels = Channels::new();
    let board = VirtualBoard::new(channels.split()).expect("default set-up");
    let bench = Bench::new(Plant::new(config, seed));
    let mut run = Cosim::new(board, bench, TappedHost::new(PlanRunner::new(script)));
    run.run().expect("a run");
    run.host.events
}

/// Replays with other settings.
///
/// # Panics
/// If the board refuses these settings.
pub fn replay_with(events: &[Event], changes: Changes) -> Report {
    let mut replayer = Replayer::new(changes).expect("default set-up");
    for event in events {
        replayer.take(event).expect("valid settings");
    }
    replayer.finish().expect("valid settings")
}

/// Replays with the log's own settings.
///
/// # Panics
/// If the board refuses the log's settings.
pub fn replay(events: &[Event]) -> Report {
    replay_with(events, Changes::default())
}

/// Action of a [`ScriptedHost`].
#[derive(Clone, Copy, Debug)]
pub enum Action {
    /// A command; arming quotes the session last reported by the board.
    Command(Command),
    /// A message, sent once.
    Message(ToBoard),
    /// Silence for this time in µs.
    Silence(u64),
}

/// A host that acts by a script, whose time stands still while the motors are checked.
#[derive(Debug)]
pub struct ScriptedHost {
    client: CommandLink,
    actions: VecDeque<(u64, Action)>,
    until_us: u64,
    now_us: u64,
    silent_us: u64,
    session: u32,
    /// When the present check of the motors began, and how long the others took.
    check_since_us: Option<u64>,
    checked_us: u64,
}

impl ScriptedHost {
    /// Time of the script in µs.
    fn script_us(&self) -> u64 {
        self.check_since_us.unwrap_or(self.now_us) - self.checked_us
    }

    /// Acts at these times in µs, in order.
    pub fn new(actions: impl IntoIterator<Item = (u64, Action)>, until_us: u64) -> Self {
        Self {
            client: CommandLink::default(),
            actions: actions.into_iter().collect(),
            until_us,
            now_us: 0,
            silent_us: 0,
            session: 0,
            check_since_us: None,
            checked_us: 0,
        }
    }
}

impl Host for ScriptedHost {
    type Error = std::convert::Infallible;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], Self::Error> {
        self.now_us = now_us;
        let script_us = self.script_us();
        while let Some((_, act)) = self
            .actions
            .front()
            .is_some_and(|(at_us, _)| *at_us <= script_us)
            .then(|| self.actions.pop_front())
            .flatten()
        {
            match act {
                Action::Command(Command::Arm { .. }) => self.client.command(Command::Arm {
                    session: self.session,
                }),
                Action::Command(command) => self.client.command(command),
                Action::Message(message) => self.client.send(message),
                Action::Silence(lasts_us) => self.silent_us = now_us + lasts_us,
            }
        }
        if now_us < self.silent_us {
            return Ok(&[]);
        }
        Ok(self.client.transmit(now_us))
    }

    fn receive(&mut self, now_us: u64, mut bytes: &[u8]) -> Result<(), Self::Error> {
        self.now_us = now_us;
        while let Some(message) = self.client.receive(&mut bytes) {
            match message {
                BoardMessage::Other(ToHost::Board(report)) => self.session = report.session,
                BoardMessage::Other(ToHost::Record(record)) => {
                    if record.mode == Mode::MotorCheck {
                        self.check_since_us.get_or_insert(now_us);
                    } else if let Some(since_us) = self.check_since_us.take() {
                        self.checked_us += now_us - since_us;
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn wake_at_us(&self) -> u64 {
        let client_us = self.client.wake_at_us().max(self.silent_us);
        if self.check_since_us.is_some() {
            return client_us;
        }
        let act_us = self.actions.front().map_or(u64::MAX, |(at_us, _)| *at_us);
        client_us.min(act_us.min(self.until_us) + self.checked_us)
    }

    fn is_done(&self) -> bool {
        self.script_us() >= self.until_us
    }
}

/// A scripted host's run on the bench, as events of the link; `each_ms` may change bench and
/// board.
///
/// # Panics
/// If there is no default set-up.
pub fn tapped_run(
    host: ScriptedHost,
    config: PlantConfig,
    seed: u64,
    mut each_ms: impl FnMut(u64, &mut Bench, &mut VirtualBoard<'_>),
) -> Vec<Event> {
    let mut channels = Channels::new();
    let board = VirtualBoard::new(channels.split()).expect("default set-up");
    let bench = Bench::new(Plant::new(config, seed));
    let mut run = Cosim::new(board, bench, TappedHost::new(host));
    let mut next_us = 0;
    while !run.host.is_done() {
        if run.now_us() >= next_us {
            each_ms(next_us / 1_000, &mut run.bench, &mut run.board);
            next_us += 1_000;
        }
        let Ok(()) = run.step_until(next_us);
    }
    run.host.events
}

/// The records among the events.
pub fn records(events: &[Event]) -> impl Iterator<Item = Record> {
    events.iter().filter_map(|event| match event.kind {
        EventKind::Received(_, ToHost::Record(record)) => Some(record),
        _ => None,
    })
}

/// Everything that was compared is the same.
///
/// # Panics
/// If not.
#[track_caller]
pub fn assert_equal(report: &Report) {
    assert_eq!(report.verdict, Verdict::Equal, "{}", report.text());
}

/// Everything is the same, and nothing was left out.
///
/// # Panics
/// If not.
#[track_caller]
pub fn assert_all_equal(report: &Report) {
    assert_equal(report);
    assert_eq!(report.compared, report.records, "{}", report.text());
}
