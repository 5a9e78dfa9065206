//! A run as its figures show it: ticks with their times, and what is computed from all of them.
//!
//! Time zero is the first armed tick, see [`time_origin`](armbridge_log::time_origin). A
//! [`Collector`] takes a log tick by tick; memory does not grow with its length. The log is read
//! up to time zero before that: what a window contains depends on it.

use std::path::{Path, PathBuf};

use armbridge_client::{enum_names, params};
use armbridge_link::message::{Record, Sample, Settings};
use armbridge_log::recording::{ReadError, Reader};
use armbridge_log::run_info::RunFacts;
use armbridge_log::summary::{Counts, SegmentSummary};
use armbridge_log::time_origin::{Align, RunTimes};
use armbridge_servo::JOINTS;

use super::axis::Axis;
use super::collector::Collector;
use super::labels;
use super::marks::Mark;
use super::reduce::Tick;
use super::welch::Spectrum;
use crate::run::{BASELINE_LOG, RUN_LOG};

/// A curve in a plane, in pieces.
pub(super) type Curve = Vec<Vec<(f64, f64)>>;

/// A run as its figures show it.
#[derive(Debug)]
pub struct Run {
    /// Facts, with the settings in force when the motors were first driven.
    pub facts: RunFacts,
    /// These settings.
    pub settings: Settings,
    /// Log that it was read from; empty for a run in memory.
    pub path: PathBuf,
    /// Damage of the log, each in one sentence.
    pub damage: Vec<String>,
    /// First and last tick of the whole run in s; none without ticks.
    pub covered_s: Option<[f64; 2]>,
    /// Times of its events.
    pub(super) times: RunTimes,
    /// Time zero in s after the first tick.
    pub(super) origin_s: f64,
    /// Ticks in the window that are visible.
    pub(super) ticks: Vec<Tick>,
    /// First and last time shown, in s.
    pub(super) window: [f64; 2],
    /// Setpoints of the whole run, the first of them in a long one.
    pub(super) intervals: Vec<SegmentSummary>,
    /// Speed over angle of each joint.
    pub(super) phase: [Curve; JOINTS],
    /// Angle of joint 2 over that of joint 1: estimate and reference.
    pub(super) path_curve: Curve,
    pub(super) reference_curve: Curve,
    /// Root mean square of estimate minus reference over all ticks in the window, in rad.
    pub(super) error_rms_rad: [f64; JOINTS],
    /// Spectra of [`SIGNALS`](super::spectrum::SIGNALS), of each joint.
    pub(super) spectra: Vec<[Option<Spectrum>; JOINTS]>,
    /// Values of the [`QUANTITIES`](super::timing::QUANTITIES) of all ticks in the window.
    pub(super) timing: Vec<Counts>,
    /// Ticks in the window.
    pub(super) shown: u64,
    /// Pushes and commands.
    pub(super) marks: Vec<Mark>,
    /// Run that `angles` shows in grey behind this one.
    pub(super) behind: Option<Box<Self>>,
}

impl Run {
    /// Reads a log, tick by tick, with a window from `from_s` to `to_s`; `None` for the ends of
    /// the run. The baseline beside the log of a run is read as well.
    ///
    /// # Errors
    /// When nothing can be read.
    pub fn read_with_baseline(path: &Path, window_s: [Option<f64>; 2]) -> Result<Self, ReadError> {
        let run = Self::read(path, window_s)?;
        let baseline = run.path.with_file_name(BASELINE_LOG);
        let is_run = run.path.file_name().is_some_and(|name| name == RUN_LOG);
        let behind = (is_run && baseline.is_file()).then(|| Self::read(&baseline, window_s));
        Ok(Self {
            behind: behind.transpose()?.map(Box::new),
            ..run
        })
    }

    /// Reads a log, tick by tick, with a window from `from_s` to `to_s`; `None` for the ends of
    /// the run.
    ///
    /// # Errors
    /// When nothing can be read.
    pub fn read(path: &Path, window_s: [Option<f64>; 2]) -> Result<Self, ReadError> {
        let origin_s = origin_s(Reader::open(path)?.filter_map(|event| event.record()));
        let mut reader = Reader::open(path)?;
        let mut collector = Collector::new(reader.facts(), origin_s, window_s);
        while let Some(event) = reader.next() {
            match event.record() {
                Some(record) => collector.record(&record, reader.pushes_begun(&record)),
                None => collector.event(&event),
            }
        }
        Ok(Self {
            path: reader.path().to_path_buf(),
            damage: reader.damage().to_vec(),
            ..collector.finish()
        })
    }

