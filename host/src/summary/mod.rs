//! A run in a few numbers: what was asked, how well it went, what it took.
//!
//! [`Summary::of`] computes them from the records; it is one JSON object with
//! units in its keys, and [`Summary::table`] is the same for a terminal.
//! Times are in s after the first record. Nothing is judged here, but nothing
//! is hidden either: faults, missing samples and lost records all appear.

mod remarks;
mod segments;
mod table;

pub(crate) use segments::seconds_since;
pub use segments::{JointSummary, SETTLED_RAD, STEADY_S, Segment, SegmentSummary, segments};

use crate::facts::{PWM_OFF, RunFacts};
use crate::log::names;
use armbridge_shared::JOINTS;
use armbridge_shared::link::message::{PortCounters, Record, Sample, Trip};
use serde::Serialize;
use std::collections::BTreeMap;

/// What became of the records on their way to the host.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct LinkStats {
    /// Records that the board sent.
    pub sent: u64,
    /// Records that never arrived.
    pub lost: u64,
    /// Frames that arrived damaged.
    pub damaged: u64,
    /// Records that the board dropped before sending.
    pub dropped: u64,
}

/// A run in a few numbers.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Facts of the run.
    pub run: RunFacts,
    /// Ticks whose record arrived.
    pub ticks: usize,
    /// Time that the run covers, in s.
    pub simulated_s: f64,
    /// Time that it took, in s.
    pub wall_s: f64,
    /// How much faster than real time it was.
    pub simulated_s_per_wall_s: f64,
    /// One entry per setpoint.
    pub segments: Vec<SegmentSummary>,
    /// Largest torque of each joint by magnitude, in N m.
    pub peak_torque_nm: [f64; JOINTS],
    /// Largest distance of each servo's PWM in force from [`PWM_OFF`].
    pub peak_pwm_deviation: [u16; JOINTS],
    /// Actual minus planned start of a tick, in µs.
    pub start_error_us: Spread,
    /// Bus time of a tick, in µs.
    pub bus_us: Spread,
    /// Mean bus time in percent of the period.
    pub bus_occupancy_percent: f64,
    /// Time that a tick computed, in ns; none if it was not measured.
    pub compute_ns: Option<Spread>,
    /// Ticks skipped since boot.
    pub missed_ticks: u32,
    /// Samples missing after bring-up, by kind.
    pub missing_samples: BTreeMap<&'static str, u64>,
    /// Each entry into a fault.
    pub faults: Vec<FaultSummary>,
    /// What became of the records.
    pub records: LinkStats,
    /// What the servos run, and the speed of their bus; none if not known.
    pub servos: Option<ServoSummary>,
    /// What became of the packets on the transparent port; none if there was
    /// nobody.
    pub port: Option<PortCounters>,
    /// The above in words, where numbers alone would leave a question.
    pub remarks: Vec<String>,
}

/// The servos of a bus.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ServoSummary {
    /// What they run.
    pub firmware: String,
    /// Bits per second.
    pub baud: u32,
}

/// A fault and when it began.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FaultSummary {
    /// In s after the first record.
    pub time_s: f64,
    /// Its name.
    pub fault: &'static str,
    /// What tripped it; none if the board has not told.
    pub cause: Option<Cause>,
}

/// What tripped a fault.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Cause {
    /// In this tick.
    pub tick: u32,
    /// At this joint, counting from 1, if it was one.
    pub joint: Option<u8>,
    /// What was seen, in the unit of the limit.
    pub value: f32,
    /// What would have been allowed.
    pub limit: f32,
}

/// How a quantity spreads over the ticks of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub std: f64,
    /// Smallest value that 99 % of the ticks do not exceed.
    pub p99: u32,
    /// Largest value.
    pub max: u32,
}

