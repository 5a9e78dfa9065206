//! Queries of a runner, during and after its run.

use armbridge_client::LinkStats;
use armbridge_client::status::BoardStatus;
use armbridge_link::message::{Command, Mode, OffReport, Settings, Trip};

use super::plan::{Action, Step};
use super::{Ending, Phase, PlanRunner, RecordSink};

impl<K: RecordSink> PlanRunner<K> {
    /// Elapsed fraction of the run, 0 to 1.
    pub fn fraction(&self, now_us: u64) -> f64 {
        match &self.phase {
            Phase::Connecting
            | Phase::ReadingSettings
            | Phase::SettingUp
            | Phase::WaitingForServos
            | Phase::Arming
            | Phase::CheckingMotors => 0.0,
            Phase::Running(timeline) => {
                let elapsed_us = now_us.saturating_sub(timeline.since_us);
                (elapsed_us as f64 / self.plan.stop.after_us as f64).min(1.0)
            }
            Phase::Parking | Phase::SwitchingOff | Phase::Over => 1.0,
        }
    }

    /// Number of the current step from 1, number of steps, and action. `None` before the
    /// first step and after the run.
    pub fn current_step(&self, now_us: u64) -> Option<(usize, usize, &Action)> {
        let Phase::Running(timeline) = &self.phase else {
            return None;
        };
        let elapsed_us = now_us.saturating_sub(timeline.since_us);
        let steps = &self.plan.steps;
        let number = steps.partition_point(|step| step.at_us <= elapsed_us);
        let step = steps.get(number.checked_sub(1)?)?;
        Some((number, steps.len(), &step.action))
    }

    /// Whether the plan lets the arm float.
    pub fn floats(&self) -> bool {
        let is_float = |step: &Step| match &step.action {
            Action::Command(command) => **command == Command::Float,
            Action::Arm | Action::Change(_) | Action::Stream(_) => false,
        };
        self.plan.steps.iter().any(is_float)
    }

    /// Time of the first command in µs; `None` before and after the run.
    pub fn running_since_us(&self) -> Option<u64> {
        match &self.phase {
            Phase::Running(timeline) => Some(timeline.since_us),
            _ => None,
        }
    }

    /// Time at which the run began in µs, if it began.
    pub fn begun_us(&self) -> Option<u64> {
        self.begun_us
    }

    /// Cause of the end of the run; `None` if it has not ended, or ended with an error.
    pub fn ending(&self) -> Option<Ending> {
        self.ending
    }

    /// Last mode of the board.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// Settings in force when the run began, if the board reported them.
    pub fn begun_with(&self) -> Option<&Settings> {
        self.begun_with.as_ref()
    }

    /// Last settings reported by the board; `None` before the first report.
    pub fn settings(&self) -> Option<&Settings> {
        self.settings.as_ref().map(|[_, last]| last)
    }

    /// Status reports of the board.
    pub fn status(&self) -> &BoardStatus {
        self.session.status()
    }

    /// Reports of the board's faults that switched torque off.
    pub fn trips(&self) -> &[Trip] {
        &self.trips
    }

    /// Reports on the servos after each of the board's stop sequences.
    pub fn off_reports(&self) -> &[OffReport] {
        &self.off_reports
    }

    /// Statistics of the link's frames.
    pub fn stats(&self) -> LinkStats {
        self.session.stats()
    }

    /// The sink.
    pub fn sink(&self) -> &K {
        &self.sink
    }

    /// Mutable access to the sink.
    pub fn sink_mut(&mut self) -> &mut K {
        &mut self.sink
    }

    /// The sink, by value.
    pub fn into_sink(self) -> K {
        self.sink
    }
}
