//! One run of a sweep: the plan on the simulated board, its figures, and its log if one is
//! requested.

use std::fs;
use std::path::Path;

use armbridge_link::experiment::Conclusion;
use armbridge_link::message::Record;
use armbridge_log::LogError;
use armbridge_log::recorder::Recorder;
use armbridge_log::run_info::RunFacts;
use armbridge_log::summary::Tally;
use armbridge_servo::JOINTS;
use armbridge_sim::link::{BoardUri, Options, drive};
use serde::Serialize;

use crate::plan_runner::{Ending, PlanRunner, RecordSink};
use crate::run::assess;
use crate::scenario::{ExpectationMonitor, Scenario};

/// A run of a sweep.
#[derive(Clone, Debug, Serialize)]
pub struct SweepRun {
    /// Number of its combination, from 0.
    pub combination: usize,
    /// Seed.
    pub seed: u64,
    /// Its figures.
    #[serde(flatten)]
    pub figures: RunFigures,
}

/// Figures of a run, of the worse joint.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RunFigures {
    /// Longest settling time at a setpoint, in s; none if a joint never settled, or without
    /// setpoints.
    pub settling_time_s: Option<f64>,
    /// Whether both joints settled at every setpoint; none without setpoints.
    pub settled: Option<bool>,
    /// Largest mean error at rest at a setpoint, in mrad; none without setpoints.
    pub rest_error_mrad: Option<f64>,
    /// Rms error while the reference moves, in mrad; none if it never does.
    pub tracking_rms_mrad: Option<f64>,
    /// Largest torque, in N m.
    pub peak_torque_nm: f64,
    /// First fault.
    pub fault: Option<&'static str>,
    /// Expectations of the scenario that are not met.
    pub missed_expectations: Vec<String>,
    /// Cause of an end before its time, other than by a fault, that is no success.
    pub ended: Option<String>,
}

impl RunFigures {
    /// Settling time for comparison: infinite for never; none without setpoints.
    pub(super) fn settling_s(&self) -> Option<f64> {
        self.settled?;
        Some(self.settling_time_s.unwrap_or(f64::INFINITY))
    }

    /// Whether the run did not do what the scenario describes.
    pub fn has_failed(&self) -> bool {
        self.fault.is_some() || self.ended.is_some() || !self.missed_expectations.is_empty()
    }
}

/// Sink of a run's records, of constant size.
struct Figures {
    tally: Tally,
    judge: ExpectationMonitor,
}

impl RecordSink for Figures {
    fn record(&mut self, record: &Record) {
        if let Some(push) = self.judge.on_record(record) {
            self.tally.push(&push);
        }
        self.tally.add(record);
    }

    fn concluded(&mut self, conclusion: &Conclusion) {
        self.judge.on_experiment_end(conclusion);
    }
}

/// Runs a scenario on the simulated board, with its log in a file if one is named. `None`
/// if it was interrupted; then there is no log either, which no run of a table would name.
///
/// # Errors
/// If the log cannot be written; the error names the file, which stays as far as it goes.
pub fn run(
    scenario: &Scenario,
    log: Option<&Path>,
    is_interrupted: fn() -> bool,
) -> Result<Option<RunFigures>, LogError> {
    let facts = scenario.simulated_facts(&BoardUri::Sim.world());
    let recorder = log
        .map(|path| Recorder::create_waiting(path, &facts))
        .transpose()?;
    let figures = recorded(scenario, &facts, recorder, is_interrupted);
    if let (Some(path), Ok(None)) = (log, &figures) {
        // Best effort: the sweep ends.
        let _ = fs::remove_file(path);
    }
    figures
}

/// The same with its recorder.
fn recorded(
    scenario: &Scenario,
    facts: &RunFacts,
    recorder: Option<Recorder>,
    is_interrupted: fn() -> bool,
) -> Result<Option<RunFigures>, LogError> {
    let sink = Figures {
        tally: Tally::default(),
        judge: ExpectationMonitor::new(
            scenario.expect,
            &scenario.plan.pushes,
            &scenario.plan.leads,
        ),
    };
    let runner = PlanRunner::with_sink(scenario.plan.clone(), sink);
    let mut runner = runner.interrupted_by(is_interrupted);
    let mut options = Options::new(scenario.bench.build());
    options.interactions = Some(runner.interactions());
    options
        .link
        .taps
        .extend(recorder.as_ref().map(Recorder::tap));
    let (runner, result) = drive(&BoardUri::Sim, options, runner);
    recorder.map(Recorder::finish).transpose()?;
    let ending = runner.ending();
    if ending == Some(Ending::Interrupted) || (result.is_err() && is_interrupted()) {
        return Ok(None);
    }
    let link = runner.stats();
    let Figures { tally, judge } = runner.into_sink();
    let summary = tally.summary(facts, link, tally.covered_s(), 0.0);
    let error = result.err().map(|error| error.to_string());
    let success = &scenario.success;
    let assessment = assess(ending, error, success, Some(judge), &tally, &summary);
    let worse = |[a, b]: [f64; JOINTS]| a.max(b);
    let settling = tally.settling();
    let settled = match (settling.slowest_s, settling.unsettled_s) {
        (None, None) => None,
        (_, unsettled_s) => Some(unsettled_s.is_none()),
    };
    Ok(Some(RunFigures {
        settling_time_s: settling.slowest_s.filter(|_| settled == Some(true)),
        settled,
        rest_error_mrad: tally.worst_steady_error_rad().map(|rad| 1e3 * rad),
        tracking_rms_mrad: tally.tracking_rms_mrad().map(worse),
        peak_torque_nm: worse(summary.peak_torque_nm),
        fault: assessment.fault,
        missed_expectations: assessment.missed,
        ended: assessment.ended.filter(|_| !assessment.is_success),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Overrides;

    #[test]
    fn settling_ends_at_the_first_push() {
        let scenario = Scenario::load("push", &Overrides::default()).unwrap();
        // The first push is after 3 s.
        let figures = run(&scenario, None, || false).unwrap().unwrap();
        assert!(figures.settling_time_s.unwrap() < 1.0, "{figures:?}");
    }
}
