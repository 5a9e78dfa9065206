//! What a log holds, in numbers and words: [`Info`] is one JSON object with units
//! in its keys, and [`Info::table`] is the same for a terminal.

mod count;
mod table;

use std::collections::BTreeMap;
use std::path::Path;

use armbridge_client::enum_names;
use armbridge_client::fault_text;
use armbridge_shared::link::message::{Settings, Trip};
use serde::Serialize;

use super::diff::in_words;
use super::log::{Head, Order, topics};
use super::settings::{Differing, differing};
use crate::clock_sync::Line;
use crate::recording::ReadError;
use crate::run_info::RunFacts;
use crate::summary::Cause;
use count::Count;

/// What a log holds.
#[derive(Clone, Debug, Serialize)]
pub struct Info {
    /// The log.
    pub path: String,
    /// Of the file.
    pub size_bytes: u64,
    /// What is missing of the file, each in one sentence; empty for an intact one.
    pub damage: Vec<String>,
    /// As told when the run began.
    pub run: RunFacts,
    /// Whatever else the log says of itself, by group and name.
    pub metadata: BTreeMap<String, BTreeMap<String, String>>,
    /// Ticks of which there are records.
    pub ticks: u64,
    /// Number of the first and of the last.
    pub first_and_last_tick: Option<[u32; 2]>,
    /// From the first to the last, by the board's clock.
    pub duration_s: f64,
    /// How long it was in each mode.
    pub modes_s: BTreeMap<&'static str, f64>,
    /// Ticks of which there is no record.
    pub missing_ticks: u64,
    /// Where they are; the first of them.
    pub gaps: Vec<Gap>,
    /// How many gaps there are in all.
    pub gap_count: usize,
    /// Ticks that the board skipped, being late.
    pub skipped_ticks: u32,
    /// Samples that are missing, by kind, since the servos were found.
    pub missing_samples: BTreeMap<&'static str, u64>,
    /// Each fault.
    pub faults: Vec<FaultInfo>,
    /// Times, in s after the first tick, at which the board began anew.
    pub resets_s: Vec<f64>,
    /// How often the connection broke.
    pub partings: u64,
    /// Frames that could not be read, in either direction.
    pub garbled_frames: u64,
    /// Frames that never came, in either direction.
    pub lost_frames: u64,
    /// What the host ordered, by name: how often, and how often it was refused.
    pub commands: BTreeMap<&'static str, [u64; 2]>,
    /// The first orders, in words.
    pub first_commands: Vec<CommandInfo>,
    /// Settings that are not the defaults; none if the board has not told them.
    pub settings: Option<Vec<Differing>>,
    /// Both clocks; none if there are too few ticks to tell.
    pub clocks: Option<Clocks>,
    /// What was said, by kind.
    pub messages: BTreeMap<&'static str, u64>,
    /// The file's topics, by the index at its end; empty if it has none.
    pub topics: BTreeMap<String, u64>,
}

/// Both clocks, since the board began last; see [`Line`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Clocks {
    /// Host's time less the board's, with the shortest way of a record in it.
    pub offset_s: f64,
    /// At this time of the board.
    pub at_board_s: f64,
    /// What the host's clock gains.
    pub drift_ppm: f64,
    /// How much later the fastest records of the seconds came, at the median.
    pub residual_us: f64,
    /// The same, at worst.
    pub residual_most_us: f64,
}

/// Ticks without a record.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Gap {
    /// The last tick before.
    pub after_tick: u32,
    /// When that was, in s after the first tick.
    pub after_s: f64,
    /// How many.
    pub ticks: u32,
    /// How many of them the board dropped, because nobody fetched them; the others
    /// were lost on the link or in the log.
    pub dropped: u32,
}

/// A fault.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FaultInfo {
    /// When it began, in s after the first tick.
    pub at_s: f64,
    /// In this tick.
    pub tick: u32,
    /// Its name.
    pub fault: &'static str,
    /// What tripped it, if the board told.
    pub cause: Option<Cause>,
    /// The same in words.
    pub in_words: Option<String>,
}

