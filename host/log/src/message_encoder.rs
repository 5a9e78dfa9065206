//! Encoder of a link's events as the messages of a log, for the recorder and the
//! live server.

use armbridge_client::event::{Direction, Event, EventKind};
use armbridge_link::message::{Mode, Record, Settings, ToHost};

use super::clock_sync::{Envelope, Line, Mapping};
use super::simulation::{self, SimulationEvent, StateQueue};
use super::statistics::Counters;
use super::topics::Topic;
use super::{event_messages, event_text, parameters, proto, telemetry, visualization};

/// Board time between two poses of the arm: the frame rate of a screen.
const POSE_US: u64 = 20_000;

/// Host time between two messages of statistics.
const STATISTICS_NS: u64 = 1_000_000_000;

/// A message of a topic.
#[derive(Clone, Copy, Debug)]
pub struct Message<'a> {
    /// Its topic.
    pub topic: Topic,
    /// Time on the host's clock in ns; never earlier than the previous one on its topic.
    pub log_time_ns: u64,
    /// Protobuf encoding.
    pub bytes: &'a [u8],
}

/// Encoder of events.
#[derive(Debug, Default)]
pub struct Encoder {
    settings: Option<Settings>,
    mode: Option<Mode>,
    mapping: Mapping,
    envelope: Envelope,
    counters: Counters,
    session: Option<armbridge_link::message::BoardReport>,
    states: StateQueue,
    last_tick: Option<(u32, u64)>,
    is_disconnected: bool,
    last_pose_us: Option<u64>,
    statistics_at_ns: Option<u64>,
    latest_ns: [u64; Topic::ALL.len()],
    bytes: Vec<u8>,
}

