//! Queries of a runner, while it works and after.

use armbridge_client::LinkStats;
use armbridge_client::status::BoardStatus;
use armbridge_shared::link::message::{Mode, OffReport, Settings, Trip};

use super::plan::Act;
use super::{Ending, Phase, PlanRunner, RecordSink};

impl<K: RecordSink> PlanRunner<K> {
    /// How much of the run is over, 0 to 1.
    pub fn fraction(&self, now_us: u64) -> f64 {
        match &self.phase {
            Phase::Connecting
            | Phase::Learning
            | Phase::SettingUp
            | Phase::WaitingForServos
            | Phase::Arming => 0.0,
            Phase::Running(timeline) => {
                let elapsed_us = now_us.saturating_sub(timeline.since_us);
                (elapsed_us as f64 / self.plan.stop.after_us as f64).min(1.0)
            }
            Phase::SwitchingOff | Phase::Over => 1.0,
        }
    }

    /// Which step is being done, from 1; of how many; and what it is. `None` before the
    /// first and after the run.
    pub fn doing(&self, now_us: u64) -> Option<(usize, usize, &Act)> {
        let Phase::Running(timeline) = &self.phase else {
            return None;
        };
        let elapsed_us = now_us.saturating_sub(timeline.since_us);
        let steps = &self.plan.steps;
        let number = steps.partition_point(|step| step.at_us <= elapsed_us);
        let step = steps.get(number.checked_sub(1)?)?;
        Some((number, steps.len(), &step.act))
    }

    /// When the first command was due, in µs; `None` before and after the run.
    pub fn running_since_us(&self) -> Option<u64> {
        match &self.phase {
            Phase::Running(timeline) => Some(timeline.since_us),
            _ => None,
        }
    }

    /// When the run began, in µs, if it ever did.
    pub fn begun_us(&self) -> Option<u64> {
        self.begun_us
    }

    /// What ended the run; `None` if it has not, or was not by its plan.
    pub fn ending(&self) -> Option<Ending> {
        self.ending
    }

    /// What the board was doing last.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// Settings in force when the run began, if the board reported them.
    pub fn begun_with(&self) -> Option<&Settings> {
        self.begun_with.as_ref()
    }

    /// Settings as last reported by the board; `None` before the first report.
    pub fn settings(&self) -> Option<&Settings> {
        self.settings.as_ref().map(|[_, last]| last)
    }

    /// Status reports of the board.
    pub fn status(&self) -> &BoardStatus {
        self.session.status()
    }

    /// Why the board switched torque off, each time.
    pub fn trips(&self) -> &[Trip] {
        &self.trips
    }

    /// What the servos did after each of its stop sequences.
    pub fn off_reports(&self) -> &[OffReport] {
        &self.off_reports
    }

    /// What became of the link's frames.
    pub fn stats(&self) -> LinkStats {
        self.session.stats()
    }

    /// Who was handed what came.
    pub fn keep(&self) -> &K {
        &self.keep
    }

    /// The same, with nothing more to come.
    pub fn into_keep(self) -> K {
        self.keep
    }
}
