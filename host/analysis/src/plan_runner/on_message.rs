//! Messages of the board: what each does to the run.

use armbridge_client::session::BoardMessage;
use armbridge_shared::link::message::{
    BoardReport, Command, Mode, Record, Refusal, Settings, ToHost,
};
use armbridge_sim::cosim::Interaction;
use armbridge_sim::plant::Push;

use super::PlanError;
use super::plan::{self, Begin};
use super::timeline::Timeline;
use super::{Phase, PlanRunner, RecordSink};

/// For how long an armed board may say that it is idle: what it recorded before it was
/// armed may arrive after its word that it is.
const IDLE_US: u64 = 100_000;

impl<K: RecordSink> PlanRunner<K> {
    /// Takes a message; before it, this was the board's report.
    pub(super) fn take(
        &mut self,
        now_us: u64,
        message: BoardMessage,
        reported: Option<BoardReport>,
    ) -> Result<(), PlanError> {
        self.received_us = now_us;
        self.note(&message);
        if let (BoardMessage::Other(ToHost::Board(report)), Some(before)) = (message, reported)
            && before.is_before_reset(&report)
        {
            return self.despair(now_us, PlanError::Reset(report.last_end));
        }
        match (message, &self.phase) {
            (BoardMessage::Hello(_), Phase::Connecting) => self.greeted(now_us),
            (BoardMessage::Other(ToHost::Settings(settings)), _) => {
                self.take_settings(now_us, settings)?;
            }
            (BoardMessage::Other(ToHost::Record(record)), _) => self.recorded(now_us, &record)?,
            (BoardMessage::Other(ToHost::Concluded(conclusion)), _) => {
                self.keep.concluded(&conclusion);
            }
            (BoardMessage::Done, Phase::SettingUp) => self.set_up(now_us),
            (BoardMessage::Done, Phase::Arming) => self.begin(now_us),
            (BoardMessage::Done, Phase::Running(_)) => self.acted(),
            // The one is done with, and whatever is refused at the end is left.
            (BoardMessage::Done | BoardMessage::Refused(_), Phase::SwitchingOff) => {
                return self.switched_off(now_us);
            }
            (BoardMessage::Refused(refusal), Phase::Arming) => {
                return Err(refused("arm", refusal));
            }
            (BoardMessage::Refused(refusal), Phase::SettingUp) => {
                return Err(refused("configure", refusal));
            }
            // A fault came first: the records show it.
            (BoardMessage::Refused(Refusal::Faulted), Phase::Running(_)) => self.switch_off(now_us),
            // Too late for this point of a stream; the next may come in time.
            (BoardMessage::Refused(Refusal::Late), Phase::Running(_)) => self.late_points += 1,
            (BoardMessage::Refused(refusal), Phase::Running(_)) => {
                self.give_up(now_us, refused(self.last_command, refusal));
            }
            (
                BoardMessage::Other(ToHost::Found {
                    is_ready: false, ..
                }),
                Phase::WaitingForServos,
            ) => self.command(now_us, Command::Prepare),
            // Back from the host that has the bus.
            (BoardMessage::Other(ToHost::Passthrough), Phase::WaitingForServos) => {
                self.command(now_us, Command::Idle);
            }
            // News, or nothing to do now.
            (
                BoardMessage::Hello(_)
                | BoardMessage::OtherSchema(_)
                | BoardMessage::Done
                | BoardMessage::Refused(_)
                | BoardMessage::Other(_),
                _,
            ) => {}
        }
        Ok(())
    }

    /// Keeps what the board reports of its faults.
    fn note(&mut self, message: &BoardMessage) {
        match *message {
            // Repeated after a hello.
            BoardMessage::Other(ToHost::Tripped(trip)) if self.trips.last() == Some(&trip) => {}
            BoardMessage::Other(ToHost::Tripped(trip)) => self.trips.push(trip),
            BoardMessage::Other(ToHost::Off(report)) => self.off_reports.push(report),
            _ => {}
        }
    }

    /// The board cannot be worked with any more.
    pub(super) fn despair(&mut self, now_us: u64, error: PlanError) -> Result<(), PlanError> {
        match (&self.phase, &error) {
            // Its motors are off; let its record show that.
            (Phase::Running(_), PlanError::Reset(_)) => {
                self.give_up(now_us, error);
                Ok(())
            }
            (Phase::SwitchingOff, PlanError::Reset(_)) => Ok(()),
            _ => Err(self.trouble.take().unwrap_or(error)),
        }
    }

