//! Pushes on a simulated arm, and the recovery from each.

use armbridge_client::simulation::Push;
use armbridge_link::message::{Drive, Record};
use armbridge_servo::JOINTS;
use serde::Serialize;

use super::segments::{SETTLED_RAD, STEADY_US, is_at};

/// Recovery from one push.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PushSummary {
    /// Start, in s after the first record.
    pub start_s: f64,
    /// The joint, counting from 1.
    pub joint: usize,
    /// Torque in N m.
    pub torque_nm: f64,
    /// Duration in s.
    pub duration_s: f64,
    /// Largest |estimate - reference| of a joint from then on, in mrad.
    pub peak_error_mrad: f64,
    /// Time from the end of the push until both joints are within [`SETTLED_RAD`] of the
    /// reference, and stay there; none if they do not.
    pub recovered_s: Option<f64>,
}

/// A push and the ticks after it, added one by one, until the setpoint changes, torque goes
/// off, or another push begins.
#[derive(Clone, Copy, Debug)]
pub struct PushTally {
    push: Push,
    drive: Option<Drive>,
    reference_rad: [f32; JOINTS],
    peak_error_rad: f64,
    /// Start of the present time within the band.
    inside_us: Option<u64>,
    last_us: u64,
    is_over: bool,
}

impl PushTally {
    /// Begins with a push at a time of the board's clock.
    pub fn begin(push: Push) -> Self {
        Self {
            push,
            drive: None,
            reference_rad: [0.0; JOINTS],
            peak_error_rad: 0.0,
            inside_us: None,
            last_us: 0,
            is_over: false,
        }
    }

    fn end_us(&self) -> u64 {
        (self.push.start_ns + self.push.duration_ns).div_ceil(1_000)
    }

    /// Adds the next tick.
    pub fn add(&mut self, record: &Record) {
        let drive = record.mode.drive();
        if self.drive.is_none() {
            self.drive = drive;
            self.reference_rad = record.output.reference_rad;
        }
        let is_other_setpoint =
            drive == Some(Drive::Regulate) && !is_at(self.reference_rad, record);
        self.is_over |= drive.is_none() || drive != self.drive || is_other_setpoint;
        if self.is_over {
            return;
        }
        let now_us = record.input.start_us;
        self.last_us = now_us;
        let error_rad = (0..JOINTS)
            .map(|j| f64::from((record.output.angle_rad[j] - record.output.reference_rad[j]).abs()))
            .fold(0.0, f64::max);
        self.peak_error_rad = self.peak_error_rad.max(error_rad);
        if error_rad < SETTLED_RAD && now_us >= self.end_us() {
            self.inside_us.get_or_insert(now_us);
        } else {
            self.inside_us = None;
        }
    }

    /// Time in s from the end of the push until both joints are within [`SETTLED_RAD`] of the
    /// reference and stay there, for [`STEADY_S`](super::STEADY_S) at least; none if they do
    /// not.
    pub fn recovered_s(&self) -> Option<f64> {
        let stays = |inside_us: &u64| self.last_us.saturating_sub(*inside_us) >= STEADY_US;
        let recovered_us = self.inside_us.filter(stays)?;
        Some((recovered_us - self.end_us()) as f64 * 1e-6)
    }

    pub(super) fn summary(&self, origin_us: u64) -> PushSummary {
        let Push {
            joint,
            torque_nm,
            start_ns,
            duration_ns,
        } = self.push;
        PushSummary {
            start_s: (start_ns as f64 - origin_us as f64 * 1e3) * 1e-9,
            joint: joint + 1,
            torque_nm,
            duration_s: duration_ns as f64 * 1e-9,
            peak_error_mrad: self.peak_error_rad * 1e3,
            recovered_s: self.recovered_s(),
        }
    }
}
