//! A run in a few numbers: what was asked, how well it went, what it took.
//!
//! [`Tally`] counts them tick by tick, so that a run may be as long as it likes, and
//! [`Summary::of`] all at once from records in memory. It is one JSON object with
//! units in its keys, and [`Summary::table`] is the same for a terminal.
//! Times are in s after the first record. Nothing is judged here, but nothing
//! is hidden either: faults, missing samples and lost records all appear.

mod remarks;
mod segments;
mod spread;
mod table;
mod tally;

pub use segments::{JointSummary, SETTLED_RAD, STEADY_S, Segment, SegmentSummary, segments};
pub use spread::Spread;
pub use tally::Tally;

use std::collections::BTreeMap;

use armbridge_client::LinkStats;
use armbridge_shared::JOINTS;
use armbridge_shared::link::message::{PortCounters, Record, Trip};
use serde::Serialize;

use crate::run_info::RunFacts;

/// A run in a few numbers.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Facts of the run.
    pub run: RunFacts,
    /// Ticks whose record arrived.
    pub ticks: u64,
    /// Time that the run covers, in s.
    pub simulated_s: f64,
    /// Time that it took, in s.
    pub wall_s: f64,
    /// How much faster than real time it was.
    pub simulated_s_per_wall_s: f64,
    /// One entry per setpoint, the first of them in a long run.
    pub segments: Vec<SegmentSummary>,
    /// Setpoints that are not among them.
    pub segments_left_out: u64,
    /// Root mean square of estimate - reference while that moved, in mrad; none if
    /// it never did.
    pub tracking_rms_mrad: Option<[f64; JOINTS]>,
    /// Largest torque of each joint by magnitude, in N m.
    pub peak_torque_nm: [f64; JOINTS],
    /// Largest distance of each servo's PWM in force from [`PWM_OFF`](crate::run_info::PWM_OFF).
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
    /// What became of the log; none if there is none.
    pub log: Option<LogSummary>,
    /// What the servos run, and the speed of their bus; none if not known.
    pub servos: Option<ServoSummary>,
    /// What became of the packets on the transparent port; none if there was
    /// nobody.
    pub port: Option<PortCounters>,
    /// What ended the run, if it was not just its time.
    pub ended: Option<String>,
    /// What a scenario expected of the run and did not get.
    pub missed_expectations: Vec<String>,
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

/// What became of the log.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LogSummary {
    /// Records in the file.
    pub written: u64,
    /// Ticks whose record never came to the host.
    pub lost: u64,
    /// Bytes of the link that are not in the file.
    pub unwritten: u64,
    /// Size of the file in bytes.
    pub size: u64,
    /// What went wrong.
    pub trouble: Option<String>,
}

impl LogSummary {
    /// Whether all of the run is in the file.
    pub fn is_complete(&self) -> bool {
        self.lost == 0 && self.unwritten == 0 && self.trouble.is_none()
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
        let mut tally = Tally::default();
        for record in records {
            tally.see(record);
        }
        tally.summary(facts, link, simulated_s, wall_s)
    }

    /// The same, with what the board told of its faults, in their order.
    #[must_use]
    pub fn with_causes(mut self, trips: &[Trip]) -> Self {
        for (fault, trip) in self.faults.iter_mut().zip(trips) {
            fault.cause = Some(trip.into());
        }
        self.remark();
        self
    }

    /// Puts into words what the numbers are by now.
    pub fn remark(&mut self) {
        self.remarks = remarks::remarks(self);
    }
}