    fn greeted(&mut self, now_us: u64) {
        self.queue.clear();
        if self.plan.is_clearing {
            self.queue.push_back(Command::ClearFault);
        }
        match &self.plan.begin {
            Begin::With(setup) => {
                self.queue.push_back(Command::Configure(**setup));
                self.enter(Phase::SettingUp, now_us);
                self.set_up(now_us);
            }
            Begin::Changed(_) => self.enter(Phase::Learning, now_us),
        }
    }

    fn take_settings(&mut self, now_us: u64, settings: Settings) -> Result<(), PlanError> {
        let [_, last] = self.settings.get_or_insert([settings; 2]);
        *last = settings;
        if let (Begin::Changed(change), Phase::Learning) = (&self.plan.begin, &self.phase) {
            let wanted = change.apply(&settings)?;
            if let Some(refusal) = armbridge_shared::bridge::why_not(&wanted) {
                return Err(PlanError::Settings(refusal));
            }
            self.queue.extend(plan::differences(&settings, &wanted));
            self.enter(Phase::SettingUp, now_us);
            self.set_up(now_us);
        }
        Ok(())
    }

    /// The next of what there is to set up.
    fn set_up(&mut self, now_us: u64) {
        if let Some(command) = self.queue.pop_front() {
            self.command(now_us, command);
            return;
        }
        self.enter(Phase::WaitingForServos, now_us);
        let servos = self.session.status().servos;
        if servos.is_some_and(|servos| !servos.is_ready) {
            self.command(now_us, Command::Prepare);
        }
    }

    fn begin(&mut self, now_us: u64) {
        self.is_armed = true;
        self.begun_us.get_or_insert(now_us);
        self.begun_with = self.settings.map(|[_, last]| last);
        for push in &self.plan.pushes {
            if let Some(pushes) = &self.pushes {
                let start_ns = push.start_ns + now_us * 1_000;
                // A simulation that has ended needs no pushes.
                let _ = pushes.send(Interaction::Push(Push { start_ns, ..*push }));
            }
        }
        self.enter(Phase::Running(Timeline::new(now_us)), now_us);
    }

    fn acted(&mut self) {
        if self.last_command == "arm" {
            self.is_armed = true;
            self.idle_since_us = None;
        }
    }

    fn switched_off(&mut self, now_us: u64) -> Result<(), PlanError> {
        if let Some(command) = self.queue.pop_front() {
            self.command(now_us, command);
            return Ok(());
        }
        self.enter(Phase::Over, now_us);
        self.trouble.take().map_or(Ok(()), Err)
    }

    fn recorded(&mut self, now_us: u64, record: &Record) -> Result<(), PlanError> {
        self.mode = record.mode;
        self.offset.see(now_us, record.start_us);
        match self.phase {
            Phase::WaitingForServos if record.mode == Mode::Idle && self.has_servos() => {
                self.enter(Phase::Arming, now_us);
                self.arm(now_us);
            }
            Phase::WaitingForServos => {
                if let Mode::Fault(fault) = record.mode {
                    return Err(PlanError::Latched(fault));
                }
            }
            Phase::Running(_) => {
                self.keep.record(record);
                if let Some(ending) = self.watch.see(&self.plan.stop, record) {
                    self.end(now_us, ending);
                } else if self.is_disarmed(now_us) {
                    self.give_up(now_us, PlanError::Disarmed);
                }
            }
            Phase::SwitchingOff => {
                self.keep.record(record);
                if let (None, None, Mode::Fault(fault)) = (self.ending, &self.trouble, record.mode)
                {
                    self.ending = Some(super::Ending::Fault(fault));
                }
            }
            Phase::Connecting
            | Phase::Learning
            | Phase::SettingUp
            | Phase::Arming
            | Phase::Over => {}
        }
        Ok(())
    }

    fn has_servos(&self) -> bool {
        let servos = self.session.status().servos;
        servos.is_some_and(|servos| servos.is_ready)
    }

    /// Whether torque is off for no reason that this host knows.
    fn is_disarmed(&mut self, now_us: u64) -> bool {
        if !(self.is_armed && matches!(self.mode, Mode::Boot | Mode::Idle | Mode::Passthrough)) {
            self.idle_since_us = None;
            return false;
        }
        let since_us = *self.idle_since_us.get_or_insert(now_us);
        now_us.saturating_sub(since_us) > IDLE_US
    }
}

fn refused(command: &'static str, refusal: Refusal) -> PlanError {
    PlanError::Refused { command, refusal }
}
