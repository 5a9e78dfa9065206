//! Collects a [`Run`] for the figures, event by event, in bounded memory.

use armbridge_client::event::{Event, EventKind};
use armbridge_client::{LinkStats, enum_names};
use armbridge_link::message::{Command, Record, Settings, ToBoard, ToHost};
use armbridge_log::record_values::{error_rad, reference_rad};
use armbridge_log::run_info::RunFacts;
use armbridge_log::simulation::Push;
use armbridge_log::summary::{Counts, Tally};
use armbridge_log::time_origin::RunTimes;
use armbridge_servo::JOINTS;

use super::marks::Mark;
use super::reduce::{Reduced, Tick};
use super::rms::Rms;
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
pub(super) struct Collector {
    /// First and last time that are shown, in s after the first tick; none for the end.
    window_s: (f64, Option<f64>),
    /// Time zero in s after the first tick.
    origin_s: f64,
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
    error: Rms,
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
            error: Rms::default(),
            spectra: Welches::default(),
            timing: QUANTITIES.map(|_| Counts::default()).into(),
        }
    }
}

impl Collector {
    /// Run with these facts, as far as its events do not report other settings. Its time zero is
    /// `origin_s` after its first tick. The window is from `from_s` to `to_s` after time zero,
    /// `None` for time zero and for the end of the run.
    pub(super) fn new(facts: &RunFacts, origin_s: f64, [from_s, to_s]: [Option<f64>; 2]) -> Self {
        Self {
            window_s: (
                origin_s + from_s.unwrap_or(0.0),
                to_s.map(|to_s| origin_s + to_s),
            ),
            origin_s,
            facts: facts.clone(),
            settings: None,
            times: RunTimes::default(),
            last: None,
            tally: Tally::default(),
            shown: Shown::default(),
            marks: Vec::new(),
        }
    }

    /// Adds the next event of the link, which is no record.
    pub(super) fn event(&mut self, event: &Event) {
        match &event.kind {
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
            Command::Arm { .. }
            | Command::Idle
            | Command::Park
            | Command::Release
            | Command::ClearFault => enum_names::command(command),
            Command::Follow(_) => "motion",
            Command::Experiment(_) => "experiment",
            Command::Torque(_) => "torque",
            Command::Float => "float",
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

    /// Adds the next tick, and the pushes on the simulated arm that have begun since the one
    /// before.
    pub(super) fn record(&mut self, record: &Record, begun: &[Push]) {
        let time_s = self.times.add(record);
        for push in begun {
            self.push(push);
        }
        // Statistics begin with the plan.
        if time_s >= self.origin_s {
            self.tally.add(record);
        }
        let before = self.last.replace(*record);
        let (from_s, to_s) = self.window_s;
        if time_s >= from_s && to_s.is_none_or(|to_s| time_s <= to_s) {
            let before = before.filter(|before| follows(before, record));
            self.shown.add(record, before.as_ref(), time_s, &self.facts);
        }
    }

    fn push(&mut self, push: &Push) {
        self.tally.push(push);
        if self.marks.len() < MARKS_MAX {
            let time_s = self.times.at_us(push.start_ns / 1_000);
            self.marks.push(Mark::push(time_s, push));
        }
    }

    /// The run.
    pub(super) fn finish(self) -> Run {
        let facts = self.facts;
        let period_s = f64::from(facts.period_us) * 1e-6;
        let origin_s = self.origin_s;
        let since = |time_s: f64| time_s - origin_s;
        let mut ticks = self.shown.ticks.into_ticks();
        for tick in &mut ticks {
            tick.time_s = since(tick.time_s);
        }
        let from_s = since(self.window_s.0);
        let to_s = self.window_s.1.map(since);
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
            error_rms_rad: self.shown.error.values(),
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
        let [q1, q2] = record.output.angle_rad.map(f64::from);
        for (joint, trace) in self.phase.iter_mut().enumerate() {
            if before.is_none() {
                trace.add(gap);
            }
            let [q, dq] = [record.output.angle_rad, record.output.speed_rad_s]
                .map(|pair| f64::from(pair[joint]));
            trace.add(if is_up { (q, dq) } else { gap });
        }
        if before.is_none() {
            self.path.add(gap);
            self.reference.add(gap);
        }
        self.path.add(if is_up { (q1, q2) } else { gap });
        self.reference
            .add((reference_rad(record, 0), reference_rad(record, 1)));
        self.error.add([0, 1].map(|joint| error_rad(record, joint)));
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
