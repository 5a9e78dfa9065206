//! Tally of a run, tick by tick: its memory does not grow with the run's length.

use std::collections::BTreeMap;

use armbridge_client::simulation::Push;
use armbridge_client::{LinkStats, enum_names};
use armbridge_link::message::{Drive, Fault, Record};
use armbridge_servo::JOINTS;

use super::pushes::PushTally;
use super::rest_torque::RestTorqueTally;
use super::segments::{FinishedSegment, SegmentTally, is_at};
use super::spread::Counts;
use super::{Cause, FaultSummary, Summary, remarks};
use crate::run_info::{PWM_OFF, RunFacts};

/// Setpoints that are listed; further ones are counted.
const SEGMENTS_MAX: usize = 200;

/// Pushes that are listed.
const PUSHES_MAX: usize = 200;

/// Tally of a run so far.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    ticks: u64,
    origin_us: u64,
    last_us: u64,
    segment: Option<SegmentTally>,
    segments: Vec<FinishedSegment>,
    segments_left_out: u64,
    pushes: Vec<PushTally>,
    settling: Settling,
    worst_steady_error_rad: Option<f64>,
    /// With its sign, on which its limit depends.
    peak_torque_nm: [f64; JOINTS],
    rest_torque: RestTorqueTally,
    peak_pwm_deviation: [u16; JOINTS],
    start_error_us: Counts,
    bus_us: Counts,
    compute_ns: Counts,
    missed_ticks: u32,
    /// The board's count at the first tick.
    missed_before: u32,
    missing: BTreeMap<&'static str, u64>,
    fault: Option<Fault>,
    faults: Vec<FaultSummary>,
    reference_rad: Option<[f32; JOINTS]>,
    tracked: u64,
    tracking_square_rad2: [f64; JOINTS],
}

/// Settling at all setpoints of a run. A joint has settled once its error stays below
/// [`SETTLED_RAD`](super::SETTLED_RAD) for [`STEADY_S`](super::STEADY_S) and until its
/// setpoint ends.
#[derive(Clone, Copy, Debug, Default)]
pub struct Settling {
    /// Longest settling time in s, of those setpoints at which both joints settled.
    pub slowest_s: Option<f64>,
    /// Longest time in s for which a joint had not begun to settle, of the other setpoints.
    pub unsettled_s: Option<f64>,
}

impl Tally {
    /// Adds the next tick.
    pub fn add(&mut self, record: &Record) {
        if self.ticks == 0 {
            self.origin_us = record.input.start_us;
            self.missed_before = record.timing.missed;
        }
        self.ticks += 1;
        self.last_us = record.input.start_us;
        for joint in 0..JOINTS {
            let torque_nm = f64::from(record.output.torque_nm[joint]);
            let peak_nm = &mut self.peak_torque_nm[joint];
            if torque_nm.abs() > peak_nm.abs() {
                *peak_nm = torque_nm;
            }
            let deviation = record.input.pwm_in_force[joint].abs_diff(PWM_OFF);
            let peak = &mut self.peak_pwm_deviation[joint];
            *peak = deviation.max(*peak);
        }
        self.missed_ticks = record.timing.missed;
        // During the search for servos, bus times and samples are not those of
        // the run.
        if enum_names::is_up(record.mode) {
            self.add_samples(record);
        }
        self.add_segment(record);
        let is_resting = self
            .segment
            .as_ref()
            .is_some_and(SegmentTally::is_undisturbed);
        self.rest_torque.add(record, is_resting);
        if let Some(push) = self.pushes.last_mut() {
            push.add(record);
        }
        self.add_fault(record);
        if self.is_moving(record) {
            self.tracked += 1;
            for joint in 0..JOINTS {
                let error_rad = record.output.angle_rad[joint] - record.output.reference_rad[joint];
                self.tracking_square_rad2[joint] += f64::from(error_rad).powi(2);
            }
        }
    }

    /// A push on a simulated arm begins.
    pub fn push(&mut self, push: &Push) {
        if let Some(segment) = &mut self.segment {
            segment.push(push);
        }
        if self.pushes.len() < PUSHES_MAX {
            self.pushes.push(PushTally::begin(*push));
        }
    }

    /// Whether the reference moves along a motion in this tick: it has a speed, or it is not
    /// where it was in the tick before.
    fn is_moving(&mut self, record: &Record) -> bool {
        let before_rad = self.reference_rad.replace(record.output.reference_rad);
        let has_speed = record
            .output
            .reference_speed_rad_s
            .iter()
            .any(|s| s.abs() > 0.0);
        let has_moved = before_rad.is_some_and(|before_rad| !is_at(before_rad, record));
        record.mode.drive() == Some(Drive::Track) && (has_speed || has_moved)
    }

    fn add_samples(&mut self, record: &Record) {
        self.start_error_us.add(record.timing.start_error_us);
        self.bus_us.add(record.timing.bus_us);
        if record.timing.compute_ns > 0 {
            self.compute_ns.add(record.timing.compute_ns);
        }
        for sample in record.input.samples {
            if let Some(kind) = sample.lost() {
                *self.missing.entry(enum_names::missing(kind)).or_default() += 1;
            }
        }
    }

