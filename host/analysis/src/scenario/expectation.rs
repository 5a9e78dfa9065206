//! Monitor of a scenario's expectations.

use armbridge_client::experiment_text;
use armbridge_link::experiment::{Conclusion, ExperimentEnd};
use armbridge_link::message::{Drive, Mode, Record};
use armbridge_log::summary::{PushTally, Settling, Summary, Tally};
use armbridge_servo::JOINTS;
use armbridge_sim::plant::{Lead, Push};

use super::stay::StayMonitor;
use super::{EndName, Expect};

/// Monitor that observes a run and evaluates its expectations at the end.
#[derive(Clone, Debug)]
pub struct ExpectationMonitor {
    expect: Expect,
    /// Pushes in order, their times since the run began.
    pushes: Vec<Push>,
    next: usize,
    /// Start of the run on the board's clock.
    begun_us: Option<u64>,
    recovery: Option<PushTally>,
    slowest_s: f64,
    stay: StayMonitor,
    park: ParkMonitor,
    /// Conclusions of experiments.
    ends: Vec<Conclusion>,
}

/// Duration of the slowest park.
#[derive(Clone, Copy, Debug, Default)]
struct ParkMonitor {
    since_us: Option<u64>,
    slowest_us: Option<u64>,
    has_failed: bool,
}

impl ParkMonitor {
    fn on_record(&mut self, now_us: u64, mode: Mode) {
        if mode.drive() == Some(Drive::Park) {
            self.since_us.get_or_insert(now_us);
        } else if let Some(since_us) = self.since_us.take() {
            let lasted_us = now_us.saturating_sub(since_us);
            self.slowest_us = self.slowest_us.max(Some(lasted_us));
            self.has_failed |= mode != Mode::Idle;
        }
    }

    /// Infinite without a park, and where one has not ended with motors off.
    fn slowest_s(&self) -> f64 {
        let slowest_us = self
            .slowest_us
            .filter(|_| !self.has_failed && self.since_us.is_none());
        slowest_us.map_or(f64::INFINITY, |slowest_us| slowest_us as f64 * 1e-6)
    }
}

impl ExpectationMonitor {
    /// Monitor of a run with these pushes and hands.
    pub fn new(expect: Expect, pushes: &[Push], leads: &[Lead]) -> Self {
        Self {
            expect,
            pushes: pushes.to_vec(),
            next: 0,
            begun_us: None,
            recovery: None,
            slowest_s: 0.0,
            stay: StayMonitor::new(leads),
            park: ParkMonitor::default(),
            ends: Vec::new(),
        }
    }

    /// Records the end of an experiment.
    pub fn on_experiment_end(&mut self, conclusion: &Conclusion) {
        self.ends.push(*conclusion);
    }

    /// Observes the next tick. Returns the push that begins with it, on the board's clock.
    pub fn on_record(&mut self, record: &Record) -> Option<Push> {
        let begun_us = *self.begun_us.get_or_insert(record.input.start_us);
        let now_us = record.input.start_us.saturating_sub(begun_us);
        self.stay.on_record(now_us, record);
        self.park.on_record(now_us, record.mode);
        let next = self.pushes.get(self.next).copied();
        let begun = next.filter(|push| now_us >= push.start_ns / 1_000);
        let begun = begun.map(|push| Push {
            start_ns: push.start_ns + begun_us * 1_000,
            ..push
        });
        if let Some(push) = begun {
            self.end_recovery();
            self.next += 1;
            self.recovery = Some(PushTally::begin(push));
        }
        if let Some(recovery) = &mut self.recovery {
            recovery.add(record);
        }
        begun
    }

    fn end_recovery(&mut self) {
        if let Some(recovery) = self.recovery.take() {
            self.slowest_s = self
                .slowest_s
                .max(recovery.recovered_s().unwrap_or(f64::INFINITY));
        }
    }

    /// Expectations that were not met, one sentence each.
    pub fn misses(mut self, tally: &Tally, summary: &Summary) -> Vec<String> {
        if self.next < self.pushes.len() {
            // The run ended before the last push.
            self.slowest_s = f64::INFINITY;
        }
        self.end_recovery();
        let worse = |[a, b]: [f64; JOINTS]| a.max(b);
        let seconds = |s: f64| {
            if s.is_finite() {
                format!("takes {s:.3} s")
            } else {
                "never happens".into()
            }
        };
        let rests_rad = tally.worst_steady_error_rad();
        let tracks_rad = tally.tracking_rms_mrad().map(|rms| worse(rms) * 1e-3);
        let torque_nm = worse(summary.peak_torque_nm);
        let expect = self.expect;
        [
            late_settling(expect.settles_within_s, tally.settling()),
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
            miss(
                expect.stays_within_rad,
                self.stay.farthest_rad(),
                |found, limit| {
                    let found = if found.is_finite() {
                        format!("moves a joint by {found:.4} rad")
                    } else {
                        "does not float".into()
                    };
                    format!("an arm of which a hand lets go {found}, not within {limit} rad")
                },
            ),
            miss(
                expect.parks_within_s,
                Some(self.park.slowest_s()),
                |found, limit| format!("parking {}, not {limit} s", seconds(found)),
            ),
            miss(expect.torque_within_nm, Some(torque_nm), |found, limit| {
                format!("a joint's torque is {found:.3} N m, not within {limit} N m")
            }),
        ]
        .into_iter()
        .flatten()
        .chain(self.unexpected_ends())
        .collect()
    }

