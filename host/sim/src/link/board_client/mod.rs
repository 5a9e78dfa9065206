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
//! | [`disarm`](BoardClient::disarm), [`park`](BoardClient::park) | when the motors are off |
//! | [`take`](BoardClient::take) | when so many ticks have come                                 |
//! | [`wait_for`](BoardClient::wait_for) | when a motion has arrived                            |
//! | [`experiment`](BoardClient::experiment) | when the experiment has ended                 |
//! | [`hold`](BoardClient::hold) | when the arm is held instead of driven by torques          |
//! | [`stop`](BoardClient::stop) | when the board reports its fault                           |

mod command_sender;
mod error;
mod experiment;
mod motion;
mod setpoint_sender;

pub use command_sender::CommandSender;
pub use error::ClientError;
pub use motion::ActiveMotion;
pub use setpoint_sender::SetpointSender;

use std::time::{Duration, Instant};

use armbridge_client::params::settings_exchange;
use armbridge_client::session::{
    ANSWER_TIMEOUT_US, ARM_TIMEOUT_US, HELLO_TIMEOUT_US, PARK_TIMEOUT_US, Request, SERVO_TIMEOUT_US,
};
use armbridge_client::status::BoardStatus;
use armbridge_client::telemetry::Telemetry;
use armbridge_link::message::{Command, Drive, Mode, Record, Refusal, Settings};
use armbridge_link::server::Touch;
use armbridge_servo::JOINTS;

use super::{BoardUri, LinkThread, Options};

