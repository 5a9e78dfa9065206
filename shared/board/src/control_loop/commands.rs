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
use super::reference::{LEAD_US, ReferenceSource, StartPoint, TimedTrajectory};
use super::{ControlLoop, DriveCommand, DriveRequest, Instant, LoopConfig};
use armbridge_control::trajectory::Reference;
use armbridge_control::trajectory::stream::Point;
use armbridge_link::experiment::Experiment;
use armbridge_link::message::{Drive, Refusal};
use armbridge_servo::JOINTS;
use nalgebra::Vector2;

impl ControlLoop {
    /// Source that drives the motors while that is permitted.
    pub fn drive(&self) -> Drive {
        self.commanded.drive()
    }

    /// Before motors may be driven: clears the command, begins the motor check anew, and restarts
    /// monitors and estimate.
    pub fn energise(&mut self) {
        self.motor_check = MotorCheck::default();
        self.end_motor_check();
    }

    /// The same after the motor check, whose result stays.
    pub(super) fn end_motor_check(&mut self) {
        self.commanded = DriveCommand::new(Drive::Hold, [0.0; JOINTS], 0);
        self.restart_monitors();
        self.reset_estimate();
    }

    /// Restarts with the next tick: monitors, the knowledge of the encoders' noise, estimate and
    /// reference.
    pub fn restart(&mut self) {
        self.reset_monitors();
        self.reset_estimate();
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
    fn reset_monitors(&mut self) {
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

    /// Source that a request begins from if not from the one in force: rest at the arm's angles
    /// where it follows none, or braking from an experiment.
    #[inline(never)]
    fn initial_source(&self, now: Instant) -> Option<ReferenceSource> {
        match self.drive() {
            _ if !now.is_driven => Some(ReferenceSource::hold(self.state.q)),
            Drive::Torque => Some(ReferenceSource::hold(self.state.q)),
            Drive::Regulate | Drive::Track | Drive::Hold => None,
            // No tick has used the experiment yet.
            Drive::Experiment if !self.experiment.is_started() => None,
            Drive::Experiment => {
                let from = Reference {
                    ddq: Vector2::zeros(),
                    ..self.reference
                };
                Some(ReferenceSource::braking(&from, now.acts_us))
            }
        }
    }

    /// Reference that is in force at this time if no other request comes.
    #[inline(never)]
    fn reference_ahead(&self, at_us: u64, now: Instant) -> Reference<f32> {
        let initial = self.initial_source(now);
        initial.as_ref().unwrap_or(&self.source).ahead(at_us)
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
        is_driven && self.drive() == Drive::Experiment && self.experiment.plan == *plan
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
                self.commanded = DriveCommand::new(Drive::Torque, torque_nm, now.us);
                Ok(())
            }
            DriveRequest::Regulate(angle_rad) => {
                self.regulate(config, angle_rad, now);
                Ok(())
            }
            DriveRequest::Follow(ref motion) => self.follow_motion(config, motion, now),
            DriveRequest::Stream(point) => self.follow_point(config, point, now),
            DriveRequest::Experiment(ref plan) => self.begin_experiment(config, plan, now),
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
        let source = initial.as_mut().unwrap_or(&mut self.source);
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
        let source = initial.as_mut().unwrap_or(&mut self.source);
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
        self.experiment = ActiveExperiment::new(*plan);
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
        let acts_us = now.acts_us;
        let was_constant = match self.drive() {
            Drive::Torque | Drive::Experiment => now.is_driven,
            Drive::Regulate | Drive::Track | Drive::Hold => false,
        };
        self.begin_drive(now);
        self.commanded = DriveCommand::new(drive, [0.0; JOINTS], now.us);
        if let Some(source) = source {
            self.source.replace(source);
        }
        if was_constant {
            let reference = self.source.at(acts_us);
            self.fade_from(config, self.command.total_nm(), &reference);
        }
    }
}
