//! Reactions of the runner to messages of the board.

use armbridge_client::session::BoardMessage;
use armbridge_link::message::{
    BoardReport, Command, Drive, Mode, Record, Refusal, Settings, ToHost,
};
use armbridge_sim::cosim::Interaction;
use armbridge_sim::plant::{Lead, Push};

use super::plan::{self, InitialSettings};
use super::timeline::Timeline;
use super::{Phase, PlanError, PlanRunner, RECORD_DELAY_US, RecordSink};

/// Time in µs for which an armed board may report idle: records from before it was
/// armed may arrive after the acknowledgement.
const IDLE_US: u64 = 100_000;

impl<K: RecordSink> PlanRunner<K> {
    /// Processes a message; `reported` is the board's previous report.
    pub(super) fn on_message(
        &mut self,
        now_us: u64,
        message: &BoardMessage,
        reported: Option<BoardReport>,
    ) -> Result<(), PlanError> {
        self.received_us = now_us;
        self.store_fault_reports(message);
        if let (BoardMessage::Other(ToHost::Board(report)), Some(before)) = (message, reported)
            && before.is_before_reset(report)
        {
            return self.fail(now_us, PlanError::Reset(report.last_end));
        }
        match (message, &self.phase) {
            (BoardMessage::Hello(_), Phase::Connecting) => self.on_hello(now_us),
            (BoardMessage::Other(ToHost::Settings(settings)), _) => {
                self.on_settings(now_us, settings)?;
            }
            (BoardMessage::Other(ToHost::Record(record)), _) => self.on_record(now_us, record)?,
            (BoardMessage::Other(ToHost::Concluded(conclusion)), _) => {
                self.sink.concluded(conclusion);
            }
            (BoardMessage::Done, Phase::SettingUp) => self.continue_set_up(now_us),
            (BoardMessage::Done, Phase::Arming) => self.enter(Phase::CheckingMotors, now_us),
            (BoardMessage::Done, Phase::Running(_)) => self.on_command_done(),
            // Refusals at the end are ignored.
            (BoardMessage::Done | BoardMessage::Refused(_), Phase::SwitchingOff) => {
                return self.continue_switching_off(now_us);
            }
            // It searches for its servos again, or makes them ready again, because of the settings.
            (BoardMessage::Refused(Refusal::NotReady), Phase::Arming) => {
                self.enter(Phase::WaitingForServos, now_us);
            }
            (BoardMessage::Refused(refusal), Phase::Arming) => {
                return Err(refused("arm", *refusal));
            }
            (BoardMessage::Refused(refusal), Phase::SettingUp) => {
                return Err(refused("configure", *refusal));
            }
            // A fault came first: the records show it.
            (BoardMessage::Refused(Refusal::Faulted), Phase::Running(_))
            | (BoardMessage::Refused(_), Phase::Parking) => self.switch_off(now_us),
            // Too late for this point of a stream; the next may come in time.
            (BoardMessage::Refused(Refusal::Late { .. }), Phase::Running(_)) => {
                self.late_points += 1;
            }
            (BoardMessage::Refused(refusal), Phase::Running(_)) => {
                self.give_up(now_us, refused(self.last_command, *refusal));
            }
            (
                BoardMessage::Other(ToHost::Found {
                    is_ready: false, ..
                }),
                Phase::WaitingForServos,
            ) => self.command(now_us, Command::Prepare),
            // Takes the bus back from the transparent port.
            (BoardMessage::Other(ToHost::Passthrough), Phase::WaitingForServos) => {
                self.command(now_us, Command::Idle);
            }
            // No reaction.
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

    /// Stores the board's fault and stop reports.
    fn store_fault_reports(&mut self, message: &BoardMessage) {
        match *message {
            // Repeated after a hello.
            BoardMessage::Other(ToHost::Tripped(trip)) if self.trips.last() == Some(&trip) => {}
            BoardMessage::Other(ToHost::Tripped(trip)) => self.trips.push(trip),
            BoardMessage::Other(ToHost::Off(report)) => self.off_reports.push(report),
            _ => {}
        }
    }

    /// Ends the run, or fails, because the session with the board is lost.
    pub(super) fn fail(&mut self, now_us: u64, error: PlanError) -> Result<(), PlanError> {
        match (&self.phase, &error) {
            // The motors are off; wait until the records show it.
            (Phase::CheckingMotors | Phase::Running(_), PlanError::Reset(_)) => {
                self.give_up(now_us, error);
                Ok(())
            }
            (Phase::Parking | Phase::SwitchingOff, PlanError::Reset(_)) => Ok(()),
            _ => Err(self.error.take().unwrap_or(error)),
        }
    }

    fn on_hello(&mut self, now_us: u64) {
        self.queue.clear();
        if self.plan.is_clearing {
            self.queue.push_back(Command::ClearFault);
        }
        match &self.plan.begin {
            InitialSettings::Fixed(settings) => {
                self.queue.extend([
                    Command::Limit(settings.limits),
                    Command::Configure(settings.setup),
                ]);
                self.enter(Phase::SettingUp, now_us);
                self.continue_set_up(now_us);
            }
            InitialSettings::Changed(_) => self.enter(Phase::ReadingSettings, now_us),
        }
    }

    fn on_settings(&mut self, now_us: u64, settings: &Settings) -> Result<(), PlanError> {
        let [_, last] = self.settings.get_or_insert([*settings; 2]);
        *last = *settings;
        if let (InitialSettings::Changed(change), Phase::ReadingSettings) =
            (&self.plan.begin, &self.phase)
        {
            let target = change.apply(settings)?;
            if let Some(refusal) = armbridge_board::bridge::settings_refusal(&target) {
                return Err(PlanError::Settings(refusal));
            }
            self.queue.extend(plan::differences(settings, &target));
            self.enter(Phase::SettingUp, now_us);
            self.continue_set_up(now_us);
        }
        Ok(())
    }

    /// Sends the next command of the set-up, or waits for the servos.
    fn continue_set_up(&mut self, now_us: u64) {
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

    fn begin(&mut self, now_us: u64, record: &Record) {
        self.is_armed = true;
        self.begun_us.get_or_insert(now_us);
        self.board_begun_us = record.input.start_us;
        self.begun_with = self.settings.map(|[_, last]| last);
        if let Some(hands) = &self.hands {
            let now_ns = now_us * 1_000;
            let pushes = self.plan.pushes.iter().map(|push| {
                Interaction::Push(Push {
                    start_ns: push.start_ns + now_ns,
                    ..*push
                })
            });
            let leads = self.plan.leads.iter().map(|lead| {
                Interaction::Lead(Lead {
                    start_ns: lead.start_ns + now_ns,
                    ..lead.clone()
                })
            });
            for interaction in pushes.chain(leads) {
                // A simulation that has ended needs none.
                let _ = hands.send(interaction);
            }
        }
        self.enter(Phase::Running(Timeline::new(now_us)), now_us);
    }

    fn on_command_done(&mut self) {
        if self.last_command == "arm" {
            self.is_armed = true;
            self.idle_since_us = None;
        }
    }

    fn continue_switching_off(&mut self, now_us: u64) -> Result<(), PlanError> {
        if let Some(command) = self.queue.pop_front() {
            self.command(now_us, command);
            return Ok(());
        }
        self.enter(Phase::Over, now_us);
        self.error.take().map_or(Ok(()), Err)
    }

    fn on_record(&mut self, now_us: u64, record: &Record) -> Result<(), PlanError> {
        self.mode = record.mode;
        self.clock_offset.update(now_us, record.input.start_us);
        if let Phase::Running(timeline) = &self.phase {
            let board_us = record.input.start_us.saturating_sub(self.board_begun_us);
            let lag_us = now_us.saturating_sub(timeline.since_us + board_us);
            self.lag_us = if lag_us > RECORD_DELAY_US { lag_us } else { 0 };
        }
        if matches!(self.phase, Phase::CheckingMotors)
            && (record.mode == Mode::Armed || matches!(record.mode, Mode::Fault(_)))
        {
            self.begin(now_us, record);
        }
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
                self.sink.record(record);
                if let Some(ending) = self.stop_monitor.check(&self.plan.stop, record) {
                    self.end(now_us, ending);
                } else if self.is_armed && record.mode.drive() == Some(Drive::Park) {
                    self.is_armed = false;
                    self.error.get_or_insert(PlanError::Parked);
                    self.enter(Phase::Parking, now_us);
                } else if self.is_disarmed(now_us) {
                    self.give_up(now_us, PlanError::Disarmed);
                }
            }
            Phase::Parking => {
                self.sink.record(record);
                if record.mode.drive().is_none() {
                    self.switch_off(now_us);
                }
            }
            Phase::SwitchingOff => {
                self.sink.record(record);
                if let (None, None, Mode::Fault(fault)) = (self.ending, &self.error, record.mode) {
                    self.ending = Some(super::Ending::Fault(fault));
                }
            }
            Phase::Connecting
            | Phase::ReadingSettings
            | Phase::SettingUp
            | Phase::Arming
            | Phase::CheckingMotors
            | Phase::Over => {}
        }
        Ok(())
    }

    fn has_servos(&self) -> bool {
        let servos = self.session.status().servos;
        servos.is_some_and(|servos| servos.is_ready)
    }

    /// Whether torque is off without a command of this host or a fault.
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
