//! Control loop: the state from one tick to the next, and the requests that change it between
//! two ticks.
//!
//! A request replaces reference source, torque or experiment at once; its first effect is
//! the command of the next tick. Motions, streamed points and experiments are admitted
//! from where the present source ends, so that the reference is continuous.
//!
//! # Bumpless transfer
//!
//! A set-up may be replaced while torque is on. The new estimator starts from the
//! state of the old one, and the difference in torque is added as an offset that
//! fades out, so that the servos see no step. The same holds for the change from a
//! constant torque to a reference. A setpoint elsewhere, and holding an arm
//! whose motors were off, are steps by command.

use super::actuator_command::ActuatorCommand;
use super::config::LoopConfig;
use super::drive_command::{DriveCommand, DriveRequest};
use super::drive_source::DriveSource;
use super::estimation::Estimation;
use super::experiment::{self, ActiveExperiment};
use super::monitors::Monitors;
use super::motor_check::MotorCheck;
use super::reference::{LEAD_US, ReferenceSource, StartPoint, TimedTrajectory};
use super::status::Instant;
use super::torque_control::TorqueControl;
use armbridge_control::arm::State;
use armbridge_control::controller::float;
use armbridge_control::trajectory::Reference;
use armbridge_control::trajectory::stream::Point;
use armbridge_link::experiment::Experiment;
use armbridge_link::message::{Drive, Refusal};
use armbridge_servo::{JOINTS, Pwm};
use nalgebra::Vector2;

/// The state of the control loop, see the [module](super). It has none of the numbers of the
/// configuration.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct ControlLoop {
    pub(super) estimation: Estimation,
    pub(super) monitors: Monitors,
    pub(super) motor_check: MotorCheck,
    pub(super) source: DriveSource,
    pub(super) control: TorqueControl,
    /// Estimate, reference and command of the last tick.
    pub(super) state: State<f32>,
    pub(super) reference: Reference<f32>,
    pub(super) command: ActuatorCommand,
}

impl ControlLoop {
    /// A loop without an estimate of the arm.
    pub fn new(config: &LoopConfig) -> Self {
        let upright = Vector2::zeros();
        Self {
            estimation: Estimation::new(&config.control),
            monitors: Monitors::default(),
            motor_check: MotorCheck::default(),
            source: DriveSource::new(),
            control: TorqueControl::new(),
            state: State::at_rest(upright),
            reference: Reference::at_rest(upright),
            command: ActuatorCommand::OFF,
        }
    }

    /// PWM decided in the last tick.
    pub fn pwm(&self) -> [Pwm; JOINTS] {
        self.command.pwm
    }

    /// Source that drives the motors while that is permitted.
    pub fn drive(&self) -> Drive {
        self.source.drive()
    }

    /// Consecutive missing samples of this joint.
    pub fn lost_in_row(&self, joint: usize) -> u32 {
        self.monitors.lost_in_row(joint)
    }

    /// Reason against arming: an encoder whose noise is not known yet, above all one without
    /// samples, or a joint beyond its angle limit.
    pub fn encoder_refusal(&self, config: &LoopConfig) -> Option<Refusal> {
        let unknown = self.monitors.unknown_encoder(config.joints());
        let unknown = unknown.map(|joint| Refusal::EncoderUnknown { joint });
        unknown.or_else(|| {
            let beyond = config.monitors.beyond_limit(self.state.q.into());
            beyond.map(|joint| Refusal::BeyondLimit { joint })
        })
    }

    /// Whether the last check of the motors, which has passed, need not be repeated.
    pub fn is_motor_check_conclusive(&self, config: &LoopConfig) -> bool {
        self.motor_check.is_conclusive(config.joints())
    }

    /// Before motors may be driven: clears the command, begins the motor check anew, and restarts
    /// monitors and estimate.
    pub fn energise(&mut self) {
        self.motor_check = MotorCheck::default();
        self.end_motor_check();
    }

    /// The same after the motor check, whose result stays.
    pub(super) fn end_motor_check(&mut self) {
        self.source.clear();
        self.restart_monitors();
        self.reset_estimate();
    }

