//! Commands to the control loop, taken between two ticks.
//!
//! A command replaces reference source, torque or experiment at once; its first effect is
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

use super::experiment::{self, ActiveExperiment};
use super::monitors::Monitors;
use super::motor_check::MotorCheck;
use super::pipeline::FeedForward;
use super::reference::{ReferenceSource, StartPoint, TimedTrajectory};
use super::{ControlLoop, DriveCommand, Instant, LoopConfig};
use armbridge_control::arm::State;
use armbridge_control::trajectory::Reference;
use armbridge_control::trajectory::stream::Point;
use armbridge_link::experiment::{Experiment, Objection};
use armbridge_link::message::{Drive, Refusal};
use armbridge_servo::JOINTS;
use nalgebra::Vector2;

impl ControlLoop {
    /// Source that drives the motors while that is permitted.
    pub fn drive(&self) -> Drive {
        self.commanded.drive()
    }

    /// Clears the command, and begins the motor check anew, at this time in µs.
    pub fn reset_command(&mut self, now_us: u64) {
        self.commanded = DriveCommand::new(Drive::Hold, [0.0; JOINTS], now_us);
        self.motor_check = MotorCheck::default();
    }

    /// Resets the estimator, which restarts from the next samples, and the reference: the
    /// arm may be anywhere.
    pub fn reset_estimate(&mut self) {
        self.is_fresh = true;
        self.source = ReferenceSource::hold(Vector2::zeros());
    }

    /// Restarts the monitors, except that the encoders' noise stays known.
    pub fn restart_monitors(&mut self) {
        self.monitors = self.monitors.restarted();
    }

    /// Resets the monitors, and the knowledge of the encoders' noise.
    pub fn reset_monitors(&mut self) {
        self.monitors = Monitors::default();
    }

    /// Reason against arming: an encoder whose noise is not known yet, above all one without
    /// samples, or a joint beyond its angle limit.
    pub fn encoder_refusal(&self, config: &LoopConfig) -> Option<Refusal> {
        let unknown = self.monitors.unknown_encoder();
        let unknown = unknown.map(|joint| Refusal::EncoderUnknown { joint });
        unknown.or_else(|| {
            let beyond = config.monitors.beyond_limit(self.state.q.into());
            beyond.map(|joint| Refusal::BeyondLimit { joint })
        })
    }

    /// Whether the last check of the motors, which has passed, need not be repeated.
    pub fn is_motor_check_conclusive(&self) -> bool {
        self.motor_check.is_conclusive()
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
        self.feed_forward = FeedForward::none();
        if is_driven {
            let reference = self.source.at(acts_us);
            let forward_nm = before.control.feed_forward(&reference);
            let demand = self.demand(before, &self.estimate.state(), &reference, forward_nm);
            self.estimate = config.control.estimator.take_over(&self.estimate);
            if config.control.integral.is_none() {
                self.integral_nm = Vector2::zeros();
            }
            self.fade_from(config, demand.torque_nm, &reference);
        } else {
            self.is_fresh = true;
            self.estimate = config.control.estimator.at_rest(Vector2::zeros());
            self.bump_nm = Vector2::zeros();
            self.integral_nm = Vector2::zeros();
        }
        if before.period_us() != config.period_us() {
            self.reset_monitors();
        }
    }

    /// Begins to follow `reference` with this torque; the offset decays within
    /// half a second.
    fn fade_from(
        &mut self,
        config: &LoopConfig,
        torque_nm: Vector2<f32>,
        reference: &Reference<f32>,
    ) {
        self.bump_nm = Vector2::zeros();
        let forward_nm = config.control.feed_forward(reference);
        let demand = self.demand(config, &self.estimate.state(), reference, forward_nm);
        self.bump_nm = torque_nm - demand.torque_nm;
    }

    /// Commands constant joint torques in N m from the next tick on, at this time.
    pub fn hold_torque(&mut self, torque_nm: [f32; JOINTS], now_us: u64) {
        self.commanded = DriveCommand::new(Drive::Torque, torque_nm, now_us);
    }