    /// Experiments with an unexpected end.
    fn unexpected_ends(&self) -> Vec<String> {
        let Some(expected) = self.expect.experiments_end else {
            return Vec::new();
        };
        if self.ends.is_empty() {
            return vec!["there was no experiment to evaluate".into()];
        }
        let is_expected = |conclusion: &&Conclusion| match conclusion.end {
            ExperimentEnd::Finished => expected == EndName::Finished,
            ExperimentEnd::Angle { .. } => expected == EndName::Angle,
            ExperimentEnd::Speed { .. } => expected == EndName::Speed,
            ExperimentEnd::HostQuiet | ExperimentEnd::Replaced => false,
        };
        let unexpected = self.ends.iter().filter(|end| !is_expected(end));
        unexpected.map(experiment_text::conclusion).collect()
    }
}

/// Message if settling takes longer than its limit, or was never seen. A setpoint that ended
/// before the limit proves neither.
fn late_settling(limit_s: Option<f64>, settling: Settling) -> Option<String> {
    let limit_s = limit_s?;
    let message = |found: String| Some(format!("settling at a setpoint {found}, not {limit_s} s"));
    match (settling.slowest_s, settling.unsettled_s) {
        (_, Some(unsettled_s)) if unsettled_s > limit_s => {
            message(format!("takes more than {unsettled_s:.3} s"))
        }
        (Some(slowest_s), _) if slowest_s <= limit_s => None,
        (Some(slowest_s), _) => message(format!("takes {slowest_s:.3} s")),
        (None, _) => message("was not seen".into()),
    }
}

/// Message if a quantity exceeds its limit, or was never measured.
fn miss(
    limit: Option<f64>,
    found: Option<f64>,
    message: impl Fn(f64, f64) -> String,
) -> Option<String> {
    let limit = limit?;
    match found {
        None => Some(format!(
            "{}: there was nothing to evaluate",
            message(f64::INFINITY, limit)
        )),
        // A NaN exceeds every limit.
        Some(found) if found <= limit => None,
        Some(found) => Some(message(found, limit)),
    }
}

#[cfg(test)]
mod tests {
    use armbridge_link::message::{Drive, Mode, TickInput, TickOutput};

    use super::*;

    /// Recovery within this time is expected; the error after a push from 1.0 to 1.1 s is
    /// large until `back_s`, and the run ends at `end_s`, with another setpoint from `next_s`.
    fn recovery(back_s: f64, next_s: f64, end_s: f64) -> Vec<String> {
        let push = Push {
            joint: 0,
            torque_nm: 0.2,
            start_ns: 1_000_000_000,
            duration_ns: 100_000_000,
        };
        let expect = Expect {
            recovers_within_s: Some(1.0),
            ..Expect::default()
        };
        let mut judge = ExpectationMonitor::new(expect, &[push], &[]);
        let mut tally = Tally::default();
        for tick in 0..(end_s * 1e3) as u32 {
            let now_s = f64::from(tick) * 1e-3;
            let is_off = (1.0..back_s).contains(&now_s) || now_s >= next_s;
            let record = Record {
                mode: Mode::Running(Drive::Regulate),
                input: TickInput {
                    start_us: u64::from(tick) * 1_000,
                    ..TickInput::AT_REST
                },
                output: TickOutput {
                    reference_rad: [if now_s < next_s { 0.0 } else { 0.3 }, 0.0],
                    angle_rad: [if is_off && now_s < next_s { 0.1 } else { 0.0 }, 0.0],
                    ..TickOutput::NONE
                },
                ..Record::NONE
            };
            judge.on_record(&record);
            tally.add(&record);
        }
        let facts = armbridge_log::run_info::RunFacts::from_settings(
            "test",
            "simulated: bench",
            &armbridge_link::message::Settings::default(),
        );
        let summary = tally.summary(&facts, armbridge_client::LinkStats::default(), end_s, 0.0);
        judge.misses(&tally, &summary)
    }

    /// The rule of the summary: both joints stay in the band for 0.5 s, and until the
    /// setpoint ends.
    #[test]
    fn recovery_from_a_push_is_that_of_the_summary() {
        assert_eq!(recovery(1.5, 9.0, 3.0), [""; 0]);
        let never = recovery(1.5, 9.0, 1.8);
        assert!(never.concat().contains("never happens"), "{never:?}");
        // A setpoint that follows is no relapse.
        assert_eq!(recovery(1.5, 2.5, 4.0), [""; 0]);
    }

    #[test]
    fn a_setpoint_that_ends_before_the_limit_proves_nothing() {
        let judge = |slowest_s, unsettled_s| {
            let settling = Settling {
                slowest_s,
                unsettled_s,
            };
            late_settling(Some(1.2), settling)
        };
        assert_eq!(judge(Some(0.9), None), None);
        assert_eq!(judge(Some(0.9), Some(0.4)), None);
        for (slowest_s, unsettled_s, words) in [
            (Some(0.9), Some(1.3), "takes more than 1.300 s, not 1.2 s"),
            (Some(1.3), Some(0.4), "takes 1.300 s"),
            (None, Some(0.4), "was not seen"),
            (None, None, "was not seen"),
        ] {
            let missed = judge(slowest_s, unsettled_s).unwrap();
            assert!(missed.contains(words), "{missed}");
        }
    }
}
