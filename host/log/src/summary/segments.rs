//! Segments of a run between changes of the setpoint.

use std::collections::VecDeque;
use std::ops::Range;

use armbridge_shared::JOINTS;
use armbridge_shared::link::message::{Drive, Record};
use serde::Serialize;

use crate::run_info::RunFacts;

/// A joint has settled when its error stays below this, in rad.
pub const SETTLED_RAD: f64 = 0.020;

/// Time at a segment's end over which its steady-state error is averaged, in s.
pub const STEADY_S: f64 = 0.5;

/// Consecutive ticks that regulate about one reference.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Indices of the records.
    pub ticks: Range<usize>,
    /// Reference in rad.
    pub reference_rad: [f32; JOINTS],
}

/// Splits a run at each change of the reference and of the mode.
pub fn segments(records: &[Record]) -> Vec<Segment> {
    let mut segments: Vec<Segment> = Vec::new();
    for (i, record) in records.iter().enumerate() {
        if record.mode.drive() != Some(Drive::Regulate) {
            continue;
        }
        match segments.last_mut() {
            Some(last) if last.ticks.end == i && is_at(last.reference_rad, record) => {
                last.ticks.end = i + 1;
            }
            _ => segments.push(Segment {
                ticks: i..i + 1,
                reference_rad: record.reference_rad,
            }),
        }
    }
    segments
}

/// Whether the record has this reference, to the bit: it is a repeated command, not
/// computed.
fn is_at(reference_rad: [f32; JOINTS], record: &Record) -> bool {
    reference_rad.map(f32::to_bits) == record.reference_rad.map(f32::to_bits)
}

/// Performance at one setpoint.
#[derive(Clone, Debug, Serialize)]
pub struct SegmentSummary {
    /// Start, in s after the first record.
    pub start_s: f64,
    /// End, in s after the first record.
    pub end_s: f64,
    /// Each joint.
    pub joints: [JointSummary; JOINTS],
}

/// Performance of one joint at one setpoint.
#[derive(Clone, Debug, Serialize)]
pub struct JointSummary {
    /// Setpoint in rad.
    pub reference_rad: f32,
    /// Time from the setpoint's beginning until |estimate - reference| is below
    /// [`SETTLED_RAD`] for the rest of the segment; none if it never is.
    pub settling_time_s: Option<f64>,
    /// Mean of estimate - reference over the last [`STEADY_S`], in mrad.
    pub steady_state_error_mrad: f64,
    /// The same in encoder counts.
    pub steady_state_error_counts: f64,
}

impl SegmentSummary {
    /// Evaluates one segment of a run.
    pub fn evaluate(records: &[Record], segment: &Segment, facts: &RunFacts) -> Self {
        let ticks = &records[segment.ticks.clone()];
        let mut tally = SegmentTally::begin(&ticks[0]);
        ticks[1..].iter().for_each(|record| tally.add(record));
        tally.finished().summary(records[0].start_us, facts)
    }
}

/// Ticks of one segment, added one by one.
#[derive(Clone, Debug)]
pub(super) struct SegmentTally {
    start_us: u64,
    last_us: u64,
    reference_rad: [f32; JOINTS],
    /// Start of the present settled time of each joint, if it is settled.
    inside_us: [Option<u64>; JOINTS],
    /// Errors of the last [`STEADY_S`], and their times.
    tail: VecDeque<(u64, [f64; JOINTS])>,
}

impl SegmentTally {
    pub(super) fn begin(record: &Record) -> Self {
        let mut tally = Self {
            start_us: record.start_us,
            last_us: record.start_us,
            reference_rad: record.reference_rad,
            inside_us: [None; JOINTS],
            tail: VecDeque::new(),
        };
        tally.add(record);
        tally
    }

    /// Whether this tick, which follows the last, belongs to the segment.
    pub(super) fn contains(&self, record: &Record) -> bool {
        is_at(self.reference_rad, record)
    }

    pub(super) fn add(&mut self, record: &Record) {
        let now_us = record.start_us;
        self.last_us = now_us;
        let error_rad: [f64; JOINTS] = std::array::from_fn(|j| {
            f64::from(record.angle_rad[j]) - f64::from(record.reference_rad[j])
        });
        for (inside_us, error_rad) in self.inside_us.iter_mut().zip(error_rad) {
            // False for an estimate that is not a number, too.
            if error_rad.abs() < SETTLED_RAD {
                inside_us.get_or_insert(now_us);
            } else {
                *inside_us = None;
            }
        }
        self.tail.push_back((now_us, error_rad));
        let steady_us = (STEADY_S * 1e6) as u64;
        while let Some((at_us, _)) = self.tail.front()
            && now_us.saturating_sub(*at_us) >= steady_us
        {
            self.tail.pop_front();
        }
    }

    /// Result at the end of the segment.
    pub(super) fn finished(&self) -> FinishedSegment {
        let sum = |joint: usize| self.tail.iter().map(|(_, error)| error[joint]).sum::<f64>();
        FinishedSegment {
            start_us: self.start_us,
            last_us: self.last_us,
            reference_rad: self.reference_rad,
            inside_us: self.inside_us,
            steady_error_rad: std::array::from_fn(|j| sum(j) / self.tail.len().max(1) as f64),
        }
    }
}

/// A segment that has ended.
#[derive(Clone, Copy, Debug)]
pub(super) struct FinishedSegment {
    start_us: u64,
    last_us: u64,
    reference_rad: [f32; JOINTS],
    inside_us: [Option<u64>; JOINTS],
    steady_error_rad: [f64; JOINTS],
}

impl FinishedSegment {
    /// Settling time of the slower joint, in s; infinite if one never settled.
    pub(super) fn settling_s(&self) -> f64 {
        let settling = |inside_us: Option<u64>| {
            inside_us.map_or(f64::INFINITY, |at_us| (at_us - self.start_us) as f64 * 1e-6)
        };
        self.inside_us.map(settling).into_iter().fold(0.0, f64::max)
    }

    /// Larger steady-state error of the joints, in rad.
    pub(super) fn steady_error_rad(&self) -> f64 {
        self.steady_error_rad
            .map(f64::abs)
            .into_iter()
            .fold(0.0, f64::max)
    }

    /// Summary with times after a run's first record.
    pub(super) fn summary(&self, origin_us: u64, facts: &RunFacts) -> SegmentSummary {
        let seconds = |at_us: u64| at_us.saturating_sub(origin_us) as f64 * 1e-6;
        let start_s = seconds(self.start_us);
        let joints = std::array::from_fn(|j| {
            let error_mrad = self.steady_error_rad[j] * 1e3;
            JointSummary {
                reference_rad: self.reference_rad[j],
                settling_time_s: self.inside_us[j].map(|at_us| seconds(at_us) - start_s),
                steady_state_error_mrad: error_mrad,
                steady_state_error_counts: error_mrad / facts.count_mrad(j),
            }
        });
        SegmentSummary {
            start_s,
            end_s: seconds(self.last_us) + f64::from(facts.period_us) * 1e-6,
            joints,
        }
    }
}
