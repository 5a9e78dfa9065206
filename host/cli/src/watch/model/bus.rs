//! State of the servo bus: bus time, missing samples, temperatures, and what each
//! tick took.

use std::collections::VecDeque;

use armbridge_client::enum_names;
use armbridge_link::message::{Missing, Record, Timing};
use armbridge_servo::JOINTS;

/// Ticks whose timing is kept.
const TICKS: usize = 10_000;

/// Counts since the dashboard began, and the latest timings.
#[derive(Clone, Debug)]
pub struct Bus {
    /// Missing samples, joint by joint, in the order of [`enum_names::MISSING`].
    missing: [[u64; enum_names::MISSING.len()]; JOINTS],
    missed_before: Option<u32>,
    /// Ticks that the board skipped.
    pub missed_ticks: u64,
    /// Alarms of stock servos, latest.
    pub alarms: [u8; JOINTS],
    timings: VecDeque<Timing>,
}

impl Default for Bus {
    fn default() -> Self {
        Self {
            missing: [[0; enum_names::MISSING.len()]; JOINTS],
            missed_before: None,
            missed_ticks: 0,
            alarms: [0; JOINTS],
            timings: VecDeque::with_capacity(TICKS),
        }
    }
}

impl Bus {
    /// Takes a tick.
    pub fn take(&mut self, record: &Record) {
        for (joint, sample) in record.input.samples.into_iter().enumerate() {
            if let Some(missing) = sample.lost()
                && let Some(kind) = enum_names::MISSING.iter().position(|kind| *kind == missing)
            {
                self.missing[joint][kind] += 1;
            }
        }
        self.alarms = record.input.alarms;
        let missed = record.timing.missed;
        // Ticks missed before the dashboard started do not count; after a
        // reset the board counts from 0.
        let before = self.missed_before.replace(missed).unwrap_or(missed);
        self.missed_ticks += u64::from(missed.checked_sub(before).unwrap_or(missed));
        if self.timings.len() == TICKS {
            self.timings.pop_front();
        }
        self.timings.push_back(record.timing);
    }

    /// Samples of both joints that are missing, kind by kind, those kinds that are.
    pub fn missing(&self) -> Vec<(Missing, u64)> {
        let of_kind = |kind: usize| self.missing.iter().map(|joint| joint[kind]).sum::<u64>();
        let kinds = enum_names::MISSING.into_iter().enumerate();
        kinds
            .map(|(kind, missing)| (missing, of_kind(kind)))
            .filter(|(_, count)| *count > 0)
            .collect()
    }

    /// Timings of the latest ticks, oldest first.
    pub fn timings(&self) -> impl Iterator<Item = &Timing> + Clone {
        self.timings.iter()
    }
}
