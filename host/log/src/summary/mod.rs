//! Summary of a run: setpoints, errors, timing, and losses.
//!
//! [`Tally`] accumulates it tick by tick, for runs of any length, and
//! [`Summary::from_records`] computes it from records in memory. It is one JSON object with
//! units in its keys, and [`Summary::table`] is the same for a terminal.
//! Times are in s after the first record. The summary has no verdict; faults, missing
//! samples and lost records are all listed.

mod pushes;
mod remarks;
mod rest_torque;
mod segments;
mod spread;
mod table;
mod tally;

pub use pushes::{PushSummary, PushTally};
pub use rest_torque::RestTorque;
pub use segments::{JointSummary, SETTLED_RAD, STEADY_S, Segment, SegmentSummary, segments};
pub use spread::{Counts, Spread};
pub use tally::{Settling, Tally};

use std::collections::BTreeMap;

use armbridge_client::LinkStats;
use armbridge_link::message::{PortCounters, Record, Trip};
use armbridge_servo::JOINTS;
use serde::Serialize;

use crate::run_info::RunFacts;

/// Summary of a run.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Facts of the run.
    pub run: RunFacts,
    /// Ticks whose record arrived.
    pub ticks: u64,
    /// Time that the run covers, in s.
    pub simulated_s: f64,
    /// Wall time, in s.
    pub wall_s: f64,
    /// Ratio of the two.
    pub simulated_s_per_wall_s: f64,
    /// One entry per setpoint, the first of them in a long run.
    pub segments: Vec<SegmentSummary>,
    /// Setpoints that are not among them.
    pub segments_left_out: u64,
    /// Pushes on a simulated arm, the first of them in a long run.
    pub pushes: Vec<PushSummary>,
    /// Root mean square of estimate - reference while the reference moved, in mrad; none if
    /// it never did.
    pub tracking_rms_mrad: Option<[f64; JOINTS]>,
    /// Largest torque of each joint by magnitude, in N m.
    pub peak_torque_nm: [f64; JOINTS],
    /// Largest torque that can be commanded in the direction of that one, in N m.
    pub peak_torque_limit_nm: [f64; JOINTS],
    /// Torque while the arm rests; none if it never does.
    pub rest_torque: Option<RestTorque>,
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
    /// Counts of records.
    pub records: LinkStats,
    /// Report on the log; none without a log.
    pub log: Option<LogSummary>,
    /// Firmware of the servos, and their baud rate; none if not known.
    pub servos: Option<ServoSummary>,
    /// Counts of packets on the transparent port; none without
    /// a client.
    pub port: Option<PortCounters>,
    /// Cause of an early end.
    pub ended: Option<String>,
    /// Expectations of a scenario that are not met.
    pub missed_expectations: Vec<String>,
    /// Explanations of the above.
    pub remarks: Vec<String>,
}

/// The servos of a bus.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ServoSummary {
    /// Firmware.
    pub firmware: String,
    /// Bits per second.
    pub baud: u32,
}

/// A fault and its time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FaultSummary {
    /// In s after the first record.
    pub time_s: f64,
    /// Its name.
    pub fault: &'static str,
    /// Its cause; none if the board has not reported it.
    pub cause: Option<Cause>,
}

/// Cause of a fault.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Cause {
    /// Number of the tick.
    pub tick: u32,
    /// The joint, counting from 1, if it was one.
    pub joint: Option<u8>,
    /// Measured value, in the unit of the limit.
    pub value: f32,
    /// The limit.
    pub limit: f32,
}

/// Report on a log.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LogSummary {
    /// Records in the file.
    pub written: u64,
    /// Ticks whose record did not arrive at the host.
    pub lost: u64,
    /// Bytes of the link that are not in the file.
    pub unwritten: u64,
    /// Size of the file in bytes.
    pub size: u64,
    /// First error.
    pub trouble: Option<String>,
}

impl LogSummary {
    /// Whether the file has the whole run.
    pub fn is_complete(&self) -> bool {
        self.lost == 0 && self.unwritten == 0 && self.trouble.is_none()
    }
}

impl Summary {
    /// Computes the summary of a run.
    pub fn from_records(
        records: &[Record],
        facts: &RunFacts,
        link: LinkStats,
        simulated_s: f64,
        wall_s: f64,
    ) -> Self {
        let mut tally = Tally::default();
        for record in records {
            tally.add(record);
        }
        tally.summary(facts, link, simulated_s, wall_s)
    }

    /// The same, with the board's reports of its faults, in their order.
    #[must_use]
    pub fn with_causes(mut self, trips: &[Trip]) -> Self {
        for (fault, trip) in self.faults.iter_mut().zip(trips) {
            fault.cause = Some(trip.into());
        }
        self.remark();
        self
    }

    /// Adds the remarks for the present numbers.
    pub fn remark(&mut self) {
        self.remarks = remarks::remarks(self);
    }
}
