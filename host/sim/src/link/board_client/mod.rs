//! Board client: a board that is commanded by calls which return when the board has acted.
//!
//! The link is served by a thread of its own, with heartbeats and the session's rules; a caller
//! may be slow or wait for something else without the board noticing. Each call that waits looks
//! every [`LOOK`] whether its caller is interrupted.
//!
//! | call           | returns                                                            |
//! |----------------|--------------------------------------------------------------------|
//! | [`open`](BoardClient::open) | when the board has reported its settings, and ticks or why not |
//! | [`command`](BoardClient::command) | when the board has accepted the command              |
//! | [`arm`](BoardClient::arm) | when the motors have been checked, after the preparation of stock servos |
//! | [`disarm`](BoardClient::disarm) | when the arm is parked, if it has a pose, and the motors are off |
//! | [`hold`](BoardClient::hold) | when the arm is held instead of driven by torques          |
//! | [`stop`](BoardClient::stop) | when the board reports its fault                           |

use std::time::{Duration, Instant};

use armbridge_client::params::settings_exchange;
use armbridge_client::session::{
    ANSWER_TIMEOUT_US, ARM_TIMEOUT_US, HELLO_TIMEOUT_US, PARK_TIMEOUT_US, Request, RequestError,
    SERVO_TIMEOUT_US, SessionEnded,
};
use armbridge_client::status::{BoardStatus, Obstacle};
use armbridge_client::telemetry::Telemetry;
use armbridge_client::{enum_names, fault_text, refusal_text};
use armbridge_link::message::{Command, Drive, Fault, Mode, Refusal, Settings, Trip};
use armbridge_link::server::LinkRole;
use armbridge_servo::JOINTS;

use super::{BoardUri, LinkThread, LinkThreadError, Options};

/// Period at which a call that waits looks whether its caller is interrupted.
const LOOK: Duration = Duration::from_millis(50);

/// Reason for which a call failed.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    /// The link could not be opened, or has ended.
    #[error(transparent)]
    Link(#[from] LinkThreadError),
    /// The link has ended before; the call that noticed it first has the reason.
    #[error("the link to the board has ended")]
    Ended,
    /// The board refuses a command.
    #[error("the board refuses to {}: {}", enum_names::command(command), refusal_text::in_words(*refusal))]
    Refused {
        /// The command.
        command: Box<Command>,
        /// The reason.
        refusal: Refusal,
    },
    /// The board refuses to arm.
    #[error("the board refuses to arm: {}", refusal_text::in_words(*.0))]
    NotArmed(Refusal),
    /// The board switched torque off.
    #[error("{}", fault(*.0, .1.as_ref()))]
    Fault(Fault, Option<Trip>),
    /// Another request overtook it, or the board was reset.
    #[error("{}", RequestError::Dropped)]
    Dropped,
    /// Something did not happen in time.
    #[error("{what} in {} s{}", waited.as_secs_f64(), obstacle.as_ref().map_or_else(String::new, |why| format!(": {why}")))]
    Timeout {
        /// As "the board did not answer".
        what: &'static str,
        /// Time for which it was waited.
        waited: Duration,
        /// What the board reports that it lacks.
        obstacle: Option<Obstacle>,
    },
    /// Another program commands the board; this one observes.
    #[error("{}", observes(*.0))]
    Observes(LinkRole),
    /// The caller is interrupted.
    #[error("interrupted")]
    Interrupted,
}

impl From<SessionEnded> for ClientError {
    fn from(_: SessionEnded) -> Self {
        Self::Ended
    }
}

fn fault(fault: Fault, trip: Option<&Trip>) -> String {
    match trip {
        Some(trip) => format!("torque is off: {}", fault_text::in_words(trip)),
        None => format!("torque is off by a fault: {}", fault.name()),
    }
}

fn observes(role: LinkRole) -> String {
    match role.commander {
        Some(program) => format!("{program} commands the board; this program observes"),
        None => "no program commands the board; this one observes".into(),
    }
}

/// A board, and the thread that serves its link. Dropping it ends the session, by which the arm is
/// parked or the board disarms.
pub struct BoardClient {
    thread: LinkThread,
    telemetry: Telemetry,
    is_interrupted: Box<dyn Fn() -> bool + Send + Sync>,
}

