//! Whether the arm did what a scenario expects of it.

use armbridge_client::experiment_text;
use armbridge_log::summary::{SETTLED_RAD, Summary, Tally};
use armbridge_shared::JOINTS;
use armbridge_shared::link::experiment::{Conclusion, ExperimentEnd};
use armbridge_shared::link::message::Record;
use armbridge_sim::plant::Push;

use super::{EndName, Expect};

/// Watches a run, and judges it in the end.
#[derive(Clone, Debug)]
pub struct Judge {
    expect: Expect,
    /// From when to when each push lasts, in µs since the run began, in order.
    pushes: Vec<[u64; 2]>,
    next: usize,
    /// On the board's clock.
    begun_us: Option<u64>,
    open: Option<Open>,
    slowest_s: f64,
    /// Of experiments.
    ends: Vec<Conclusion>,
}

/// A push that is over.
#[derive(Clone, Copy, Debug)]
struct Open {
    since_us: u64,
    /// Since when both joints are where they should be, if they are.
    inside_us: Option<u64>,
}

impl Judge {
    /// Of a run with these pushes.
    pub fn new(expect: Expect, pushes: &[Push]) -> Self {
        let span = |push: &Push| [push.start_ns, push.start_ns + push.duration_ns];
        Self {
            expect,
            pushes: pushes
                .iter()
                .map(|push| span(push).map(|ns| ns / 1_000))
                .collect(),
            next: 0,
            begun_us: None,
            open: None,
            slowest_s: 0.0,
            ends: Vec::new(),
        }
    }

    /// Takes the end of an experiment.
    pub fn see_end(&mut self, conclusion: &Conclusion) {
        self.ends.push(*conclusion);
    }

    /// Takes the next tick.
    pub fn see(&mut self, record: &Record) {
        let begun_us = *self.begun_us.get_or_insert(record.start_us);
        let now_us = record.start_us.saturating_sub(begun_us);
        if let Some([from_us, until_us]) = self.pushes.get(self.next).copied() {
            if now_us >= from_us {
                self.close();
            }
            if now_us >= until_us {
                self.next += 1;
                self.open = Some(Open {
                    since_us: now_us,
                    inside_us: None,
                });
            }
        }
        let Some(open) = &mut self.open else {
            return;
        };
        let is_inside = (0..JOINTS).all(|joint| {
            let error_rad = record.angle_rad[joint] - record.reference_rad[joint];
            f64::from(error_rad.abs()) < SETTLED_RAD
        });
        if is_inside && record.mode.drive().is_some() {
            open.inside_us.get_or_insert(now_us);
        } else {
            open.inside_us = None;
        }
    }

    fn close(&mut self) {
        if let Some(open) = self.open.take() {
            let took_s = open.inside_us.map_or(f64::INFINITY, |inside_us| {
                (inside_us - open.since_us) as f64 * 1e-6
            });
            self.slowest_s = self.slowest_s.max(took_s);
        }
    }

    /// What was expected and is not so, each in a sentence.
    pub fn verdict(mut self, tally: &Tally, summary: &Summary) -> Vec<String> {
        if self.next < self.pushes.len() {
            // The run ended before.
            self.slowest_s = f64::INFINITY;
        }
        self.close();
        let worse = |[a, b]: [f64; JOINTS]| a.max(b);
        let seconds = |s: f64| {
            if s.is_finite() {
                format!("takes {s:.3} s")
            } else {
                "never happens".into()
            }
        };
        let settles_s = tally.slowest_settling_s();
        let rests_rad = tally.worst_rest_rad();
        let tracks_rad = tally.tracking_rms_mrad().map(|rms| worse(rms) * 1e-3);
        let torque_nm = worse(summary.peak_torque_nm);
        let expect = self.expect;
        [
            miss(expect.settles_within_s, settles_s, |found, limit| {
                format!("settling at a setpoint {}, not {limit} s", seconds(found))
            }),
            miss(expect.rests_within_rad, rests_rad, |found, limit| {
                format!("a joint rests {found:.4} rad from its setpoint, not within {limit} rad")
            }),
            miss(expect.tracks_within_rad, tracks_rad, |found, limit| {
                format!("the rms error in motion is {found:.4} rad, not within {limit} rad")
            }),
            miss(
                expect.recovers_within_s,
                Some(self.slowest_s),
                |found, limit| format!("recovery from a push {}, not {limit} s", seconds(found)),
            ),
            miss(expect.torque_within_nm, Some(torque_nm), |found, limit| {
                format!("a joint's torque is {found:.3} N m, not within {limit} N m")
            }),
        ]
        .into_iter()
        .flatten()
        .chain(self.other_ends())
        .collect()
    }

    /// Experiments that ended otherwise than they should.
    fn other_ends(&self) -> Vec<String> {
        let Some(expected) = self.expect.experiments_end else {
            return Vec::new();
        };
        if self.ends.is_empty() {
            return vec!["there was no experiment to judge".into()];
        }
        let is_so = |conclusion: &&Conclusion| match conclusion.end {
            ExperimentEnd::Finished => expected == EndName::Finished,
            ExperimentEnd::Angle { .. } => expected == EndName::Angle,
            ExperimentEnd::Speed { .. } => expected == EndName::Speed,
            ExperimentEnd::HostQuiet | ExperimentEnd::Replaced => false,
        };
        let others = self.ends.iter().filter(|end| !is_so(end));
        others.map(experiment_text::conclusion).collect()
    }
}

/// What to say of an expectation that something was to be within a limit; a thing that
/// never came to be is beyond it.
fn miss(
    limit: Option<f64>,
    found: Option<f64>,
    say: impl Fn(f64, f64) -> String,
) -> Option<String> {
    let limit = limit?;
    match found {
        None => Some(format!(
            "{}: there was nothing to judge",
            say(f64::INFINITY, limit)
        )),
        // Not true of a NaN either.
        Some(found) if found <= limit => None,
        Some(found) => Some(say(found, limit)),
    }
}
