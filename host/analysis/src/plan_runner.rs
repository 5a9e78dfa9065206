//! Plan runner: a host that connects, sets up, arms, performs a [`Plan`] step by step,
//! switches off, and passes on every record.
//!
//! The runner is sans-io and has no clock: it works in virtual time and over a socket.
//!
//! Once the arm has been armed, every end of the run switches the motors off, and the
//! runner waits for the board's acknowledgement before it is done or fails. A broken link
//! or a reset of the board ends the run: the runner sends a hello again, so that the log
//! continues, and checks that torque is off. It never arms a second time by itself.

pub(crate) mod action_text;
mod ending;
mod error;
mod on_client;
mod on_message;
mod outcome;
pub mod plan;
mod queries;
mod record_sink;
mod timeline;

pub use error::PlanError;
pub use on_client::{PerformError, Performed, perform};
pub use outcome::Ending;
pub use plan::{Plan, Script};
pub use record_sink::{AllRecords, RecordSink};

use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, Sender, channel};

use armbridge_client::board_clock::ClockOffset;
use armbridge_client::error::SessionError;
use armbridge_client::session::{
    ANSWER_TIMEOUT_US, ARM_TIMEOUT_US, HELLO_TIMEOUT_US, PARK_TIMEOUT_US, Request,
    SERVO_TIMEOUT_US, Session,
};
use armbridge_client::{Host, LinkStats, enum_names};
use armbridge_link::message::{Command, Mode, OffReport, Record, Settings, Trip};
use armbridge_sim::cosim::Interaction;

use outcome::StopMonitor;
use plan::Action;
use timeline::{Due, Timeline};

/// Lag in µs of the board's clock that is no more than the delay of a record on the link.
const RECORD_DELAY_US: u64 = 20_000;

#[derive(Debug)]
enum Phase {
    Connecting,
    /// Waits for the board's settings.
    ReadingSettings,
    SettingUp,
    WaitingForServos,
    Arming,
    /// Waits until the board has checked the motors, if it does so.
    CheckingMotors,
    Running(Timeline),
    /// The board parks the arm.
    Parking,
    SwitchingOff,
    Over,
}

/// A host that performs a [`Plan`].
#[derive(Debug)]
pub struct PlanRunner<K = AllRecords> {
    session: Session,
    plan: Plan,
    phase: Phase,
    /// `None` before the first call in this phase.
    entered_us: Option<u64>,
    trips: Vec<Trip>,
    off_reports: Vec<OffReport>,
    /// Points of a stream that arrived too late.
    late_points: u64,
    stop_monitor: StopMonitor,
    clock_offset: ClockOffset,
    /// Commands still to be sent in this phase, in order.
    queue: VecDeque<Command>,
    /// As first and as last reported by the board.
    settings: Option<[Settings; 2]>,
    begun_with: Option<Settings>,
    /// Name of the last command.
    last_command: &'static str,
    /// Torque is on or may be, so an idle board is unexpected.
    is_armed: bool,
    /// Start of an unexpected idle mode.
    idle_since_us: Option<u64>,
    received_us: u64,
    begun_us: Option<u64>,
    /// Beginning of the run on the board's clock.
    board_begun_us: u64,
    /// Time by which the board's clock is behind since then: an emulated processor that gets too
    /// little of the host's time falls behind.
    lag_us: u64,
    mode: Mode,
    /// Pushes and leads the simulated arm.
    hands: Option<Sender<Interaction>>,
    ending: Option<Ending>,
    /// Error to return once the motors are off.
    error: Option<PlanError>,
    interrupt: fn() -> bool,
    sink: K,
}

impl PlanRunner {
    /// Runner that keeps everything in memory.
    pub fn new(plan: impl Into<Plan>) -> Self {
        Self::with_sink(plan, AllRecords::default())
    }

    /// The records so far.
    pub fn records(&self) -> &[Record] {
        &self.sink.records
    }

    /// Records, commands with their times in µs, and statistics of the link's frames.
    pub fn into_parts(self) -> (Vec<Record>, Vec<(u64, Command)>, LinkStats) {
        let stats = self.session.stats();
        (self.sink.records, self.sink.commands, stats)
    }
}

