//! Collects a [`Run`] for the figures, event by event, in bounded memory.

use armbridge_client::LinkStats;
use armbridge_client::enum_names;
use armbridge_client::event::{Event, EventKind};
use armbridge_log::run_info::RunFacts;
use armbridge_log::simulation::Push;
use armbridge_log::summary::{Counts, Tally};
use armbridge_log::time_origin::RunTimes;
use armbridge_shared::JOINTS;
use armbridge_shared::link::message::{Command, Record, Settings, ToBoard, ToHost};

use super::marks::Mark;
use super::reduce::{Reduced, Tick, reference};
use super::run::Run;
use super::spectrum::Welches;
use super::timing::QUANTITIES;
use super::trace::Trace;

/// Largest number of marks: more do not fit beside each other.
const MARKS_MAX: usize = 500;

/// Smallest cells of traces, finer than any figure: rad and rad/s.
const ANGLE_CELL: f64 = 1e-4;
const SPEED_CELL: f64 = 1e-3;

/// A run in progress.
#[derive(Debug)]
pub struct Collector {
    /// Window in s after the origin.
    window_s: [Option<f64>; 2],
    /// Facts, with the settings in force: those that were reported last before the motors were
    /// first driven.
    facts: RunFacts,
    settings: Option<Settings>,
    times: RunTimes,
    last: Option<Record>,
    tally: Tally,
    shown: Shown,
    marks: Vec<Mark>,
}

/// Data of the ticks in the window.
#[derive(Debug)]
struct Shown {
    ticks: Reduced,
    count: u64,
    phase: [Trace; JOINTS],
    path: Trace,
    reference: Trace,
    spectra: Welches,
    timing: Vec<Counts>,
}

impl Default for Shown {
    fn default() -> Self {
        let plane = || Trace::new([ANGLE_CELL; 2]);
        Self {
            ticks: Reduced::default(),
            count: 0,
            phase: [(); JOINTS].map(|()| Trace::new([ANGLE_CELL, SPEED_CELL])),
            path: plane(),
            reference: plane(),
            spectra: Welches::default(),
            timing: QUANTITIES.map(|_| Counts::default()).into(),
        }
    }
}

impl Collector {
    /// Run with these facts, as far as its events do not report other settings. The window is from
    /// `from_s` to `to_s` after time zero, `None` for the ends of the run.
    pub fn new(facts: &RunFacts, window_s: [Option<f64>; 2]) -> Self {
        Self {
            window_s,
            facts: facts.clone(),
            settings: None,
            times: RunTimes::default(),
            last: None,
            tally: Tally::default(),
            shown: Shown::default(),
            marks: Vec::new(),
        }
    }

    /// Adds the next event of the link.
    pub fn event(&mut self, event: &Event) {
        match &event.kind {
            EventKind::Received(_, ToHost::Record(record)) => self.record(record),
            EventKind::Received(_, ToHost::Settings(settings)) if !self.times.is_driven() => {
                self.facts = self.facts.with_settings(settings);
                self.settings = Some(*settings);
            }
            EventKind::Sent(_, ToBoard::Command(command)) => self.command(command),
            EventKind::Sent(..)
            | EventKind::Received(..)
            | EventKind::Lost(..)
            | EventKind::Damaged(..)
            | EventKind::Disconnected => {}
        }
    }

    /// Adds a command as a mark, unless the curves show it.
    fn command(&mut self, command: &Command) {
        let text = match command {
            Command::Arm { .. } | Command::Idle | Command::Release | Command::ClearFault => {
                enum_names::command(command)
            }
            Command::Follow(_) => "motion",
            Command::Experiment(_) => "experiment",
            Command::Torque(_) => "torque",
            Command::Configure(_) | Command::Limit(_) => "settings",
            // Setpoints are steps of the reference; a stream has hundreds of points.
            Command::Regulate(_) | Command::Stream { .. } | Command::Prepare | Command::Save => {
                return;
            }
        };
        let time_s = self.times.now_s();
        let repeats = |last: &Mark| last.text == text && time_s - last.time_s < 0.5;
        if self.marks.len() < MARKS_MAX && !self.marks.last().is_some_and(repeats) {
            self.marks.push(Mark::command(time_s, text));
        }
    }

    /// Adds a push on the simulated arm that begins, on the board's clock.
    pub fn push(&mut self, push: &Push) {
        self.tally.push(push);
        if self.marks.len() < MARKS_MAX {
            let time_s = self.times.at_us(push.start_ns / 1_000);
            self.marks.push(Mark::push(time_s, push));
        }
    }