    /// Restarts with the next tick: monitors, the knowledge of the encoders' noise, estimate and
    /// reference.
    pub fn restart(&mut self) {
        self.monitors = Monitors::default();
        self.reset_estimate();
    }

    /// Resets the estimator, which restarts from the next samples, and the reference: the
    /// arm may be anywhere.
    pub fn reset_estimate(&mut self) {
        self.estimation.reset();
        self.source.reference = ReferenceSource::hold(Vector2::zeros());
    }

    /// Restarts the monitors, except that the encoders' noise stays known.
    pub fn restart_monitors(&mut self) {
        self.monitors = self.monitors.restarted();
    }

    /// Installs another configuration, without a step in the torque if motors are
    /// driven; the next command acts at `acts_us`.
    pub fn install(
        &mut self,
        before: &LoopConfig,
        config: &LoopConfig,
        is_driven: bool,
        acts_us: u64,
    ) {
        if is_driven {
            let reference = self.source.reference.at(acts_us);
            let torque_nm = self.torque_nm(before, &reference);
            self.estimation.take_over(&config.control);
            self.control.install(config.control.integral.is_some());
            self.fade_from(config, torque_nm, &reference);
            if self.drive() == Drive::Float {
                let torque_nm = Some(self.command.total_nm());
                self.control
                    .begin_float(&config.control, &self.state, torque_nm);
            }
        } else {
            self.estimation = Estimation::new(&config.control);
            self.control = TorqueControl::new();
        }
        if before.period_us() != config.period_us() {
            self.monitors = Monitors::default();
        }
    }

    /// Torque in N m of this configuration for the present state.
    fn torque_nm(&self, config: &LoopConfig, reference: &Reference<f32>) -> Vector2<f32> {
        let (state, disturbance_nm) = (self.estimation.state(), self.estimation.disturbance_nm());
        self.control
            .torque_nm(&config.control, &state, reference, disturbance_nm)
    }

    /// Begins to follow `reference` from this torque.
    pub(super) fn fade_from(
        &mut self,
        config: &LoopConfig,
        torque_nm: Vector2<f32>,
        reference: &Reference<f32>,
    ) {
        self.control.end_offset();
        let own_nm = self.torque_nm(config, reference);
        self.control.begin_offset(torque_nm - own_nm);
    }

    /// Source that a request begins from if not from the one in force.
    fn initial_source(&self, now: Instant) -> Option<ReferenceSource> {
        self.source.initial(now, &self.state, &self.reference)
    }

    /// Reference that is in force at this time if no other request comes.
    #[inline(never)]
    fn reference_ahead(&self, at_us: u64, now: Instant) -> Reference<f32> {
        let initial = self.initial_source(now);
        initial
            .as_ref()
            .unwrap_or(&self.source.reference)
            .ahead(at_us)
    }

    /// Start point of a motion that is requested now.
    pub fn start_point(&self, now: Instant) -> StartPoint {
        let at_us = now.us + LEAD_US;
        // A stream may change until then: the motion begins from its braking phase.
        let from = self.reference_ahead(at_us, now);
        StartPoint { from, at_us }
    }

    /// Whether the same experiment drives the motors.
    pub fn is_running(&self, plan: &Experiment, is_driven: bool) -> bool {
        self.source.is_running(plan, is_driven)
    }

    /// Takes a request of the host; motors that have not been driven are
    /// [energised](Self::energise).
    ///
    /// # Errors
    /// The reason for the refusal; the state is unchanged.
    pub fn request(
        &mut self,
        config: &LoopConfig,
        request: &DriveRequest,
        now: Instant,
    ) -> Result<(), Refusal> {
        match *request {
            DriveRequest::Torque(torque_nm) => {
                self.begin_drive(now);
                self.source.command = DriveCommand::new(Drive::Torque, torque_nm, now.us);
                Ok(())
            }
            DriveRequest::Regulate(angle_rad) => {
                self.regulate(config, angle_rad, now);
                Ok(())
            }
            DriveRequest::Follow(ref motion) => self.follow_motion(config, motion, now),
            DriveRequest::Stream(point) => self.follow_point(config, point, now),
            DriveRequest::Experiment(ref plan) => self.begin_experiment(config, plan, now),
            DriveRequest::Float => self.begin_float(config, now),
        }
    }