impl<K: RecordSink> PlanRunner<K> {
    /// Runner that passes its data to `sink`.
    pub fn with_sink(plan: impl Into<Plan>, sink: K) -> Self {
        Self {
            session: Session::default(),
            plan: plan.into(),
            phase: Phase::Connecting,
            entered_us: None,
            trips: Vec::new(),
            off_reports: Vec::new(),
            late_points: 0,
            stop_monitor: StopMonitor::default(),
            clock_offset: ClockOffset::default(),
            queue: VecDeque::new(),
            settings: None,
            begun_with: None,
            last_command: "idle",
            is_armed: false,
            idle_since_us: None,
            received_us: 0,
            begun_us: None,
            board_begun_us: 0,
            lag_us: 0,
            mode: Mode::Boot,
            hands: None,
            ending: None,
            error: None,
            interrupt: || false,
            sink,
        }
    }

    /// Adds an interrupt: the runner switches off and ends as soon as it is true.
    #[must_use]
    pub fn interrupted_by(mut self, interrupt: fn() -> bool) -> Self {
        self.interrupt = interrupt;
        self
    }

    /// Channel of the plan's pushes and hands, for a simulation of the arm. Without a receiver
    /// there are none, as on a real arm.
    pub fn interactions(&mut self) -> Receiver<Interaction> {
        let (hands, interactions) = channel();
        self.hands = Some(hands);
        interactions
    }

    fn command(&mut self, now_us: u64, command: Command) {
        self.last_command = enum_names::command(&command);
        self.sink.command(now_us, &command);
        self.session.request(now_us, Request::Command(command));
    }

    fn arm(&mut self, now_us: u64) {
        let report = self.session.status().report;
        let session = report.map_or(0, |report| report.session);
        let command = Command::Arm { session };
        self.last_command = enum_names::command(&command);
        self.sink.command(now_us, &command);
        self.session.request(now_us, Request::Arm);
    }

    fn run(&mut self, now_us: u64) {
        let over_us = self.over_us();
        let Phase::Running(timeline) = &mut self.phase else {
            return;
        };
        let since_us = timeline.since_us;
        let elapsed_us = now_us.saturating_sub(since_us);
        if elapsed_us >= over_us {
            self.end(now_us, Ending::Time);
        } else if now_us.saturating_sub(self.received_us) > ANSWER_TIMEOUT_US {
            self.give_up(now_us, SessionError::Silent.into());
        } else if self.session.is_settled() {
            match timeline.take(elapsed_us, &self.plan.steps) {
                None => {}
                Some(Due::Point(point, begun_us)) => {
                    let at_us = since_us + begun_us + point.after_us;
                    let command = Command::Stream {
                        at_us: self.clock_offset.board_us(at_us),
                        angle_rad: point.angle_rad,
                        speed_rad_s: point.speed_rad_s,
                    };
                    self.command(now_us, command);
                }
                Some(Due::Step(action)) => self.perform(now_us, action),
            }
        }
    }

    /// Time in µs since the beginning after which the run's time is over on the board's clock too.
    fn over_us(&self) -> u64 {
        let after_us = self.plan.stop.after_us;
        after_us.saturating_add(self.lag_us.min(after_us))
    }

    fn perform(&mut self, now_us: u64, action: Action) {
        match action {
            Action::Command(command)
                if *command == Command::Park && !self.session.status().has_pose() =>
            {
                self.give_up(now_us, PlanError::NoPose);
            }
            Action::Command(command) => {
                if matches!(*command, Command::Idle | Command::Park) {
                    self.is_armed = false;
                }
                self.command(now_us, *command);
            }
            Action::Arm => self.arm(now_us),
            Action::Change(change) => {
                let present = self
                    .settings
                    .map_or_else(Settings::default, |[_, last]| last);
                match change.apply(&present) {
                    Ok(settings) => self.command(now_us, Command::Configure(settings.setup)),
                    Err(error) => self.give_up(now_us, error.into()),
                }
            }
            // Its points fall due one by one.
            Action::Stream(_) => {}
        }
    }