impl Encoder {
    /// Encodes an event as messages, in order.
    ///
    /// # Errors
    /// Those of `put`.
    pub fn event<E>(
        &mut self,
        event: &Event,
        put: &mut impl FnMut(Message<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let at_ns = event.host_ns;
        let due_ns = *self
            .statistics_at_ns
            .get_or_insert(at_ns.saturating_add(STATISTICS_NS));
        if at_ns >= due_ns {
            self.statistics(at_ns, put)?;
            self.statistics_at_ns = Some(at_ns.saturating_add(STATISTICS_NS));
        }
        self.counters.count(&event.kind);
        match &event.kind {
            EventKind::Sent(sequence, content) => {
                let message = event_messages::command(at_ns, *sequence, content);
                self.put(Topic::Commands, at_ns, &message, put)
            }
            EventKind::Received(sequence, ToHost::Record(record)) => {
                self.tick(at_ns, *sequence, record, put)
            }
            EventKind::Received(sequence, ToHost::Settings(settings)) => {
                self.settings = Some(*settings);
                let message = parameters::message(at_ns, *sequence, settings);
                self.put(Topic::Parameters, at_ns, &message, put)?;
                self.scene(at_ns, put)
            }
            EventKind::Received(sequence, content) => {
                if let ToHost::Board(report) = content {
                    let is_reset = self.session.is_some_and(|old| old.is_before_reset(report));
                    if is_reset {
                        self.reset_clock();
                    }
                    self.session = Some(*report);
                }
                self.put_event(event_messages::board_event(at_ns, *sequence, content), put)
            }
            EventKind::Lost(..) | EventKind::Damaged(..) | EventKind::Disconnected => {
                self.is_disconnected |= event.kind == EventKind::Disconnected;
                match event_messages::link_event(at_ns, &event.kind) {
                    Some(message) => self.put_event(message, put),
                    None => Ok(()),
                }
            }
        }
    }

    /// Encodes an event of a simulation; a state waits for the record of its time.
    ///
    /// # Errors
    /// Those of `put`.
    pub fn simulated<E>(
        &mut self,
        event: &SimulationEvent,
        put: &mut impl FnMut(Message<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        match event {
            SimulationEvent::State(state) => {
                self.states.push(*state);
                Ok(())
            }
            SimulationEvent::Push(push) => {
                let message = simulation::push_message(push);
                self.put(Topic::SimulationPush, push.start_ns, &message, put)
            }
        }
    }

    /// Counts bytes of a direction.
    pub fn count_bytes(&mut self, direction: Direction, bytes: usize) {
        self.counters.count_bytes(direction, bytes);
    }

    /// Records the state of the queue to the disk in bytes: present size, largest size, and
    /// bytes that did not fit. An increase of the last is an event.
    ///
    /// # Errors
    /// Those of `put`.
    pub fn queue<E>(
        &mut self,
        at_ns: u64,
        [waiting, most, unwritten]: [u64; 3],
        put: &mut impl FnMut(Message<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let more = self.counters.queue([waiting, most, unwritten]);
        if more == 0 {
            return Ok(());
        }
        let event = proto::Event {
            host_ns: at_ns,
            severity: proto::Severity::Error.into(),
            kind: "unwritten".into(),
            text: format!("the disk is too slow: {more} bytes of the link are not in the log"),
            count: more,
            ..proto::Event::default()
        };
        self.put_event(event, put)
    }

    /// Received ticks, and missing ticks between them.
    pub fn ticks(&self) -> (u64, u64) {
        self.counters.ticks()
    }

    /// Relation of the two clocks, if it is known.
    pub fn clock(&self) -> Option<Line> {
        self.envelope.line()
    }

    /// Statistics so far.
    ///
    /// # Errors
    /// Those of `put`.
    pub fn statistics<E>(
        &mut self,
        at_ns: u64,
        put: &mut impl FnMut(Message<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let message = self.counters.message(at_ns, self.envelope.line());
        self.put(Topic::Statistics, at_ns, &message, put)?;
        self.scene(at_ns, put)
    }

    /// Resets the clock mapping: the board's clock restarts at zero.
    fn reset_clock(&mut self) {
        self.mapping.reset();
        self.envelope = Envelope::default();
        self.last_tick = None;
        self.last_pose_us = None;
    }

    fn tick<E>(
        &mut self,
        host_ns: u64,
        sequence: u16,
        record: &Record,
        put: &mut impl FnMut(Message<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        match self.last_tick {
            // A reset of the board without a message.
            Some((_, at_us)) if record.input.start_us < at_us => self.reset_clock(),
            Some((tick, _)) => self.gap(host_ns, tick, record.tick, put)?,
            None => {}
        }
        self.is_disconnected = false;
        self.last_tick = Some((record.tick, record.input.start_us));
        let at_ns = self.mapping.host_ns(host_ns, record.input.start_us);
        self.envelope.add(host_ns, record.input.start_us);
        self.counters.tick(record, host_ns.saturating_sub(at_ns));
        if let Some(state) = self.states.take(record.input.start_us) {
            let message = simulation::state_message(record.tick, &state);
            self.put(Topic::SimulationState, at_ns, &message, put)?;
        }
        let joints = self
            .settings
            .as_ref()
            .map(|settings| &settings.setup.joints);
        let message = telemetry::telemetry(host_ns, sequence, record, joints);
        self.put(Topic::Telemetry, at_ns, &message, put)?;
        if self.mode != Some(record.mode) {
            self.mode = Some(record.mode);
            let (severity, text) = event_text::mode(record.mode);
            let event = proto::Event {
                host_ns,
                time_s: Some(telemetry::seconds(record.input.start_us)),
                severity: severity.into(),
                kind: "mode".into(),
                text,
                tick: Some(record.tick),
                ..proto::Event::default()
            };
            self.put_event(event, put)?;
        }
        let is_due = self
            .last_pose_us
            .is_none_or(|at_us| record.input.start_us >= at_us.saturating_add(POSE_US));
        if is_due {
            self.last_pose_us = Some(record.input.start_us);
            self.put(
                Topic::JointStates,
                at_ns,
                &visualization::joints(at_ns, record),
                put,
            )?;
            let transforms =
                visualization::transforms(at_ns, record.output.angle_rad, self.settings.as_ref());
            self.put(Topic::Transforms, at_ns, &transforms, put)?;
        }
        Ok(())
    }

    /// Puts an event for ticks between two records that are not in the log.
    fn gap<E>(
        &mut self,
        host_ns: u64,
        before: u32,
        after: u32,
        put: &mut impl FnMut(Message<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let missing = after.saturating_sub(before).saturating_sub(1);
        if missing == 0 {
            return Ok(());
        }
        let why = if self.is_disconnected {
            ": the link was broken"
        } else {
            self.counters.missing(missing);
            ""
        };
        let (first, last) = (before + 1, after - 1);
        let event = proto::Event {
            host_ns,
            severity: proto::Severity::Warning.into(),
            kind: "gap".into(),
            text: format!("ticks {first} to {last} are not in the log{why}"),
            count: missing.into(),
            tick: Some(first),
            ..proto::Event::default()
        };
        self.put_event(event, put)
    }

    /// Puts an event, and its text.
    fn put_event<E>(
        &mut self,
        event: proto::Event,
        put: &mut impl FnMut(Message<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let at_ns = event.host_ns;
        self.put(Topic::Events, at_ns, &event, put)?;
        let log = visualization::log(at_ns, event.severity(), event.kind, event.text);
        self.put(Topic::Log, at_ns, &log, put)
    }

    fn scene<E>(
        &mut self,
        at_ns: u64,
        put: &mut impl FnMut(Message<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let scene = visualization::scene(at_ns, self.settings.as_ref());
        self.put(Topic::Scene, at_ns, &scene, put)
    }

    fn put<E>(
        &mut self,
        topic: Topic,
        at_ns: u64,
        message: &impl prost::Message,
        put: &mut impl FnMut(Message<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let latest_ns = &mut self.latest_ns[topic as usize];
        *latest_ns = at_ns.max(*latest_ns);
        self.bytes.clear();
        // A vector grows as needed.
        let _ = message.encode(&mut self.bytes);
        put(Message {
            topic,
            log_time_ns: *latest_ns,
            bytes: &self.bytes,
        })
    }
}