/// A command.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CommandInfo {
    /// The last tick before it; none before the first.
    pub after_tick: Option<u32>,
    /// In words.
    pub command: String,
    /// Why it was refused, if it was.
    pub refused: Option<String>,
}

/// Orders and gaps that are told one by one.
const TOLD: usize = 20;

impl Info {
    /// Reads a log as far as it goes.
    ///
    /// # Errors
    /// When there is nothing that can be read.
    pub fn read(path: &Path) -> Result<Self, ReadError> {
        let mut count = Count::default();
        let head = Head::read(path, |event| count.take(event))?;
        let size_bytes = path.metadata().map_or(0, |file| file.len());
        Ok(Self::of(head, count, size_bytes, topics(path)))
    }

    fn of(head: Head, mut count: Count, size_bytes: u64, topics: BTreeMap<String, u64>) -> Self {
        let orders = std::mem::take(&mut count.orders).into_all();
        let mut commands: BTreeMap<&'static str, [u64; 2]> = BTreeMap::new();
        for order in &orders {
            let [given, refused] = commands
                .entry(enum_names::command(&order.command))
                .or_default();
            *given += 1;
            *refused += u64::from(matches!(order.result, Some(Err(_))));
        }
        let default = Settings::default();
        let settings = head.settings.as_ref();
        Self {
            path: head.path.display().to_string(),
            size_bytes,
            settings: settings.map(|settings| differing(&default, settings)),
            damage: head.damage,
            run: head.facts,
            metadata: head.metadata,
            ticks: count.ticks,
            first_and_last_tick: count.first.zip(count.last).map(|(a, b)| [a.tick, b.tick]),
            duration_s: count.duration_s(),
            modes_s: count.modes(),
            missing_ticks: count.missing_ticks,
            gap_count: count.gaps_in_all,
            skipped_ticks: count.skipped,
            faults: with_causes(count.faults, &count.trips),
            gaps: count.gaps,
            missing_samples: count.missing_samples,
            resets_s: count.resets_s,
            partings: count.partings,
            garbled_frames: count.garbled,
            lost_frames: count.lost,
            commands,
            first_commands: orders.iter().take(TOLD).map(command).collect(),
            clocks: count.clocks.line().as_ref().map(clocks),
            messages: count.messages,
            topics,
        }
    }
}

fn clocks(line: &Line) -> Clocks {
    Clocks {
        offset_s: line.offset_ns as f64 * 1e-9,
        at_board_s: line.at_board_us as f64 * 1e-6,
        drift_ppm: line.drift_ppm,
        residual_us: line.residual_us,
        residual_most_us: line.residual_most_us,
    }
}

fn command(order: &Order) -> CommandInfo {
    CommandInfo {
        after_tick: order.tick,
        command: in_words(&order.command),
        refused: match order.result {
            Some(Err(refusal)) => Some(armbridge_client::refusal_text::in_words(refusal)),
            Some(Ok(())) | None => None,
        },
    }
}

/// What tripped the board, on one line.
fn seen(trip: &Trip) -> String {
    let account = fault_text::in_words(trip);
    match account.seen {
        Some(seen) => format!("{}, {seen}", account.cause),
        None => account.cause,
    }
}

/// A trip is told again after a hello; its tick says which fault it belongs to.
fn with_causes(mut faults: Vec<FaultInfo>, trips: &[Trip]) -> Vec<FaultInfo> {
    for fault in &mut faults {
        let of_fault = |trip: &&Trip| enum_names::fault(trip.fault) == fault.fault;
        let distance = |trip: &&Trip| trip.tick.abs_diff(fault.tick);
        let trip = trips.iter().filter(of_fault).min_by_key(distance);
        fault.in_words = trip.map(seen);
        fault.cause = trip.map(|trip| Cause {
            tick: trip.tick,
            joint: trip.joint.map(|joint| joint + 1),
            value: trip.value,
            limit: trip.limit,
        });
    }
    faults
}
