//! End of a run: the arm is parked or the motors are switched off, and the settings restored.

use armbridge_link::message::Command;

use super::plan::{self, InitialSettings};
use super::{Ending, Phase, PlanError, PlanRunner, RecordSink};

impl<K: RecordSink> PlanRunner<K> {
    /// Ends the run as planned, or by a fault.
    pub(super) fn end(&mut self, now_us: u64, ending: Ending) {
        self.ending.get_or_insert(ending);
        self.leave(now_us);
    }

    /// Has the arm parked before the motors are switched off, if it is driven and has a pose.
    fn leave(&mut self, now_us: u64) {
        let status = self.session.status();
        if status.has_pose() && status.is_driven() {
            self.is_armed = false;
            self.command(now_us, Command::Park);
            self.enter(Phase::Parking, now_us);
        } else {
            self.switch_off(now_us);
        }
    }

    /// Ends the run with an error, after parking the arm or switching the motors off.
    pub(super) fn give_up(&mut self, now_us: u64, error: PlanError) {
        self.error.get_or_insert(error);
        self.leave(now_us);
    }

    pub(super) fn switch_off(&mut self, now_us: u64) {
        self.is_armed = false;
        self.queue.clear();
        // Restores the settings that the run changed.
        if let (InitialSettings::Changed(_), Some([first, last])) =
            (&self.plan.begin, &self.settings)
        {
            self.queue.extend(plan::differences(last, first));
        }
        if self.plan.is_releasing {
            self.queue.push_back(Command::Release);
        }
        self.command(now_us, Command::Idle);
        self.enter(Phase::SwitchingOff, now_us);
    }

    /// Handles Ctrl-C: parks or switches off, or ends if nothing was changed yet.
    pub(super) fn interrupt(&mut self, now_us: u64) {
        self.ending.get_or_insert(Ending::Interrupted);
        self.end_early(now_us);
    }

    /// Ends the run before its plan does: the motors are switched off at once if it has failed.
    pub(super) fn end_early(&mut self, now_us: u64) {
        match self.phase {
            Phase::Connecting | Phase::ReadingSettings => self.enter(Phase::Over, now_us),
            Phase::SwitchingOff | Phase::Over => {}
            _ if self.error.is_some() => self.switch_off(now_us),
            Phase::Parking => {}
            Phase::SettingUp
            | Phase::WaitingForServos
            | Phase::Arming
            | Phase::CheckingMotors
            | Phase::Running(_) => self.leave(now_us),
        }
    }
}
