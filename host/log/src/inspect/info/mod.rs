//! Contents of a log as statistics and text: [`Info`] is one JSON object with units
//! in its keys, and [`Info::table`] is the same for a terminal. Times count from the first armed
//! tick, see [`time_origin`](crate::time_origin).

mod count;
mod table;

use std::collections::BTreeMap;
use std::path::Path;

use armbridge_client::{enum_names, fault_text};
use armbridge_link::message::{Settings, Trip};
use serde::Serialize;

use super::diff::command_text;
use super::log::{Head, SentCommand, topics};
use super::settings::{Differing, differing};
use crate::clock_sync::Line;
use crate::recording::ReadError;
use crate::run_info::RunFacts;
use crate::summary::Cause;
use count::EventCounts;

/// Contents of a log.
#[derive(Clone, Debug, Serialize)]
pub struct Info {
    /// Path of the log.
    pub path: String,
    /// Size of the file.
    pub size_bytes: u64,
    /// Damage of the file, each in one sentence; empty for an intact one.
    pub damage: Vec<String>,
    /// Facts of the run, with the settings in force when the motors were first driven.
    pub run: RunFacts,
    /// Other metadata, by group and name.
    pub metadata: BTreeMap<String, BTreeMap<String, String>>,
    /// Ticks with a record.
    pub ticks: u64,
    /// Numbers of the first and the last tick.
    pub first_and_last_tick: Option<[u32; 2]>,
    /// From the first to the last, by the board's clock.
    pub duration_s: f64,
    /// Time in each mode.
    pub modes_s: BTreeMap<&'static str, f64>,
    /// Ticks without a record.
    pub missing_ticks: u64,
    /// The first gaps.
    pub gaps: Vec<Gap>,
    /// Number of all gaps.
    pub gap_count: usize,
    /// Ticks that the board skipped, being late.
    pub skipped_ticks: u32,
    /// Samples that are missing, by kind, since the servos were found.
    pub missing_samples: BTreeMap<&'static str, u64>,
    /// Each fault.
    pub faults: Vec<FaultInfo>,
    /// Times in s at which the board restarted.
    pub resets_s: Vec<f64>,
    /// Number of disconnections.
    pub partings: u64,
    /// Frames that cannot be decoded, in either direction.
    pub garbled_frames: u64,
    /// Lost frames, in either direction.
    pub lost_frames: u64,
    /// Commands of the host, by name: sent and refused.
    pub commands: BTreeMap<&'static str, [u64; 2]>,
    /// The first commands, as text.
    pub first_commands: Vec<CommandInfo>,
    /// Settings that are not the defaults; none if the log has none.
    pub settings: Option<Vec<Differing>>,
    /// Relation of the clocks; none if there are too few ticks.
    pub clocks: Option<Clocks>,
    /// Messages by kind.
    pub messages: BTreeMap<&'static str, u64>,
    /// The file's topics, by the index at its end; empty if it has none.
    pub topics: BTreeMap<String, u64>,
}

/// Relation of the clocks since the board's last restart; see [`Line`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Clocks {
    /// Host's time minus the board's, including the shortest delay of a record.
    pub offset_s: f64,
    /// At this time of the board.
    pub at_board_s: f64,
    /// Drift of the host's clock.
    pub drift_ppm: f64,
    /// Additional delay of the fastest record of a second, at the median.
    pub residual_us: f64,
    /// The same, at worst.
    pub residual_most_us: f64,
}

/// Ticks without a record.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Gap {
    /// The last tick before.
    pub after_tick: u32,
    /// Its time in s.
    pub after_s: f64,
    /// Number of ticks.
    pub ticks: u32,
    /// Those that the board dropped, because the host did not fetch them; the others
    /// were lost on the link or in the log.
    pub dropped: u32,
}

/// A fault.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FaultInfo {
    /// Its time in s.
    pub at_s: f64,
    /// Its tick.
    pub tick: u32,
    /// Its name.
    pub fault: &'static str,
    /// Its cause, if the board reported it.
    pub cause: Option<Cause>,
    /// The same in words.
    pub in_words: Option<String>,
}

/// A command.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CommandInfo {
    /// The last tick before it; none before the first.
    pub after_tick: Option<u32>,
    /// The command, as text.
    pub command: String,
    /// Reason for its refusal, if it was refused.
    pub refused: Option<String>,
}

/// Limit of the lists of commands and of gaps.
const LISTED_MAX: usize = 20;

impl Info {
    /// Reads a log up to its first damage.
    ///
    /// # Errors
    /// When nothing can be read.
    pub fn read(path: &Path) -> Result<Self, ReadError> {
        let mut count = EventCounts::default();
        let head = Head::read(path, |event| count.add(event))?;
        let size_bytes = path.metadata().map_or(0, |file| file.len());
        Ok(Self::new(head, count, size_bytes, topics(path)))
    }

    fn new(
        head: Head,
        mut count: EventCounts,
        size_bytes: u64,
        topics: BTreeMap<String, u64>,
    ) -> Self {
        count.count_from_origin();
        let sent_commands = std::mem::take(&mut count.commands).into_commands();
        let mut commands: BTreeMap<&'static str, [u64; 2]> = BTreeMap::new();
        for sent in &sent_commands {
            let [given, refused] = commands
                .entry(enum_names::command(&sent.command))
                .or_default();
            *given += 1;
            *refused += u64::from(matches!(sent.result, Some(Err(_))));
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
            gap_count: count.gap_count,
            skipped_ticks: count.skipped,
            faults: with_causes(count.faults, &count.trips),
            gaps: count.gaps,
            missing_samples: count.missing_samples,
            resets_s: count.resets_s,
            partings: count.partings,
            garbled_frames: count.garbled,
            lost_frames: count.lost,
            commands,
            first_commands: sent_commands.iter().take(LISTED_MAX).map(command).collect(),
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

fn command(sent: &SentCommand) -> CommandInfo {
    CommandInfo {
        after_tick: sent.tick,
        command: command_text(&sent.command),
        refused: match sent.result {
            Some(Err(refusal)) => Some(armbridge_client::refusal_text::in_words(refusal)),
            Some(Ok(())) | None => None,
        },
    }
}

/// Cause of a fault, on one line.
fn cause_text(trip: &Trip) -> String {
    let description = fault_text::in_words(trip);
    match description.measured {
        Some(measured) => format!("{}, {measured}", description.cause),
        None => description.cause,
    }
}

/// A trip is repeated after a hello; its tick identifies the fault.
fn with_causes(mut faults: Vec<FaultInfo>, trips: &[Trip]) -> Vec<FaultInfo> {
    let key = |trip: &Trip| (trip.fault.name(), trip.tick);
    let mut ordered: Vec<&Trip> = trips.iter().collect();
    ordered.sort_by_key(|trip| key(trip));
    for fault in &mut faults {
        // The nearest is just before it or just after it.
        let next = ordered.partition_point(|trip| key(trip) < (fault.fault, fault.tick));
        let near = next.saturating_sub(1)..ordered.len().min(next + 1);
        let trip = ordered[near]
            .iter()
            .filter(|trip| trip.fault.name() == fault.fault)
            .min_by_key(|trip| trip.tick.abs_diff(fault.tick));
        fault.in_words = trip.map(|trip| cause_text(trip));
        fault.cause = trip.map(|trip| Cause::from(*trip));
    }
    faults
}