impl Spread {
    /// Of these values, in any order; all zero if there are none.
    pub fn of(mut values: Vec<u32>) -> Self {
        if values.is_empty() {
            return Self::default();
        }
        values.sort_unstable();
        let n = values.len() as f64;
        let mean = values.iter().map(|&v| f64::from(v)).sum::<f64>() / n;
        let variance = values
            .iter()
            .map(|&v| (f64::from(v) - mean).powi(2))
            .sum::<f64>()
            / n;
        let p99 = values[(n * 0.99).ceil() as usize - 1];
        Self {
            mean,
            std: variance.sqrt(),
            p99,
            max: values[values.len() - 1],
        }
    }
}

impl Summary {
    /// Computes the summary of a run.
    pub fn of(
        records: &[Record],
        facts: &RunFacts,
        link: LinkStats,
        simulated_s: f64,
        wall_s: f64,
    ) -> Self {
        // While servos are being found, the bus and the samples say nothing
        // about the run.
        let up = || records.iter().filter(|r| names::is_up(r.mode));
        let bus_us = Spread::of(up().map(|r| r.timing.bus_us).collect());
        let compute: Vec<u32> = up()
            .map(|r| r.timing.compute_ns)
            .filter(|&ns| ns > 0)
            .collect();
        let mut summary = Self {
            run: facts.clone(),
            ticks: records.len(),
            simulated_s,
            wall_s,
            simulated_s_per_wall_s: if wall_s > 0.0 {
                simulated_s / wall_s
            } else {
                0.0
            },
            segments: segments(records)
                .iter()
                .map(|segment| SegmentSummary::of(records, segment, facts))
                .collect(),
            peak_torque_nm: peak(records, |r, j| f64::from(r.torque_nm[j].abs()), f64::max),
            peak_pwm_deviation: peak(
                records,
                |r, j| r.pwm_in_force[j].abs_diff(PWM_OFF),
                u16::max,
            ),
            start_error_us: Spread::of(up().map(|r| r.timing.start_error_us).collect()),
            bus_us,
            bus_occupancy_percent: bus_us.mean / f64::from(facts.period_us) * 100.0,
            compute_ns: (!compute.is_empty()).then(|| Spread::of(compute)),
            missed_ticks: records.last().map_or(0, |r| r.timing.missed),
            missing_samples: missing_samples(up()),
            faults: faults(records),
            records: link,
            servos: None,
            port: None,
            remarks: Vec::new(),
        };
        summary.remarks = remarks::remarks(&summary);
        summary
    }
}

/// Largest value of each joint.
impl Summary {
    /// The same, with what the board told of its faults, in their order.
    #[must_use]
    pub fn with_causes(mut self, trips: &[Trip]) -> Self {
        for (fault, trip) in self.faults.iter_mut().zip(trips) {
            fault.cause = Some(Cause {
                tick: trip.tick,
                joint: trip.joint.map(|joint| joint + 1),
                value: trip.value,
                limit: trip.limit,
            });
        }
        self.remarks = remarks::remarks(&self);
        self
    }
}

fn peak<T: Copy + Default>(
    records: &[Record],
    value: impl Fn(&Record, usize) -> T,
    larger: impl Fn(T, T) -> T,
) -> [T; JOINTS] {
    std::array::from_fn(|j| {
        records
            .iter()
            .map(|r| value(r, j))
            .fold(T::default(), &larger)
    })
}

fn missing_samples<'a>(records: impl Iterator<Item = &'a Record>) -> BTreeMap<&'static str, u64> {
    let mut kinds = BTreeMap::new();
    for sample in records.flat_map(|record| record.samples) {
        if let Sample::Missing(kind) = sample {
            *kinds.entry(names::missing(kind)).or_default() += 1;
        }
    }
    kinds
}

fn faults(records: &[Record]) -> Vec<FaultSummary> {
    let mut faults = Vec::new();
    let mut before = None;
    for record in records {
        let now = names::fault_of(record.mode);
        if let (true, Some(fault)) = (now != before, now) {
            let time_s = seconds_since(records[0].start_us, record);
            faults.push(FaultSummary {
                time_s,
                fault: names::fault(fault),
                cause: None,
            });
        }
        before = now;
    }
    faults
}