    /// Holds the arm at these angles in rad; a step if it is elsewhere.
    pub fn regulate(&mut self, config: &LoopConfig, angle_rad: [f32; JOINTS], now: Instant) {
        let source = ReferenceSource::hold(angle_rad.into());
        self.follow(config, Drive::Regulate, source, now);
    }

    /// Follows a source; the transition from a constant torque has no step.
    pub fn follow(
        &mut self,
        config: &LoopConfig,
        drive: Drive,
        source: ReferenceSource,
        now: Instant,
    ) {
        let acts_us = now.acts_us;
        let was_constant = match self.drive() {
            Drive::Torque | Drive::Experiment => now.is_driven,
            Drive::Regulate | Drive::Track | Drive::Hold => false,
        };
        self.commanded = DriveCommand::new(drive, [0.0; JOINTS], now.us);
        self.source = source;
        if was_constant {
            let reference = self.source.at(acts_us);
            self.fade_from(config, self.command.total_nm(), &reference);
        }
    }

    /// The present source; if the arm follows none, rest at its angles.
    #[inline(never)]
    pub fn present_source(&self, now: Instant) -> ReferenceSource {
        match self.drive() {
            _ if !now.is_driven => ReferenceSource::hold(self.state.q),
            Drive::Torque => ReferenceSource::hold(self.state.q),
            Drive::Regulate | Drive::Track | Drive::Hold => self.source.clone(),
            // No tick has used the experiment yet.
            Drive::Experiment if !self.experiment.is_started() => self.source.clone(),
            Drive::Experiment => {
                let from = Reference {
                    ddq: Vector2::zeros(),
                    ..self.reference
                };
                ReferenceSource::braking(&from, now.acts_us)
            }
        }
    }

    /// Start point of a motion that is requested now.
    pub fn start_point(&self, now: Instant) -> StartPoint {
        self.present_source(now).start_point(now.us)
    }

    /// The source with a planned motion added.
    ///
    /// # Errors
    /// [`Refusal::Busy`] if its time has passed, or if it would begin away from the reference.
    pub fn with_motion(
        &self,
        motion: TimedTrajectory,
        now: Instant,
    ) -> Result<ReferenceSource, Refusal> {
        let mut source = self.present_source(now);
        source.change_to(motion, now.us)?;
        Ok(source)
    }

    /// The source with a streamed point added.
    ///
    /// # Errors
    /// The reason for the refusal of the point.
    pub fn with_point(&self, point: Point<f32>, now: Instant) -> Result<ReferenceSource, Refusal> {
        let mut source = self.present_source(now);
        source.push(now.acts_us, point)?;
        Ok(source)
    }

    /// Whether the same experiment drives the motors.
    pub fn is_running(&self, plan: &Experiment, is_driven: bool) -> bool {
        is_driven && self.drive() == Drive::Experiment && self.experiment.plan == *plan
    }

    /// The source that brings the arm to rest for an experiment that begins now.
    ///
    /// # Errors
    /// The reason why the experiment may not begin.
    #[inline(never)]
    pub fn admit(
        &self,
        config: &LoopConfig,
        plan: &Experiment,
        now: Instant,
    ) -> Result<ReferenceSource, Objection> {
        let mut source = self.present_source(now);
        source.brake(now.acts_us);
        experiment::admit(plan, &config.monitors, &self.state, source.end())?;
        Ok(source)
    }

    /// Begins an experiment from where it was [admitted](Self::admit).
    pub fn begin_experiment(
        &mut self,
        config: &LoopConfig,
        plan: Experiment,
        source: ReferenceSource,
        now: Instant,
    ) {
        self.follow(config, Drive::Experiment, source, now);
        self.experiment = ActiveExperiment::new(plan);
    }

    /// Sets the source that drives the motors, from a recorded tick.
    pub fn set_drive(&mut self, drive: Drive) {
        self.commanded = self.commanded.with_drive(drive);
    }

    /// Sets estimate and reference from a recorded tick.
    pub fn resume(&mut self, state: State<f32>, reference: Reference<f32>) {
        (self.state, self.reference) = (state, reference);
    }
}