    /// Run of these records.
    pub fn of_records(facts: &RunFacts, records: &[Record]) -> Self {
        let origin_s = origin_s(records.iter().copied());
        let mut collector = Collector::new(facts, origin_s, [None; 2]);
        for record in records {
            collector.record(record, &[]);
        }
        collector.finish()
    }

    /// Name of its control: that of a whole set-up, or the controller.
    pub(super) fn control(&self) -> String {
        labels::control(&self.settings).map_or_else(
            || {
                let kind = params::get(&self.settings, "controller.kind");
                kind.map_or_else(String::new, |kind| params::to_text(&kind))
            },
            str::to_owned,
        )
    }

    /// Time of an event in s after time zero; none if it did not occur.
    pub fn time_of(&self, event: Align) -> Option<f64> {
        let event_s = self.times.event_s(event);
        event_s.map(|event_s| event_s - self.origin_s)
    }

    /// The run with its time zero at `zero_s`.
    #[must_use]
    pub fn shifted(mut self, zero_s: f64) -> Self {
        for tick in &mut self.ticks {
            tick.time_s -= zero_s;
        }
        for mark in &mut self.marks {
            mark.time_s -= zero_s;
        }
        for interval in &mut self.intervals {
            interval.start_s -= zero_s;
            interval.end_s -= zero_s;
        }
        self.window = self.window.map(|end_s| end_s - zero_s);
        self.covered_s = self.covered_s.map(|ends| ends.map(|end_s| end_s - zero_s));
        self.origin_s += zero_s;
        self
    }

    /// Period of the ticks in s, by the settings in force.
    pub(super) fn period_s(&self) -> f64 {
        f64::from(self.facts.period_us) * 1e-6
    }

    /// The time axis.
    pub(super) fn time_axis(&self) -> Axis {
        let [low, high] = self.window;
        Axis::linear(low, high)
    }

    /// Records of the visible ticks.
    pub(super) fn records(&self) -> impl Iterator<Item = &Record> {
        self.ticks.iter().map(|tick| &tick.record)
    }

    /// A quantity over time in s, with NaN where ticks are missing.
    pub(super) fn over_time(
        &self,
        quantity: impl Fn(&Record) -> f64,
    ) -> impl Iterator<Item = (f64, f64)> {
        self.ticks.iter().flat_map(move |tick| {
            let gap = (!tick.follows).then_some((tick.time_s, f64::NAN));
            gap.into_iter()
                .chain([(tick.time_s, quantity(&tick.record))])
        })
    }

    /// The setpoints that are shown.
    pub(super) fn setpoint_intervals(&self) -> impl Iterator<Item = &SegmentSummary> {
        let [from_s, to_s] = self.window;
        let intervals = self.intervals.iter();
        intervals.filter(move |interval| interval.end_s > from_s && interval.start_s < to_s)
    }

    /// Angle by the encoder in rad; NaN if the sample is missing, or servos have not been found.
    pub(super) fn measured_rad(&self, record: &Record, joint: usize) -> f64 {
        match record.input.samples[joint] {
            Sample::Counts(count) if enum_names::is_up(record.mode) => {
                self.facts.angle_rad(joint, count)
            }
            Sample::Counts(_) | Sample::Missing(_) => f64::NAN,
        }
    }

    /// Value of a quantity at a time in s: that of the latest tick before it.
    pub(super) fn value_at(&self, time_s: f64, quantity: impl Fn(&Record) -> f64) -> f64 {
        let next = self.ticks.partition_point(|tick| tick.time_s <= time_s);
        let tick = next.checked_sub(1).map(|at| &self.ticks[at]);
        tick.map_or(f64::NAN, |tick| quantity(&tick.record))
    }

    /// Whether records are missing in the window.
    pub(super) fn has_gaps(&self) -> bool {
        self.ticks.iter().skip(1).any(|tick| !tick.follows)
    }
}

/// Time zero of a run in s after its first tick.
fn origin_s(records: impl Iterator<Item = Record>) -> f64 {
    let mut times = RunTimes::default();
    let mut origins = records.filter_map(|record| {
        times.add(&record);
        times.origin_s()
    });
    origins.next().unwrap_or(0.0)
}
