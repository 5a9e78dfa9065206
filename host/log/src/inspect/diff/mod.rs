//! Differences of two runs: settings, commands, and the outputs, tick by tick.
//!
//! Runs are aligned where the arm is first driven: that is tick
//! 0, and only common ticks are compared, up to a reset of the board.
//! Inputs and outputs of the board are compared to the bit. Times and counters are
//! not: they differ between any two runs.

mod table;

use armbridge_client::enum_names;
use armbridge_shared::link::message::{Command, Record};
use serde::Serialize;

use super::log::{Log, SentCommand};
use super::settings::{Differing, differing};
use crate::export::column::{QUANTITIES, Quantity, Values};

/// Differences of two runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Diff {
    /// The logs.
    pub logs: [String; 2],
    /// Settings that differ; none if a log has none.
    pub settings: Option<Vec<Differing>>,
    /// Number of commands of each.
    pub commands: [usize; 2],
    /// The first that differs.
    pub first_command: Option<CommandDiff>,
    /// Common ticks since the arm was first driven.
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
    /// The command of each run.
    pub commands: [Option<String>; 2],
}

/// The first tick that differs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TickDiff {
    /// Ticks since the arm was first driven.
    pub since_drive: u32,
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

impl Diff {
    /// Compares two runs.
    pub fn compare(a: &Log, b: &Log) -> Self {
        let pairs = pairs(a, b);
        let driven = [a, b].map(|log| driven(log).len());
        let mut sums: Vec<Sum> = columns().map(Sum::new).collect();
        let mut first_tick = None;
        for [left, right] in &pairs {
            let mut columns = Vec::new();
            for sum in &mut sums {
                if sum.add(left, right) {
                    columns.push(sum.column);
                }
            }
            if first_tick.is_none() && !columns.is_empty() {
                first_tick = Some(TickDiff {
                    since_drive: left.tick.wrapping_sub(pairs[0][0].tick),
                    ticks: [left.tick, right.tick],
                    columns,
                });
            }
        }
        let differing_sums = sums.into_iter().filter(|sum| sum.differing > 0);
        Self {
            logs: [a, b].map(|log| log.head.path.display().to_string()),
            settings: a
                .head
                .settings
                .zip(b.head.settings)
                .map(|(a, b)| differing(&a, &b)),
            commands: [a.commands.len(), b.commands.len()],
            first_command: first_command(&a.commands, &b.commands),
            ticks: pairs.len(),
            unmatched: driven.map(|count| count - pairs.len()),
            first_tick,
            quantities: differing_sums.map(|sum| sum.diff(pairs.len())).collect(),
        }
    }

    /// Whether nothing differs.
    pub fn is_same(&self) -> bool {
        self.settings.as_ref().is_none_or(Vec::is_empty)
            && self.first_command.is_none()
            && self.first_tick.is_none()
            && self.unmatched == [0, 0]
    }
}

/// The ticks since the arm was first driven, up to a reset of the board.
pub fn driven(log: &Log) -> &[Record] {
    let records = &log.records[log.driven_from().unwrap_or(log.records.len())..];
    let reset = records
        .windows(2)
        .position(|two| two[1].tick <= two[0].tick);
    &records[..reset.map_or(records.len(), |last| last + 1)]
}

/// Common ticks.
pub fn pairs<'a>(a: &'a Log, b: &'a Log) -> Vec<[&'a Record; 2]> {
    let (left, right) = (driven(a), driven(b));
    let since = |ticks: &[Record], record: &Record| record.tick - ticks[0].tick;
    let mut others = right.iter().peekable();
    let mut pairs = Vec::with_capacity(left.len().min(right.len()));
    for record in left {
        let at = since(left, record);
        while others.next_if(|other| since(right, other) < at).is_some() {}
        if let Some(other) = others.next_if(|other| since(right, other) == at) {
            pairs.push([record, other]);
        }
    }
    pairs
}

