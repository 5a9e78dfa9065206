//! The control loop of the recorded board, between two of its ticks.

use armbridge_board::bridge::command::{ValidatedCommand, validate};
use armbridge_board::checkpoints::Checkpoints;
use armbridge_board::tick::limits::MOTION;
use armbridge_board::tick::reference::{StartPoint, TimedTrajectory, refusal};
use armbridge_board::tick::{ControlLoop, DriveRequest, Instant, LoopConfig, step};
use armbridge_control::trajectory::Trajectory;
use armbridge_link::message::{Command, Mode, Moment, Refusal, Settings};
use armbridge_link::motion::Motion;
use armbridge_link::record::{TickInput, TickOutput};
use armbridge_servo::Pwm;

/// Control loop and configuration.
#[derive(Clone)]
pub(super) struct Board {
    control_loop: ControlLoop,
    config: LoopConfig,
}

impl Board {
    /// A board just started with these settings.
    ///
    /// # Errors
    /// A [`Refusal`] if no controller exists for the set-up.
    pub(super) fn new(settings: &Settings) -> Result<Self, Refusal> {
        let config = LoopConfig::build(settings)?;
        Ok(Self {
            control_loop: ControlLoop::new(&config),
            config,
        })
    }

    /// A board in this state, with these settings.
    ///
    /// # Errors
    /// A [`Refusal`] if no controller exists for the set-up.
    pub(super) fn resume(control_loop: ControlLoop, settings: &Settings) -> Result<Self, Refusal> {
        Ok(Self {
            control_loop,
            config: LoopConfig::build(settings)?,
        })
    }

    /// Its control loop.
    pub(super) fn control_loop(&self) -> &ControlLoop {
        &self.control_loop
    }

    /// A hello, received in this mode. The loop goes on while the arm is parked.
    pub(super) fn begin_session(&mut self, mode: Mode) {
        match mode {
            Mode::Running(_) | Mode::Degraded(_) => {}
            Mode::Fault(_) => self.control_loop.reset_estimate(),
            _ => self.control_loop.restart(),
        }
    }

    /// The start point of a motion that is commanded at this moment.
    pub(super) fn start_point(&self, moment: Moment, acts_us: u64) -> StartPoint {
        self.control_loop.start_point(instant(moment, acts_us))
    }

    /// Plans the motion from there, and begins to follow it.
    ///
    /// # Errors
    /// The board's [`Refusal`].
    pub(super) fn follow(
        &mut self,
        motion: &Motion,
        start: StartPoint,
        moment: Moment,
        acts_us: u64,
    ) -> Result<(), Refusal> {
        let trajectory = Trajectory::plan(start.from, &motion.shape(), &MOTION)
            .map_err(|error| refusal(&error))?;
        let motion = TimedTrajectory {
            trajectory,
            starts_us: start.at_us,
        };
        let request = DriveRequest::Follow(motion);
        self.control_loop
            .request(&self.config, &request, instant(moment, acts_us))
    }

    /// Takes any other command that the board has accepted, or refused because of the loop's
    /// state.
    ///
    /// # Errors
    /// The board's [`Refusal`].
    pub(super) fn command(
        &mut self,
        command: Command,
        moment: Moment,
        acts_us: u64,
    ) -> Result<(), Refusal> {
        let now = instant(moment, acts_us);
        // The session has been checked.
        let session = match command {
            Command::Arm { session } => session,
            _ => 0,
        };
        match validate(command, session, self.config.joints(), None)? {
            ValidatedCommand::Arm => {
                if moment.mode == Mode::Idle {
                    self.control_loop.energise();
                }
                Ok(())
            }
            ValidatedCommand::Drive(request) => {
                self.control_loop.request(&self.config, &request, now)
            }
            ValidatedCommand::Install(control) => {
                let config = self.config.with_control(&control);
                self.control_loop
                    .install(&self.config, &config, now.is_driven, acts_us);
                self.config = config;
                Ok(())
            }
            ValidatedCommand::Limit(limits) => {
                self.config = self.config.with_limits(limits);
                self.control_loop.restart_monitors();
                Ok(())
            }
            ValidatedCommand::Idle
            | ValidatedCommand::Park
            | ValidatedCommand::StartPoint
            | ValidatedCommand::Prepare
            | ValidatedCommand::Release
            | ValidatedCommand::ClearFault
            | ValidatedCommand::Save => Ok(()),
        }
    }

    /// Computes the outputs of a tick.
    pub(super) fn step(&mut self, input: &TickInput) -> TickOutput {
        let checkpoints = &mut Checkpoints::default();
        step(&self.config, &mut self.control_loop, input, checkpoints)
    }

    /// PWM that it has decided in the last tick.
    pub(super) fn pwm(&self) -> [u16; 2] {
        self.control_loop.pwm().map(Pwm::counts)
    }
}

fn instant(moment: Moment, acts_us: u64) -> Instant {
    Instant {
        us: moment.at_us,
        acts_us,
        is_driven: moment.mode.drive().is_some(),
    }
}
