//! Segments of a run between changes of the setpoint.

use std::collections::VecDeque;
use std::ops::Range;

use armbridge_client::simulation::Push;
use armbridge_link::message::{Drive, Record};
use armbridge_servo::JOINTS;
use serde::Serialize;

use crate::run_info::RunFacts;

/// A joint has settled when its error stays below this, in rad.
pub const SETTLED_RAD: f64 = 0.020;

/// Time at a segment's end over which its steady-state error is averaged, and for which a
/// joint must have been settled, in s.
pub const STEADY_S: f64 = 0.5;

/// The same in µs.
pub(super) const STEADY_US: u64 = 500_000;

/// A joint that moves less than this in that time is at rest, in rad: four encoder counts, so
/// that friction and noise do not count as motion.
const REST_RANGE_RAD: f64 = SETTLED_RAD;

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
                reference_rad: record.output.reference_rad,
            }),
        }
    }
    segments
}

/// Whether the record has this reference, to the bit: it is a repeated command, not
/// computed.
pub(super) fn is_at(reference_rad: [f32; JOINTS], record: &Record) -> bool {
    reference_rad.map(f32::to_bits) == record.output.reference_rad.map(f32::to_bits)
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
    /// [`SETTLED_RAD`] for the rest of the segment, or until it is pushed; none if that is
    /// not the case for [`STEADY_S`].
    pub settling_time_s: Option<f64>,
    /// The joint rests at the end of the segment, at any error, and no fault ended it.
    pub is_at_rest: bool,
    /// Mean of estimate - reference over the last [`STEADY_S`], in mrad.
    pub steady_state_error_mrad: f64,
    /// The same in encoder counts.
    pub steady_state_error_counts: f64,
}

impl SegmentSummary {
    /// Evaluates one segment of a run.
    pub fn evaluate(records: &[Record], segment: &Segment, facts: &RunFacts) -> Self {
        Self::evaluate_pushed(records, segment, &[], facts)
    }

    /// Evaluates one segment of a run with these pushes, in the order of their start.
    pub fn evaluate_pushed(
        records: &[Record],
        segment: &Segment,
        pushes: &[Push],
        facts: &RunFacts,
    ) -> Self {
        let ticks = &records[segment.ticks.clone()];
        let start_ns = ticks[0].input.start_us * 1_000;
        let mut pushes = pushes
            .iter()
            .filter(|push| push.start_ns >= start_ns)
            .peekable();
        let mut tally = SegmentTally::begin(&ticks[0]);
        for record in &ticks[1..] {
            while let Some(push) =
                pushes.next_if(|push| push.start_ns <= record.input.start_us * 1_000)
            {
                tally.push(push);
            }
            tally.add(record);
        }
        tally.finished().summary(records[0].input.start_us, facts)
    }
}

/// Whether a joint settled at its setpoint.
#[derive(Clone, Copy, Debug)]
enum Settling {
    /// It has been settled since this time, in µs.
    At(u64),
    /// It had not begun to settle by this time, in µs.
    NotBy(u64),
}

/// Ticks of one segment, added one by one.
#[derive(Clone, Debug)]
pub(super) struct SegmentTally {
    start_us: u64,
    last_us: u64,
    reference_rad: [f32; JOINTS],
    /// Start of the present time of each joint within the band, if it is there.
    inside_us: [Option<u64>; JOINTS],
    /// Settling of each joint before the first push.
    before_push: Option<[Settling; JOINTS]>,
    /// End of the last push.
    pushed_until_us: u64,
    /// Errors of the last [`STEADY_S`], and their times.
    tail: VecDeque<(u64, [f64; JOINTS])>,
}

impl SegmentTally {
    pub(super) fn begin(record: &Record) -> Self {
        let mut tally = Self {
            start_us: record.input.start_us,
            last_us: record.input.start_us,
            reference_rad: record.output.reference_rad,
            inside_us: [None; JOINTS],
            before_push: None,
            pushed_until_us: 0,
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
        let now_us = record.input.start_us;
        self.last_us = now_us;
        let error_rad: [f64; JOINTS] = std::array::from_fn(|j| {
            f64::from(record.output.angle_rad[j]) - f64::from(record.output.reference_rad[j])
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
        while let Some((at_us, _)) = self.tail.front()
            && now_us.saturating_sub(*at_us) >= STEADY_US
        {
            self.tail.pop_front();
        }
    }

    /// The arm is pushed: what settles from here on settles from the push.
    pub(super) fn push(&mut self, push: &Push) {
        self.before_push.get_or_insert(self.settling());
        self.pushed_until_us = (push.start_ns + push.duration_ns).div_ceil(1_000);
    }

    /// Settling of each joint up to the last tick.
    fn settling(&self) -> [Settling; JOINTS] {
        self.inside_us.map(|inside_us| match inside_us {
            Some(at_us) if self.last_us.saturating_sub(at_us) >= STEADY_US => Settling::At(at_us),
            Some(at_us) => Settling::NotBy(at_us),
            None => Settling::NotBy(self.last_us),
        })
    }

    /// Whether the setpoint has been in force, without a push, for [`STEADY_S`].
    pub(super) fn is_undisturbed(&self) -> bool {
        let begun_us = self.start_us.max(self.pushed_until_us);
        self.last_us.saturating_sub(begun_us) >= STEADY_US
    }

    fn is_at_rest(&self, joint: usize) -> bool {
        let errors = self.tail.iter().map(|(_, error_rad)| error_rad[joint]);
        let range = errors.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], error| {
            [low.min(error), high.max(error)]
        });
        self.is_undisturbed() && range[1] - range[0] <= REST_RANGE_RAD
    }

    /// Result at the end of the segment.
    pub(super) fn finished(&self) -> FinishedSegment {
        let sum = |joint: usize| self.tail.iter().map(|(_, error)| error[joint]).sum::<f64>();
        FinishedSegment {
            start_us: self.start_us,
            last_us: self.last_us,
            reference_rad: self.reference_rad,
            settling: self.before_push.unwrap_or_else(|| self.settling()),
            is_at_rest: std::array::from_fn(|j| self.is_at_rest(j)),
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
    settling: [Settling; JOINTS],
    is_at_rest: [bool; JOINTS],
    steady_error_rad: [f64; JOINTS],
}

impl FinishedSegment {
    /// The same segment, ended by a fault.
    pub(super) fn ended_by_fault(self) -> Self {
        Self {
            is_at_rest: [false; JOINTS],
            ..self
        }
    }

    /// Settling time of the slower joint, in s; an error with the time for which a joint
    /// had not begun to settle, if one never did.
    pub(super) fn settling_s(&self) -> Result<f64, f64> {
        let seconds = |at_us: u64| at_us.saturating_sub(self.start_us) as f64 * 1e-6;
        let (mut slower_s, mut unsettled_s) = (0.0, None);
        for joint in self.settling {
            match joint {
                Settling::At(at_us) => slower_s = seconds(at_us).max(slower_s),
                Settling::NotBy(at_us) => {
                    unsettled_s = Some(seconds(at_us).max(unsettled_s.unwrap_or(0.0)));
                }
            }
        }
        unsettled_s.map_or(Ok(slower_s), Err)
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
                settling_time_s: match self.settling[j] {
                    Settling::At(at_us) => Some(seconds(at_us) - start_s),
                    Settling::NotBy(_) => None,
                },
                is_at_rest: self.is_at_rest[j],
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