    fn enter(&mut self, phase: Phase, now_us: u64) {
        self.phase = phase;
        self.entered_us = Some(now_us);
    }
}

impl<K: RecordSink> Host for PlanRunner<K> {
    type Error = PlanError;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], PlanError> {
        if (self.interrupt)() {
            self.interrupt(now_us);
        }
        let waited_us = now_us.saturating_sub(*self.entered_us.get_or_insert(now_us));
        match self.phase {
            Phase::Connecting if waited_us > HELLO_TIMEOUT_US => {
                let damaged = self.session.stats().damaged;
                return Err(SessionError::NoBoard { damaged }.into());
            }
            Phase::ReadingSettings | Phase::SettingUp | Phase::SwitchingOff
                if waited_us > ANSWER_TIMEOUT_US =>
            {
                let silent = || SessionError::Silent.into();
                return Err(self.error.take().unwrap_or_else(silent));
            }
            Phase::Arming if waited_us > ARM_TIMEOUT_US => {
                return Err(SessionError::Silent.into());
            }
            Phase::WaitingForServos if waited_us > SERVO_TIMEOUT_US => {
                return Err(PlanError::Servos(self.session.status().obstacle));
            }
            Phase::CheckingMotors if waited_us > SERVO_TIMEOUT_US => {
                self.give_up(now_us, SessionError::Silent.into());
            }
            Phase::Parking if waited_us > PARK_TIMEOUT_US => self.switch_off(now_us),
            Phase::Running(_) => self.run(now_us),
            Phase::Connecting
            | Phase::ReadingSettings
            | Phase::SettingUp
            | Phase::WaitingForServos
            | Phase::Arming
            | Phase::CheckingMotors
            | Phase::Parking
            | Phase::SwitchingOff
            | Phase::Over => {}
        }
        Ok(self.session.transmit(now_us)?)
    }

    fn wake_at_us(&self) -> u64 {
        let due_us = match &self.phase {
            Phase::Running(timeline) => {
                let over_us = self.over_us();
                let next_us = timeline.due_us(&self.plan.steps);
                // An unacknowledged command is waited for.
                let next_us = next_us.filter(|_| self.session.is_settled());
                timeline.since_us + next_us.map_or(over_us, |due_us| due_us.min(over_us))
            }
            Phase::Connecting
            | Phase::ReadingSettings
            | Phase::SettingUp
            | Phase::WaitingForServos
            | Phase::Arming
            | Phase::CheckingMotors
            | Phase::Parking
            | Phase::SwitchingOff
            | Phase::Over => u64::MAX,
        };
        due_us.min(self.session.wake_at_us())
    }

    fn receive(&mut self, now_us: u64, mut bytes: &[u8]) -> Result<(), PlanError> {
        loop {
            let reported = self.session.status().report;
            match self.session.receive(now_us, &mut bytes) {
                Ok(None) => return Ok(()),
                Ok(Some(message)) => self.on_message(now_us, &message, reported)?,
                Err(error) => self.fail(now_us, error.into())?,
            }
        }
    }

    fn is_done(&self) -> bool {
        matches!(self.phase, Phase::Over)
    }

    fn emergency_stop(&mut self, now_us: u64) -> bool {
        self.session.request(now_us, Request::Stop);
        true
    }

    fn disarm(&mut self, now_us: u64) -> bool {
        if !matches!(self.phase, Phase::SwitchingOff | Phase::Over) {
            self.error.get_or_insert(PlanError::Disarmed);
        }
        self.end_early(now_us);
        true
    }

    fn disconnected(&mut self, now_us: u64) {
        self.session.disconnected();
        match self.phase {
            Phase::Connecting
            | Phase::ReadingSettings
            | Phase::SettingUp
            | Phase::WaitingForServos
            | Phase::Arming => {
                self.is_armed = false;
                self.phase = Phase::Connecting;
            }
            Phase::CheckingMotors | Phase::Running(_) => {
                self.give_up(now_us, PlanError::Disconnected);
            }
            Phase::SwitchingOff => self.switch_off(now_us),
            Phase::Parking | Phase::Over => {}
        }
        // Timeouts exclude time without a link.
        self.entered_us = None;
    }
}