impl BoardClient {
    /// Opens a link with these options, and waits until the board has reported itself.
    ///
    /// # Errors
    /// If the link does not open, or the board does not answer.
    pub fn open(
        uri: BoardUri,
        options: impl FnOnce() -> Options + Send + 'static,
        is_interrupted: impl Fn() -> bool + Send + Sync + 'static,
    ) -> Result<Self, ClientError> {
        let telemetry = Telemetry::default();
        let tap = telemetry.tap();
        let thread = LinkThread::begin(uri, move || {
            let mut options = options();
            options.link.taps.push(tap);
            options
        })?;
        let client = Self {
            thread,
            telemetry,
            is_interrupted: Box::new(is_interrupted),
        };
        let is_known = |status: &BoardStatus| {
            let is_up = status.mode().is_some_and(|mode| mode != Mode::Boot);
            status.settings.is_some()
                && status.report.is_some()
                && (is_up || status.obstacle.is_some() || status.trip.is_some())
        };
        let timeout = Duration::from_micros(HELLO_TIMEOUT_US + SERVO_TIMEOUT_US);
        match client.wait_until(timeout, "the board did not answer", is_known) {
            Err(ClientError::Ended) => Err(client.end_error()),
            Err(error) => Err(error),
            Ok(()) => Ok(client),
        }
    }

    /// The board's status.
    pub fn status(&self) -> BoardStatus {
        self.thread.session().status()
    }

    /// Records of the ticks.
    pub fn telemetry(&self) -> &Telemetry {
        &self.telemetry
    }

    /// The thread that serves the link.
    pub fn thread(&self) -> &LinkThread {
        &self.thread
    }

    /// Has the board carry out a command.
    ///
    /// # Errors
    /// If it refuses, or does not answer.
    pub fn command(&self, command: Command) -> Result<(), ClientError> {
        self.ask(Request::Command(command), ANSWER_TIMEOUT_US)
    }

    /// Replaces the settings, limits first, and keeps them across power-off if `saves`.
    ///
    /// # Errors
    /// If the board refuses one: those before it are in force.
    pub fn set(&self, after: &Settings, saves: bool) -> Result<(), ClientError> {
        let before = self.status().settings.unwrap_or_default();
        for command in settings_exchange::commands(&before, after, saves) {
            self.command(command)?;
        }
        self.wait(
            ANSWER_TIMEOUT_US,
            "the settings were not reported",
            |status| status.settings == Some(*after),
        )
    }

    /// Arms the board; stock servos are prepared before. Returns when the motors have been
    /// checked, and may be driven.
    ///
    /// # Errors
    /// If the board refuses, or finds a fault meanwhile. It is disarmed then.
    pub fn arm(&self) -> Result<(), ClientError> {
        self.try_arm().inspect_err(|_| {
            // The first error is the one to be reported.
            let _ = self
                .thread
                .session()
                .request(Request::Command(Command::Idle));
        })
    }

    fn try_arm(&self) -> Result<(), ClientError> {
        if self.status().servos.is_some_and(|servos| !servos.is_ready) {
            self.command(Command::Prepare)?;
            let is_ready =
                |status: &BoardStatus| status.servos.is_some_and(|servos| servos.is_ready);
            self.wait(SERVO_TIMEOUT_US, "the servos were not ready", is_ready)?;
        }
        self.ask(Request::Arm, ARM_TIMEOUT_US)?;
        let is_armed = |status: &BoardStatus| {
            status
                .mode()
                .is_some_and(|mode| mode.is_armed() && mode != Mode::MotorCheck)
        };
        self.wait_without_fault(SERVO_TIMEOUT_US, "the motor check did not end", is_armed)
    }

    /// Parks the arm, if it has a pose and is driven, and disarms.
    ///
    /// # Errors
    /// If the board does not answer.
    pub fn disarm(&self) -> Result<(), ClientError> {
        self.command(Command::Park)?;
        let is_off = |status: &BoardStatus| status.mode().is_none_or(|mode| !mode.is_armed());
        self.wait(PARK_TIMEOUT_US, "the park did not end", is_off)
    }

    /// Ends the torque of a program: holds the arm where it is, or disarms if the board refuses.
    /// Returns when the ticks show that.
    ///
    /// # Errors
    /// If the board does not answer.
    pub fn hold(&self) -> Result<(), ClientError> {
        let record = self.status().record;
        let place = record.map_or([0.0; JOINTS], |record| record.output.angle_rad);
        self.command(Command::Regulate(place))
            .or_else(|_| self.disarm())?;
        let is_over =
            |status: &BoardStatus| status.mode().and_then(Mode::drive) != Some(Drive::Torque);
        self.wait(ANSWER_TIMEOUT_US, "the torque did not end", is_over)
    }