    fn begin_drive(&mut self, now: Instant) {
        if !now.is_driven {
            self.energise();
        }
    }

    // Functions of their own: each has a source of some 900 bytes in its frame, of which
    // inlining makes a sum.

    /// Holds the arm at these angles in rad; a step if it is elsewhere.
    #[inline(never)]
    fn regulate(&mut self, config: &LoopConfig, angle_rad: [f32; JOINTS], now: Instant) {
        let source = ReferenceSource::hold(angle_rad.into());
        self.follow(config, Drive::Regulate, Some(&source), now);
    }

    #[inline(never)]
    fn follow_motion(
        &mut self,
        config: &LoopConfig,
        motion: &TimedTrajectory,
        now: Instant,
    ) -> Result<(), Refusal> {
        let mut initial = self.initial_source(now);
        let source = initial.as_mut().unwrap_or(&mut self.source.reference);
        source.change_to(motion, now.us)?;
        self.follow(config, Drive::Track, initial.as_ref(), now);
        Ok(())
    }

    #[inline(never)]
    fn follow_point(
        &mut self,
        config: &LoopConfig,
        point: Point<f32>,
        now: Instant,
    ) -> Result<(), Refusal> {
        let mut initial = self.initial_source(now);
        let source = initial.as_mut().unwrap_or(&mut self.source.reference);
        source.push(now.acts_us, point)?;
        self.follow(config, Drive::Track, initial.as_ref(), now);
        Ok(())
    }

    /// Begins an experiment where the arm has been brought to rest.
    #[inline(never)]
    fn begin_experiment(
        &mut self,
        config: &LoopConfig,
        plan: &Experiment,
        now: Instant,
    ) -> Result<(), Refusal> {
        if self.is_running(plan, now.is_driven) {
            return Ok(());
        }
        let from = self.reference_ahead(now.acts_us, now);
        let source = ReferenceSource::braking(&from, now.acts_us);
        experiment::admit(plan, &config.monitors, &self.state, source.end())
            .map_err(Refusal::Experiment)?;
        self.follow(config, Drive::Experiment, Some(&source), now);
        self.source.experiment = ActiveExperiment::new(*plan);
        Ok(())
    }

    /// Makes the arm weightless, from the torque in force if it is driven; repeated, it goes on.
    #[inline(never)]
    fn begin_float(&mut self, config: &LoopConfig, now: Instant) -> Result<(), Refusal> {
        if config.period_us().get() > float::PERIOD_MAX_US {
            return Err(Refusal::TooSlow {
                most_us: float::PERIOD_MAX_US,
            });
        }
        let is_floating = now.is_driven && self.drive() == Drive::Float;
        let torque_nm = now.is_driven.then(|| self.command.total_nm());
        self.begin_drive(now);
        if !is_floating {
            self.control
                .begin_float(&config.control, &self.state, torque_nm);
            self.source.reference = ReferenceSource::hold(self.state.q);
        }
        self.source.command = DriveCommand::new(Drive::Float, [0.0; JOINTS], now.us);
        Ok(())
    }

    /// Follows a source, or the present one; the transition from a constant torque has no step.
    fn follow(
        &mut self,
        config: &LoopConfig,
        drive: Drive,
        source: Option<&ReferenceSource>,
        now: Instant,
    ) {
        let was_constant = match self.drive() {
            Drive::Torque | Drive::Experiment | Drive::Float | Drive::Park => now.is_driven,
            Drive::Regulate | Drive::Track | Drive::Hold => false,
        };
        self.begin_drive(now);
        self.source.command = DriveCommand::new(drive, [0.0; JOINTS], now.us);
        if let Some(source) = source {
            self.source.reference.replace(source);
        }
        if was_constant {
            let reference = self.source.reference.at(now.acts_us);
            self.fade_from(config, self.command.total_nm(), &reference);
        }
    }

    /// Turns a bit of the drive command, chosen by `draw`, for tests.
    pub fn inject_error(&mut self, draw: u32) {
        self.source.command.inject_error(draw);
    }

    /// Turns a bit of the reference's numbers, for tests.
    pub fn inject_reference_error(&mut self, draw: u32) {
        self.source.reference.inject_error(draw);
    }
}