/// Period at which a call that waits looks whether its caller is interrupted.
const LOOK: Duration = Duration::from_millis(50);
/// Interval at which a command is repeated until the board can carry it out.
const AGAIN: Duration = Duration::from_millis(20);
/// Ticks after which a motion or an experiment that was accepted is followed: it is planned
/// meanwhile.
const PLANNED_TICKS: i32 = 10;
/// Timeouts of the session.
const HELLO: Duration = Duration::from_micros(HELLO_TIMEOUT_US);
const SERVOS: Duration = Duration::from_micros(SERVO_TIMEOUT_US);
const ANSWER: Duration = Duration::from_micros(ANSWER_TIMEOUT_US);
const ARM: Duration = Duration::from_micros(ARM_TIMEOUT_US);
const PARK: Duration = Duration::from_micros(PARK_TIMEOUT_US);

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
        client.wait(
            HELLO.saturating_add(SERVOS),
            "the board did not answer",
            is_known,
        )?;
        Ok(client)
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
        self.ask(Request::Command(command), ANSWER)
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
        self.wait(ANSWER, "the settings were not reported", |status| {
            status.settings == Some(*after)
        })
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
            self.wait(SERVOS, "the servos were not ready", is_ready)?;
        }
        self.ask(Request::Arm, ARM)?;
        let is_armed = |status: &BoardStatus| {
            status
                .mode()
                .is_some_and(|mode| mode.is_armed() && mode != Mode::MotorCheck)
        };
        self.wait_without_fault(SERVOS, "the motor check did not end", is_armed)
    }

    /// Disarms: torque is off at once.
    ///
    /// # Errors
    /// If the board does not answer.
    pub fn disarm(&self) -> Result<(), ClientError> {
        self.end_drive(Command::Idle)
    }

    /// Parks the arm, and disarms: without a pose, or where nothing drives the arm, at once.
    ///
    /// # Errors
    /// If the board does not answer.
    pub fn park(&self) -> Result<(), ClientError> {
        self.end_drive(Command::Park)
    }

    fn end_drive(&self, command: Command) -> Result<(), ClientError> {
        if !self.is_armed() {
            return Ok(());
        }
        self.command(command)?;
        let is_off = |status: &BoardStatus| status.mode().is_none_or(|mode| !mode.is_armed());
        self.wait(PARK, "the motors were not off", is_off)
    }

    /// Whether a motor may be driven.
    pub fn is_armed(&self) -> bool {
        self.status().mode().is_some_and(Mode::is_armed)
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
        self.wait(ANSWER, "the torque did not end", is_over)
    }

    /// Stops the board: torque off, until the fault is cleared.
    ///
    /// # Errors
    /// If it does not report that.
    pub fn stop(&self) -> Result<(), ClientError> {
        self.thread.session().request(Request::Stop)?;
        let is_stopped = |status: &BoardStatus| matches!(status.mode(), Some(Mode::Fault(_)));
        self.wait(ANSWER, "the stop was not reported", is_stopped)
    }

    /// Clears a fault, and waits until the servos have been found again.
    ///
    /// # Errors
    /// If the board refuses, or the servos do not answer.
    pub fn clear(&self) -> Result<(), ClientError> {
        let cleared = self.poll(ANSWER, "the motors were not seen to be off", |slice| {
            match self.command(Command::ClearFault) {
                // After a stop that takes 0.3 s at most.
                Err(ClientError::Refused {
                    refusal: Refusal::NotOff,
                    ..
                }) => {
                    std::thread::sleep(slice.min(AGAIN));
                    None
                }
                result => Some(result),
            }
        })?;
        cleared?;
        let is_idle = |status: &BoardStatus| status.mode() == Some(Mode::Idle);
        self.wait(SERVOS, "the servos were not found", is_idle)
    }

    /// Pushes a joint of a simulated arm, counting from 1, with this torque in N m.
    ///
    /// # Errors
    /// If there is no such joint, or more than a push may have.
    pub fn push(&self, joint: u8, torque_nm: f32, duration: Duration) -> Result<(), ClientError> {
        let push = Touch::Push {
            joint: joint.wrapping_sub(1),
            torque_nm,
            duration_us: u32::try_from(duration.as_micros()).unwrap_or(u32::MAX),
        };
        push.check().map_err(|_| ClientError::Push)?;
        self.thread.touch(push);
        Ok(())
    }

    /// Waits until the status meets a condition; after the timeout, `what` is the error.
    ///
    /// # Errors
    /// After the timeout, if the link ends, and if the caller is interrupted.
    pub fn wait(
        &self,
        timeout: Duration,
        what: &'static str,
        is_met: impl Fn(&BoardStatus) -> bool,
    ) -> Result<(), ClientError> {
        let session = self.thread.session();
        self.poll(timeout, what, |slice| {
            session.wait_for(slice, &is_met).then_some(())
        })
    }

    /// Waits for this many records, and takes them, oldest first.
    ///
    /// # Errors
    /// After the timeout, if the link ends, and if the caller is interrupted: the records wait.
    pub fn take(&self, count: usize, timeout: Duration) -> Result<Vec<Vec<Record>>, ClientError> {
        self.poll(timeout, "too few ticks came", |slice| {
            self.telemetry.take(count, slice)
        })
    }

    /// Waits likewise, but a fault is an error, too.
    ///
    /// # Errors
    /// As [`Self::wait`], and after a fault.
    pub fn wait_without_fault(
        &self,
        timeout: Duration,
        what: &'static str,
        is_met: impl Fn(&BoardStatus) -> bool,
    ) -> Result<(), ClientError> {
        let is_fault = |status: &BoardStatus| matches!(status.mode(), Some(Mode::Fault(_)));
        self.wait(timeout, what, |status| is_met(status) || is_fault(status))?;
        let status = self.status();
        match status.mode() {
            Some(Mode::Fault(fault)) => Err(ClientError::Fault(fault, status.trip)),
            _ => Ok(()),
        }
    }

    /// Ends the session: parks the arm or disarms, and closes the link.
    ///
    /// # Errors
    /// If that takes too long, or the link ended by itself.
    pub fn close(&self) -> Result<(), ClientError> {
        Ok(self.thread.end()?)
    }

    fn ask(&self, request: Request, timeout: Duration) -> Result<(), ClientError> {
        if let Some(role) = self.status().role.filter(|role| !role.is_commander) {
            return Err(ClientError::Observes(role));
        }
        let pending = self.thread.session().ask(request)?;
        let answer = self.poll(timeout, "the board did not answer", |slice| {
            pending.wait(slice)
        })?;
        answer.map_err(|error| {
            // A link that has ended is the reason.
            let ended = self.check().err();
            ended.unwrap_or_else(|| ClientError::of_request(request, error))
        })
    }

    /// Attempts something, a slice of time each, until it succeeds.
    fn poll<T>(
        &self,
        timeout: Duration,
        what: &'static str,
        attempt: impl Fn(Duration) -> Option<T>,
    ) -> Result<T, ClientError> {
        let begun = Instant::now();
        loop {
            let left = timeout.saturating_sub(begun.elapsed());
            if let Some(result) = attempt(left.min(LOOK)) {
                return Ok(result);
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

    /// Looks whether a call has to give up.
    fn check(&self) -> Result<(), ClientError> {
        if (self.is_interrupted)() {
            return Err(ClientError::Interrupted);
        }
        if self.thread.is_over() {
            self.thread.end()?;
            return Err(ClientError::Ended);
        }
        Ok(())
    }
}