    /// Stops the board: torque off, until the fault is cleared.
    ///
    /// # Errors
    /// If it does not report that.
    pub fn stop(&self) -> Result<(), ClientError> {
        self.thread.session().request(Request::Stop)?;
        let is_stopped = |status: &BoardStatus| matches!(status.mode(), Some(Mode::Fault(_)));
        self.wait(ANSWER_TIMEOUT_US, "the stop was not reported", is_stopped)
    }

    /// Clears a fault, and waits until the servos have been found again.
    ///
    /// # Errors
    /// If the board refuses, or the servos do not answer.
    pub fn clear(&self) -> Result<(), ClientError> {
        self.command(Command::ClearFault)?;
        let is_idle = |status: &BoardStatus| status.mode() == Some(Mode::Idle);
        self.wait(SERVO_TIMEOUT_US, "the servos were not found", is_idle)
    }

    /// Waits until the status meets a condition.
    ///
    /// # Errors
    /// After the timeout, with `what` did not happen; if the link ends; if the caller is
    /// interrupted.
    pub fn wait_until(
        &self,
        timeout: Duration,
        what: &'static str,
        is_met: impl Fn(&BoardStatus) -> bool,
    ) -> Result<(), ClientError> {
        let begun = Instant::now();
        loop {
            let left = timeout.saturating_sub(begun.elapsed());
            if self.thread.session().wait_for(left.min(LOOK), &is_met) {
                return Ok(());
            }
            self.check()?;
            if left.is_zero() {
                return Err(ClientError::Timeout {
                    what,
                    waited: timeout,
                    obstacle: self.status().obstacle,
                });
            }
        }
    }

    /// The same, but a fault ends it.
    ///
    /// # Errors
    /// As [`wait_until`](Self::wait_until), and by a fault.
    pub fn wait_without_fault(
        &self,
        timeout_us: u64,
        what: &'static str,
        is_met: impl Fn(&BoardStatus) -> bool,
    ) -> Result<(), ClientError> {
        let is_fault = |status: &BoardStatus| matches!(status.mode(), Some(Mode::Fault(_)));
        self.wait(timeout_us, what, |status| {
            is_met(status) || is_fault(status)
        })?;
        let status = self.status();
        match status.mode() {
            Some(Mode::Fault(fault)) => Err(ClientError::Fault(fault, status.trip)),
            _ => Ok(()),
        }
    }

    /// Ends the session: parks the arm or disarms, and closes the link.
    ///
    /// # Errors
    /// If that takes too long.
    pub fn leave(&self) -> Result<(), ClientError> {
        Ok(self.thread.leave()?)
    }

    fn wait(
        &self,
        timeout_us: u64,
        what: &'static str,
        is_met: impl Fn(&BoardStatus) -> bool,
    ) -> Result<(), ClientError> {
        self.wait_until(Duration::from_micros(timeout_us), what, is_met)
    }

    fn ask(&self, request: Request, timeout_us: u64) -> Result<(), ClientError> {
        if let Some(role) = self.status().role.filter(|role| !role.is_commander) {
            return Err(ClientError::Observes(role));
        }
        let pending = self.thread.session().ask(request)?;
        let (begun, timeout) = (Instant::now(), Duration::from_micros(timeout_us));
        loop {
            let left = timeout.saturating_sub(begun.elapsed());
            match (pending.wait(left.min(LOOK)), request) {
                (Some(Ok(())), _) => return Ok(()),
                (Some(Err(RequestError::Dropped)), _) => {
                    self.check()?;
                    return Err(ClientError::Dropped);
                }
                (Some(Err(RequestError::Refused(refusal))), Request::Command(command)) => {
                    let command = Box::new(command);
                    return Err(ClientError::Refused { command, refusal });
                }
                (Some(Err(RequestError::Refused(refusal))), _) => {
                    return Err(ClientError::NotArmed(refusal));
                }
                (None, _) if left.is_zero() => {
                    return Err(ClientError::Timeout {
                        what: "the board did not answer",
                        waited: timeout,
                        obstacle: None,
                    });
                }
                (None, _) => self.check()?,
            }
        }
    }

    /// Looks whether a call has to give up.
    fn check(&self) -> Result<(), ClientError> {
        if (self.is_interrupted)() {
            return Err(ClientError::Interrupted);
        }
        if self.thread.is_over() {
            return Err(ClientError::Ended);
        }
        Ok(())
    }

    /// The reason for which the link has ended.
    fn end_error(self) -> ClientError {
        match self.thread.end() {
            Err(error) => error.into(),
            Ok(()) => ClientError::Ended,
        }
    }
}
