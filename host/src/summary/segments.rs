//! A run cut at its setpoints.

use crate::facts::RunFacts;
use armbridge_shared::JOINTS;
use armbridge_shared::link::message::{Drive, Record};
use serde::Serialize;
use std::ops::Range;

/// A joint has settled when its error stays below this, in rad.
pub const SETTLED_RAD: f64 = 0.020;

/// Over how much of a segment's end its steady-state error is taken, in s.
pub const STEADY_S: f64 = 0.5;

/// Ticks in a row that regulate about one reference.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Where in the records.
    pub ticks: Range<usize>,
    /// Reference in rad.
    pub reference_rad: [f32; JOINTS],
}

/// Cuts a run at each change of the reference and of the mode.
pub fn segments(records: &[Record]) -> Vec<Segment> {
    // To the bit: a reference is a command that is repeated, not computed.
    let same = |a: [f32; JOINTS], b: [f32; JOINTS]| a.map(f32::to_bits) == b.map(f32::to_bits);
    let mut segments: Vec<Segment> = Vec::new();
    for (i, record) in records.iter().enumerate() {
        if record.mode.drive() != Some(Drive::Regulate) {
            continue;
        }
        match segments.last_mut() {
            Some(last) if last.ticks.end == i && same(last.reference_rad, record.reference_rad) => {
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

/// How well the arm went to one setpoint.
#[derive(Clone, Debug, Serialize)]
pub struct SegmentSummary {
    /// When it began, in s after the first record.
    pub start_s: f64,
    /// When it ended, in s after the first record.
    pub end_s: f64,
    /// Each joint.
    pub joints: [JointSummary; JOINTS],
}

/// How well one joint went to one setpoint.
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
    /// Looks at one segment of a run.
    pub fn of(records: &[Record], segment: &Segment, facts: &RunFacts) -> Self {
        let ticks = &records[segment.ticks.clone()];
        let origin_us = records[0].start_us;
        let period_s = f64::from(facts.period_us) * 1e-6;
        let start_s = seconds_since(origin_us, &ticks[0]);
        let end_s = seconds_since(origin_us, &ticks[ticks.len() - 1]) + period_s;
        let joints = std::array::from_fn(|j| {
            let error_rad = |record: &Record| {
                f64::from(record.angle_rad[j]) - f64::from(record.reference_rad[j])
            };
            // False for an estimate that is not a number, too.
            let within = |record: &Record| error_rad(record).abs() < SETTLED_RAD;
            let settled = ticks
                .iter()
                .rposition(|record| !within(record))
                .map_or(0, |last| last + 1);
            let steady_ticks = ((STEADY_S / period_s).round() as usize).clamp(1, ticks.len());
            let tail = &ticks[ticks.len() - steady_ticks..];
            let error_mrad = tail.iter().map(error_rad).sum::<f64>() / tail.len() as f64 * 1e3;
            JointSummary {
                reference_rad: segment.reference_rad[j],
                settling_time_s: ticks
                    .get(settled)
                    .map(|record| seconds_since(origin_us, record) - start_s),
                steady_state_error_mrad: error_mrad,
                steady_state_error_counts: error_mrad / facts.count_mrad(j),
            }
        });
        Self {
            start_s,
            end_s,
            joints,
        }
    }
}

/// Time of a record after the first of its run, in s.
pub(crate) fn seconds_since(origin_us: u64, record: &Record) -> f64 {
    record.start_us.saturating_sub(origin_us) as f64 * 1e-6
}
