//! Differences of runs: settings, commands, and the outputs at the same times. Each run is
//! compared with the first.
//!
//! Times are aligned at an event, by default where the arm is first driven, and ticks are
//! compared up to a reset of the board; [`mod@pairs`] has which. Inputs and outputs of the board
//! are compared to the bit. Times and counters are not: they differ between any two runs.
//!
//! Each log is read twice, tick by tick: memory does not grow with its length.

mod commands;
mod pairs;
mod quantities;
mod source;
mod table;

use std::path::PathBuf;

use armbridge_client::params;
use armbridge_link::message::Record;
use serde::Serialize;

pub use commands::command_text;
pub use pairs::{Pair, Pairs, pairs};
pub use source::ticks;

use commands::first_command;
use quantities::{Sum, columns};
use source::Source;

use crate::recording::ReadError;
use crate::time_origin::Align;

/// Differences of runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Diff {
    /// The logs.
    pub logs: Vec<String>,
    /// Event at which their times are aligned, in words.
    pub aligned: &'static str,
    /// Settings that differ between any two; none if a log has none.
    pub settings: Option<Vec<SettingDiff>>,
    /// Each further run, compared with the first.
    pub runs: Vec<RunDiff>,
    /// Damage of the logs, each in one sentence.
    #[serde(skip)]
    pub damage: Vec<String>,
}

/// A setting that differs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SettingDiff {
    /// Its name.
    pub key: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Its value in each run; none where it is not in use.
    pub values: Vec<Option<toml::Value>>,
}

/// Differences of a run from the first.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunDiff {
    /// Number of commands of each.
    pub commands: [usize; 2],
    /// The first that differs.
    pub first_command: Option<CommandDiff>,
    /// Period of each in µs.
    pub period_us: [u32; 2],
    /// Ticks at the same times since the event.
    pub ticks: usize,
    /// Ticks since then that only one of them has.
    pub unmatched: [usize; 2],
    /// The first tick that differs.
    pub first_tick: Option<TickDiff>,
    /// Difference of each quantity; equal ones are left out.
    pub quantities: Vec<QuantityDiff>,
}

/// The first command that differs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CommandDiff {
    /// Its place among the commands, from 1.
    pub place: usize,
    /// Settings in which it differs, where it is one that sets them in both runs.
    pub settings: Vec<&'static str>,
    /// The command of each run.
    pub commands: [Option<String>; 2],
}

/// The first tick that differs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TickDiff {
    /// Time in s since the event.
    pub time_s: f64,
    /// Its number in each run.
    pub ticks: [u32; 2],
    /// Columns of an export that differ.
    pub columns: Vec<&'static str>,
}

/// Difference of a quantity.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct QuantityDiff {
    /// Its name, as the column of an export.
    pub column: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Largest absolute difference; none for words.
    pub max: Option<f64>,
    /// Root mean square over all ticks; none for words.
    pub rms: Option<f64>,
    /// Ticks in which it differs.
    pub ticks: usize,
}

/// Failure to compare runs.
#[derive(Debug, thiserror::Error)]
pub enum DiffError {
    /// A log cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A run has no event to be aligned at.
    #[error(
        "in {path} {}, so its time cannot be aligned there; --align start takes the first armed \
         tick", without(*event), path = path.display()
    )]
    NoEvent {
        /// The log.
        path: PathBuf,
        /// The event.
        event: Align,
    },
}

/// Why a run has no such event.
fn without(event: Align) -> &'static str {
    match event {
        Align::Drive => "the arm is never driven",
        Align::Setpoint => "the reference never changes",
        Align::Start => "there is no tick",
    }
}

impl Diff {
    /// Compares logs, each with the first.
    ///
    /// # Errors
    /// When a log cannot be read, or has no such event.
    pub fn read(paths: &[PathBuf], event: Align) -> Result<Self, DiffError> {
        let sources: Result<Vec<_>, _> =
            paths.iter().map(|path| Source::read(path, event)).collect();
        let sources = sources?;
        let mut runs = Vec::new();
        if let [first, others @ ..] = sources.as_slice() {
            for other in others {
                runs.push(RunDiff::new(first, other)?);
            }
        }
        let damage = sources.iter().flat_map(|source| {
            let path = source.head.path.display();
            let damage = source.head.damage.iter();
            damage.map(move |damage| format!("{path}: {damage}"))
        });
        Ok(Self {
            logs: sources
                .iter()
                .map(|source| source.head.path.display().to_string())
                .collect(),
            aligned: match event {
                Align::Drive => "the arm is first driven",
                Align::Setpoint => "the reference first changes",
                Align::Start => "the first armed tick",
            },
            settings: setting_differences(&sources),
            damage: damage.collect(),
            runs,
        })
    }

    /// Whether nothing differs.
    pub fn is_same(&self) -> bool {
        let is_same = |run: &RunDiff| {
            run.first_command.is_none()
                && run.first_tick.is_none()
                && run.unmatched == [0, 0]
                && run.ticks > 0
        };
        self.settings.as_ref().is_none_or(Vec::is_empty) && self.runs.iter().all(is_same)
    }
}

/// Settings that differ between any two; none if a log has none.
fn setting_differences(sources: &[Source]) -> Option<Vec<SettingDiff>> {
    let settings: Option<Vec<_>> = sources.iter().map(Source::settings).collect();
    let settings = settings?;
    let all = params::all().iter().map(|parameter| SettingDiff {
        key: parameter.key,
        unit: parameter.unit,
        values: settings
            .iter()
            .map(|settings| params::get(settings, parameter.key))
            .collect(),
    });
    let differs = |one: &SettingDiff| one.values.windows(2).any(|two| two[0] != two[1]);
    Some(all.filter(differs).collect())
}

impl RunDiff {
    fn new(a: &Source, b: &Source) -> Result<Self, ReadError> {
        let period_us = [a, b].map(Source::period_us);
        let ticks: [Box<dyn Iterator<Item = (f64, Record)>>; 2] =
            [Box::new(a.ticks()?), Box::new(b.ticks()?)];
        let mut pairs = pairs(ticks, period_us.map(|us| f64::from(us) * 1e-6));
        let mut sums: Vec<Sum> = columns().map(Sum::new).collect();
        let (mut ticks, mut first_tick) = (0, None);
        for Pair {
            time_s,
            records: [left, right],
            ..
        } in pairs.by_ref()
        {
            ticks += 1;
            let mut columns = Vec::new();
            for sum in &mut sums {
                if sum.add(&left, &right) {
                    columns.push(sum.column);
                }
            }
            if first_tick.is_none() && !columns.is_empty() {
                first_tick = Some(TickDiff {
                    time_s,
                    ticks: [left.tick, right.tick],
                    columns,
                });
            }
        }
        let differing = sums.into_iter().filter(|sum| sum.differing > 0);
        Ok(Self {
            commands: [a, b].map(|source| source.commands.len()),
            first_command: first_command(&a.commands, &b.commands),
            period_us,
            unmatched: pairs.unmatched(),
            first_tick,
            quantities: differing.map(|sum| sum.diff(ticks)).collect(),
            ticks,
        })
    }
}