    /// Adds the next tick.
    pub fn record(&mut self, record: &Record) {
        let was_begun = self.times.origin_s().is_some();
        let time_s = self.times.add(record);
        let origin_s = self.times.origin_s();
        if !was_begun && origin_s.is_some() {
            self.begin(time_s);
        }
        self.tally.add(record);
        let follows = self.last.is_some_and(|last| follows(&last, record));
        let [from_s, to_s] = self.window_s;
        // Whether a tick before time zero is in the window is known at time zero.
        let is_in_window = origin_s.is_none_or(|origin_s| {
            let since_s = time_s - origin_s;
            from_s.is_none_or(|from_s| since_s >= from_s) && to_s.is_none_or(|to_s| since_s <= to_s)
        });
        if is_in_window {
            let before = self.last.filter(|_| follows);
            self.shown.add(record, before.as_ref(), time_s, &self.facts);
        }
        self.last = Some(*record);
    }

    /// Takes this time as time zero: what came before is shown only where that is requested.
    fn begin(&mut self, time_s: f64) {
        self.tally = Tally::default();
        match self.window_s[0].filter(|from_s| *from_s < 0.0) {
            Some(from_s) => self.shown.ticks.begin_at(time_s + from_s),
            None => self.shown = Shown::default(),
        }
    }

    /// The run.
    pub fn finish(self) -> Run {
        let facts = self.facts;
        let period_s = f64::from(facts.period_us) * 1e-6;
        let origin_s = self.times.origin_s().unwrap_or(0.0);
        let since = |time_s: f64| time_s - origin_s;
        let mut ticks = self.shown.ticks.into_ticks();
        for tick in &mut ticks {
            tick.time_s = since(tick.time_s);
        }
        let [from_s, to_s] = self.window_s;
        let from_s = from_s.unwrap_or(0.0);
        let end_s = ticks.last().map_or(1.0, |last| last.time_s + period_s);
        let mut marks = self.marks;
        for mark in &mut marks {
            mark.time_s = since(mark.time_s);
        }
        marks.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        let covered_s = self.last.map(|_| [since(0.0), since(self.times.now_s())]);
        let intervals = self.tally.summary(&facts, LinkStats::default(), 0.0, 0.0);
        let rate_hz = 1.0 / period_s;
        Run {
            settings: self.settings.unwrap_or_else(|| Settings {
                setup: facts.setup,
                ..Settings::default()
            }),
            path: std::path::PathBuf::new(),
            damage: Vec::new(),
            covered_s,
            times: self.times,
            origin_s,
            ticks,
            // A window must have some width to be drawn.
            window: [from_s, to_s.unwrap_or(end_s).max(from_s + period_s)],
            intervals: intervals.segments,
            phase: self.shown.phase.map(Trace::into_pieces),
            path_curve: self.shown.path.into_pieces(),
            reference_curve: self.shown.reference.into_pieces(),
            spectra: self.shown.spectra.finish(rate_hz),
            timing: self.shown.timing,
            shown: self.shown.count,
            marks,
            behind: None,
            facts,
        }
    }
}

impl Shown {
    /// Adds a tick; `before` is the previous one, unless ticks are missing between them.
    fn add(&mut self, record: &Record, before: Option<&Record>, time_s: f64, facts: &RunFacts) {
        self.count += 1;
        self.ticks.add(Tick {
            time_s,
            follows: before.is_some() || self.count == 1,
            record: *record,
        });
        let is_up = enum_names::is_up(record.mode);
        let gap = (f64::NAN, f64::NAN);
        let [q1, q2] = record.angle_rad.map(f64::from);
        for (joint, trace) in self.phase.iter_mut().enumerate() {
            if before.is_none() {
                trace.add(gap);
            }
            let [q, dq] = [record.angle_rad, record.speed_rad_s].map(|pair| f64::from(pair[joint]));
            trace.add(if is_up { (q, dq) } else { gap });
        }
        if before.is_none() {
            self.path.add(gap);
            self.reference.add(gap);
        }
        self.path.add(if is_up { (q1, q2) } else { gap });
        self.reference
            .add((reference(record, 0), reference(record, 1)));
        self.spectra.add(before, record, facts);
        for (counts, quantity) in self.timing.iter_mut().zip(&QUANTITIES) {
            if let Some(value) = (quantity.of)(record) {
                counts.add(value);
            }
        }
    }
}

/// Whether two records are those of consecutive ticks.
fn follows(before: &Record, after: &Record) -> bool {
    after.tick == before.tick.wrapping_add(1)
}