fn first_command(a: &[SentCommand], b: &[SentCommand]) -> Option<CommandDiff> {
    let at = |commands: &[SentCommand], place: usize| commands.get(place).map(|sent| sent.command);
    let mut places = 0..a.len().max(b.len());
    let place = places.find(|place| match (at(a, *place), at(b, *place)) {
        // The session number differs in every run.
        (Some(Command::Arm { .. }), Some(Command::Arm { .. })) => false,
        (a, b) => a != b,
    })?;
    let show = |commands| at(commands, place).map(|command| command_text(&command));
    Some(CommandDiff {
        place: place + 1,
        commands: [show(a), show(b)],
    })
}

/// A command as one line.
pub fn command_text(command: &Command) -> String {
    let pair = |[a, b]: [f32; 2], unit: &str| format!("{a}, {b} {unit}");
    let name = enum_names::command(command);
    match command {
        Command::Torque(torque) => format!("{name} {}", pair(*torque, "N m")),
        Command::Regulate(angle) => format!("{name} {}", pair(*angle, "rad")),
        Command::Stream {
            at_us, angle_rad, ..
        } => format!(
            "{name} {} at {} s",
            pair(*angle_rad, "rad"),
            *at_us as f64 / 1e6
        ),
        Command::Follow(motion) => format!("{name} {motion:?}"),
        Command::Experiment(plan) => format!("{name} {plan:?}"),
        // The contents of these two are compared by name, as settings.
        Command::Idle
        | Command::Arm { .. }
        | Command::Prepare
        | Command::Release
        | Command::ClearFault
        | Command::Save
        | Command::Configure(_)
        | Command::Limit(_) => name.to_owned(),
    }
}

/// Columns that are compared.
fn columns() -> impl Iterator<Item = (&'static Quantity, usize)> {
    let is_compared = |quantity: &&Quantity| match quantity.values {
        Values::F64(_) | Values::U32(_) => false,
        Values::F32(_) | Values::U16(_) | Values::Sample(_) | Values::Word(..) => true,
    };
    let compared = QUANTITIES.iter().filter(is_compared);
    compared.flat_map(|quantity| (0..quantity.columns.len()).map(move |joint| (quantity, joint)))
}

/// A quantity's differences so far.
struct Sum {
    column: &'static str,
    unit: &'static str,
    values: Values,
    joint: usize,
    max: f64,
    squares: f64,
    differing: usize,
}

impl Sum {
    fn new((quantity, joint): (&'static Quantity, usize)) -> Self {
        Self {
            column: quantity.columns[joint],
            unit: quantity.unit,
            values: quantity.values,
            joint,
            max: 0.0,
            squares: 0.0,
            differing: 0,
        }
    }

    /// Adds a tick; returns whether it differs.
    fn add(&mut self, a: &Record, b: &Record) -> bool {
        let joint = self.joint;
        let (is_same, difference) = match self.values {
            Values::F32(get) => {
                let (a, b) = (get(a, joint), get(b, joint));
                (a.to_bits() == b.to_bits(), f64::from(b) - f64::from(a))
            }
            Values::U16(get) => {
                let (a, b) = (get(a, joint), get(b, joint));
                (a == b, f64::from(b) - f64::from(a))
            }
            Values::Sample(get) => {
                let (a, b) = (get(a, joint), get(b, joint));
                // A missing sample counts as zero.
                let difference = a.zip(b).map_or(0.0, |(a, b)| f64::from(b) - f64::from(a));
                (a == b, difference)
            }
            Values::Word(_, get) => (get(a, joint) == get(b, joint), 0.0),
            Values::F64(_) | Values::U32(_) => (true, 0.0),
        };
        if !is_same {
            self.differing += 1;
            self.max = self.max.max(difference.abs());
            self.squares += difference * difference;
        }
        !is_same
    }

    fn diff(&self, ticks: usize) -> QuantityDiff {
        let is_word = matches!(self.values, Values::Word(..));
        QuantityDiff {
            column: self.column,
            unit: self.unit,
            max: (!is_word).then_some(self.max),
            rms: (!is_word).then(|| (self.squares / ticks as f64).sqrt()),
            ticks: self.differing,
        }
    }
}