    fn add_segment(&mut self, record: &Record) {
        let is_regulated = record.mode.drive() == Some(Drive::Regulate);
        if let Some(segment) = &mut self.segment
            && is_regulated
            && segment.contains(record)
        {
            segment.add(record);
            return;
        }
        if let Some(segment) = self.segment.take() {
            (self.settling, self.worst_steady_error_rad) = self.worst_with(&segment);
            if self.segments.len() < SEGMENTS_MAX {
                let finished = segment.finished();
                let is_fault = enum_names::fault_of(record.mode).is_some();
                self.segments.push(if is_fault {
                    finished.ended_by_fault()
                } else {
                    finished
                });
            } else {
                self.segments_left_out += 1;
            }
        }
        self.segment = is_regulated.then(|| SegmentTally::begin(record));
    }

    fn add_fault(&mut self, record: &Record) {
        let fault = enum_names::fault_of(record.mode);
        if let (true, Some(fault)) = (fault != self.fault, fault) {
            self.faults.push(FaultSummary {
                time_s: record.input.start_us.saturating_sub(self.origin_us) as f64 * 1e-6,
                fault: fault.name(),
                cause: None,
            });
        }
        self.fault = fault;
    }

    /// Settling and largest steady-state error, including `segment`.
    fn worst_with(&self, segment: &SegmentTally) -> (Settling, Option<f64>) {
        let finished = segment.finished();
        let worst = |before: Option<f64>, now: f64| Some(before.map_or(now, |b| b.max(now)));
        let mut settling = self.settling;
        match finished.settling_s() {
            Ok(slower_s) => settling.slowest_s = worst(settling.slowest_s, slower_s),
            Err(slower_s) => settling.unsettled_s = worst(settling.unsettled_s, slower_s),
        }
        let error_rad = finished.steady_error_rad();
        (settling, worst(self.worst_steady_error_rad, error_rad))
    }

    fn worst(&self) -> (Settling, Option<f64>) {
        self.segment
            .as_ref()
            .map_or((self.settling, self.worst_steady_error_rad), |segment| {
                self.worst_with(segment)
            })
    }

    /// Settling at the setpoints so far.
    pub fn settling(&self) -> Settling {
        self.worst().0
    }

    /// Largest steady-state error of a joint, in rad.
    pub fn worst_steady_error_rad(&self) -> Option<f64> {
        self.worst().1
    }

    /// Ticks so far.
    pub fn ticks(&self) -> u64 {
        self.ticks
    }

    /// Time from the first tick to the last, in s.
    pub fn covered_s(&self) -> f64 {
        self.last_us.saturating_sub(self.origin_us) as f64 * 1e-6
    }

    /// Root mean square of estimate - reference while the reference moved,
    /// in mrad; none if it never did.
    pub fn tracking_rms_mrad(&self) -> Option<[f64; JOINTS]> {
        let rms = |square_rad2: f64| (square_rad2 / self.tracked as f64).sqrt() * 1e3;
        (self.tracked > 0).then(|| self.tracking_square_rad2.map(rms))
    }

    /// The summary.
    pub fn summary(
        &self,
        facts: &RunFacts,
        link: LinkStats,
        simulated_s: f64,
        wall_s: f64,
    ) -> Summary {
        let bus_us = self.bus_us.spread();
        let last = self.segment.as_ref().map(SegmentTally::finished);
        let mut summary = Summary {
            run: facts.clone(),
            ticks: self.ticks,
            simulated_s,
            wall_s,
            simulated_s_per_wall_s: if wall_s > 0.0 {
                simulated_s / wall_s
            } else {
                0.0
            },
            segments: (self.segments.iter().chain(&last))
                .map(|segment| segment.summary(self.origin_us, facts))
                .collect(),
            segments_left_out: self.segments_left_out,
            pushes: (self.pushes.iter())
                .map(|push| push.summary(self.origin_us))
                .collect(),
            tracking_rms_mrad: self.tracking_rms_mrad(),
            peak_torque_nm: self.peak_torque_nm.map(f64::abs),
            peak_torque_limit_nm: std::array::from_fn(|joint| {
                facts.torque_limit_nm(joint, self.peak_torque_nm[joint])
            }),
            rest_torque: self.rest_torque.finished(),
            peak_pwm_deviation: self.peak_pwm_deviation,
            start_error_us: self.start_error_us.spread(),
            bus_us,
            bus_occupancy_percent: bus_us.mean / f64::from(facts.period_us) * 100.0,
            compute_ns: (!self.compute_ns.is_empty()).then(|| self.compute_ns.spread()),
            missed_ticks: self.missed_ticks.saturating_sub(self.missed_before),
            missing_samples: self.missing.clone(),
            faults: self.faults.clone(),
            records: link,
            log: None,
            servos: None,
            port: None,
            ended: None,
            missed_expectations: Vec::new(),
            remarks: Vec::new(),
        };
        summary.remarks = remarks::remarks(&summary);
        summary
    }
}

impl From<&armbridge_link::message::Trip> for Cause {
    fn from(trip: &armbridge_link::message::Trip) -> Self {
        Self {
            tick: trip.tick,
            joint: trip.joint.map(|joint| joint.saturating_add(1)),
            value: trip.value,
            limit: trip.limit,
        }
    }
}
