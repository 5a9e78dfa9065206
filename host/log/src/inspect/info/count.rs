//! Counts over a log's events, in one pass.

use std::collections::BTreeMap;

use armbridge_client::enum_names;
use armbridge_client::event::{Event, EventKind};
use armbridge_link::message::{Mode, Record, ToBoard, ToHost, Trip};

use super::{FaultInfo, Gap, LISTED_MAX};
use crate::clock_sync::Envelope;
use crate::inspect::log::CommandCollector;
use crate::time_origin::TimeOrigin;

/// Counts so far.
#[derive(Debug, Default)]
pub(super) struct EventCounts {
    pub(super) commands: CommandCollector,
    pub(super) clocks: Envelope,
    pub(super) ticks: u64,
    pub(super) first: Option<Record>,
    pub(super) last: Option<Record>,
    pub(super) missing_ticks: u64,
    pub(super) gaps: Vec<Gap>,
    pub(super) gap_count: usize,
    pub(super) skipped: u32,
    pub(super) missing_samples: BTreeMap<&'static str, u64>,
    pub(super) faults: Vec<FaultInfo>,
    pub(super) trips: Vec<Trip>,
    pub(super) resets_s: Vec<f64>,
    /// Time zero in s after the first tick.
    origin_s: f64,
    origin: TimeOrigin,
    pub(super) partings: u64,
    pub(super) garbled: u64,
    pub(super) lost: u64,
    pub(super) messages: BTreeMap<&'static str, u64>,
    /// Board's time in each mode, in µs.
    modes_us: BTreeMap<&'static str, u64>,
    /// Board's time between the ticks before the last reset.
    earlier_us: u64,
}

impl EventCounts {
    /// Processes an event.
    pub(super) fn add(&mut self, event: &Event) {
        self.commands.take(event);
        *self.messages.entry(kind(&event.kind)).or_default() += 1;
        match event.kind {
            EventKind::Received(_, ToHost::Record(record)) => self.record(event.host_ns, record),
            EventKind::Received(_, ToHost::Tripped(trip)) => self.trips.push(trip),
            EventKind::Lost(_, frames) => self.lost += u64::from(frames),
            EventKind::Damaged(..) => self.garbled += 1,
            EventKind::Disconnected => self.partings += 1,
            EventKind::Sent(..) | EventKind::Received(..) => {}
        }
    }

    /// From the first tick to the last, over resets.
    pub(super) fn duration_s(&self) -> f64 {
        let since_us = self.first.zip(self.last).map_or(0, |(first, last)| {
            last.input.start_us.saturating_sub(first.input.start_us)
        });
        self.earlier_us.saturating_add(since_us) as f64 * 1e-6
    }

    /// Changes all times from those after the first tick to those after time zero.
    pub(super) fn count_from_origin(&mut self) {
        let faults = self.faults.iter_mut().map(|fault| &mut fault.at_s);
        let gaps = self.gaps.iter_mut().map(|gap| &mut gap.after_s);
        for time_s in faults.chain(gaps).chain(&mut self.resets_s) {
            *time_s -= self.origin_s;
        }
    }

    /// Seconds in each mode.
    pub(super) fn modes(&self) -> BTreeMap<&'static str, f64> {
        let modes = self.modes_us.iter();
        modes.map(|(mode, us)| (*mode, *us as f64 * 1e-6)).collect()
    }

    fn record(&mut self, host_ns: u64, record: Record) {
        self.ticks += 1;
        match self.last {
            Some(last)
                if record.tick <= last.tick && record.input.start_us < last.input.start_us =>
            {
                self.earlier_us = (self.duration_s() * 1e6) as u64;
                self.resets_s.push(self.duration_s());
                self.first = Some(record);
                self.clocks = Envelope::default();
            }
            Some(last) => self.add_interval(&last, &record),
            None => self.first = Some(record),
        }
        self.clocks.add(host_ns, record.input.start_us);
        if enum_names::is_up(record.mode) {
            for sample in record.input.samples {
                if let Some(kind) = sample.lost() {
                    *self
                        .missing_samples
                        .entry(enum_names::missing(kind))
                        .or_default() += 1;
                }
            }
        }
        let before = self.last.and_then(|last| enum_names::fault_of(last.mode));
        self.last = Some(record);
        if self.origin.is_at(record.mode) {
            self.origin_s = self.duration_s();
        }
        if let Mode::Fault(fault) = record.mode
            && before != Some(fault)
        {
            self.faults.push(FaultInfo {
                at_s: self.duration_s(),
                tick: record.tick,
                fault: fault.name(),
                cause: None,
                in_words: None,
            });
        }
    }

    fn add_interval(&mut self, last: &Record, record: &Record) {
        let us = record.input.start_us.saturating_sub(last.input.start_us);
        let mode_us = self
            .modes_us
            .entry(enum_names::mode(last.mode))
            .or_default();
        // Numbers of a damaged log are any.
        *mode_us = mode_us.saturating_add(us);
        let skipped = record.timing.missed.saturating_sub(last.timing.missed);
        self.skipped = self.skipped.saturating_add(skipped);
        let missing = record.tick.saturating_sub(last.tick).saturating_sub(1);
        if missing > 0 {
            self.missing_ticks += u64::from(missing);
            self.gap_count += 1;
            if self.gaps.len() < LISTED_MAX {
                self.gaps.push(Gap {
                    after_tick: last.tick,
                    after_s: self.duration_s(),
                    ticks: missing,
                    dropped: record.dropped.saturating_sub(last.dropped).min(missing),
                });
            }
        }
    }
}

/// Name of a message.
fn kind(event: &EventKind) -> &'static str {
    match event {
        EventKind::Sent(_, message) => match message {
            ToBoard::Hello(_) => "host: hello",
            ToBoard::Heartbeat => "host: heartbeat",
            ToBoard::Stop => "host: stop",
            ToBoard::Goodbye => "host: goodbye",
            ToBoard::Command(_) => "host: command",
        },
        EventKind::Received(_, message) => match message {
            ToHost::Hello(_) => "hello",
            ToHost::Ack { .. } => "ack",
            ToHost::Departs { .. } => "departs",
            ToHost::Began(_) => "began",
            ToHost::Settings(_) => "settings",
            ToHost::Absent { .. } => "absent",
            ToHost::Found { .. } => "found",
            ToHost::Mixed(_) => "mixed",
            ToHost::Unprepared { .. } => "unprepared",
            ToHost::Passthrough => "passthrough",
            ToHost::Port(_) => "port",
            ToHost::Board(_) => "board",
            ToHost::Tripped(_) => "tripped",
            ToHost::Off(_) => "off",
            ToHost::Concluded(_) => "concluded",
            ToHost::Temperature { .. } => "temperature",
            ToHost::Record(_) => "record",
        },
        EventKind::Lost(..) => "lost",
        EventKind::Damaged(..) => "garbled",
        EventKind::Disconnected => "parted",
    }
}
