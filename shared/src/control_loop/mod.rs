//! The control loop: what a tick decides, as a value in and a value out.
//!
//! ```text
//!             samples, permission, time                     command, estimate,
//!             TickInput                                     reference, fault
//!                |                                          TickOutput
//!                v                                             ^
//!   estimator -> monitors -> prediction -> reference -> controller -> limits -> PWM
//!                   |           to the      source, or                  |
//!                   |         next tick     experiment                  |
//!                   +------------- Violation: command OFF --------------+
//! ```
//!
//! [`ControlLoop::step`] owns estimate, monitors, reference source and experiment, and
//! nothing else: no bus, no queue, no record, no clock. Board, bench, emulator and
//! replay call it; equal inputs give equal outputs, to the bit.
//!
//! # Contract
//!
//! * Call [`step`](ControlLoop::step) once a tick, when the samples are in. What it
//!   returns is sent at the beginning of the next tick, so a torque acts one period
//!   after the samples that it was decided from, always; the prediction accounts for it.
//! * The motors are driven only under [`Permission::Drive`]. Any fault, and any other
//!   permission, make the command [`ActuatorCommand::OFF`].
//! * The configuration is immutable between ticks and replaced as a whole
//!   ([`install`](ControlLoop::install)); the loop keeps none of its numbers.
//! * Angles in rad, speeds in rad/s, torques in N m, times in µs of a clock that never
//!   goes back.
//!
//! What follows from a fault, who may drive and when motors are seen to be off is not
//! decided here: that is for the [`supervisor`](crate::supervisor) and the bus.
//!
//! # Bumpless
//!
//! A set-up may be replaced while torque is on. The estimator goes on from the
//! state it is handed, and what the torque would jump by is added to it and
//! faded out, so that the servos see no step. So is a constant torque when the
//! arm is made to follow a reference. A setpoint elsewhere, and holding an arm
//! whose motors were off, are steps: they are asked for as such.
//!
//! # Example
//!
//! The loop closed around an arm, and nothing else:
//!
//! ```
//! use armbridge_shared::actuator::Joint;
//! use armbridge_shared::arm::{Parameters, State};
//! use armbridge_shared::control_loop::{ControlLoop, Instant, LoopConfig, Permission, TickInput};
//! use armbridge_shared::link::message::{Sample, Settings};
//! use nalgebra::Vector2;
//!
//! let config = LoopConfig::build(&Settings::default()).unwrap();
//! let (arm, servo) = (Parameters::<f32>::paper(), Joint::<f32>::paper());
//! let mut plant = State::at_rest(Vector2::new(0.2, -0.1));
//! let (mut control, mut input) = (ControlLoop::new(&config), TickInput::AT_REST);
//! control.regulate(&config, [0.0, 0.0], Instant::default());
//! for tick in 1..=2_000 {
//!     input.samples = [plant.q.x, plant.q.y].map(|q| Sample::Counts(servo.position(q) as u16));
//!     (input.acts_us, input.permission) = (tick * 1_000, Permission::Drive);
//!     let torque = input.in_force.total_nm();
//!     input.in_force = control.step(&config, &input).command;
//!     plant.dq += arm.acceleration(&plant, torque) * 1e-3;
//!     plant.q += plant.dq * 1e-3;
//! }
//! assert!(plant.q.amax() < 0.02, "it stands at {}", plant.q);
//! ```
//!
//! | module         | what                                                     |
//! |----------------|----------------------------------------------------------|
//! | [`LoopConfig`] | what a tick computes with, under check words             |
//! | `drive_command` | what drives the motors, and since when                  |
//! | `tick`         | inputs and outputs                                       |
//! | `pipeline`     | from state and reference to PWM                          |
//! | `monitors`     | what is detected, what is limited                        |
//! | [`reference`]  | where the reference comes from                           |
//! | `experiment`   | experiments, from admission to the end                   |
//! | [`limits`]     | numbers that no host can set                             |

mod config;
mod drive_command;
mod experiment;
pub mod limits;
mod monitors;
mod pipeline;
pub mod reference;
mod tick;

pub use config::{CHECK_US, ControlConfig, LoopConfig, can_run, why_not};
pub use experiment::permits;
pub use monitors::Violation;
pub use pipeline::ActuatorCommand;
pub use tick::{Fallback, Instant, Permission, TickInput, TickOutput};

use crate::JOINTS;
use crate::arm::{Posture, State};
use crate::control::Reference;
use crate::control::trajectory::stream::Point;
use crate::estimate::Estimate;
use crate::flow_token::{FlowToken, Machine};
use crate::link::experiment::{Experiment, Objection};
use crate::link::message::{Drive, Fault, Guards, Missing, Refusal, Sample};
use crate::servo::protocol1::Alarms;
use drive_command::DriveCommand;
use experiment::ActiveExperiment;
use monitors::{MonitorInput, Monitors};
use nalgebra::Vector2;
use pipeline::Demand;
use reference::{ReferenceSource, StartPoint, TimedTrajectory};

/// Alarms upon which a stock servo, as it comes, lets go of its shaft.
const SHUTDOWN: Alarms = Alarms::OVERHEATING.or(Alarms::OVERLOAD);

/// The state of the control loop, see the [module](self).
#[derive(Clone, Debug)]
pub struct ControlLoop {
    estimate: Estimate<f32>,
    /// The estimator has not seen a sample since it was last in doubt.
    is_fresh: bool,
    monitors: Monitors,
    /// What drives the motors while that is permitted.
    commanded: DriveCommand,
    source: ReferenceSource,
    /// Of [`Drive::Experiment`].
    experiment: ActiveExperiment,
    /// What is still added to the torque since the set-up was replaced.
    bump_nm: Vector2<f32>,
    /// What the last tick estimated, asked for and decided.
    state: State<f32>,
    reference: Reference<f32>,
    command: ActuatorCommand,
}

impl TickInput {
    /// A tick that brought nothing, with motors off.
    pub const AT_REST: Self = Self {
        samples: [Sample::Missing(Missing::NotAsked); JOINTS],
        alarms: [Alarms::NONE; JOINTS],
        in_force: ActuatorCommand::OFF,
        acts_us: 0,
        permission: Permission::Off,
        host_silent_us: 0,
        is_config_intact: true,
        token: FlowToken::begin(0),
    };
}

/// What a tick has come to so far.
struct Verdict {
    permission: Permission,
    fault: Option<Violation>,
}

impl Verdict {
    fn is_armed(&self) -> bool {
        matches!(self.permission, Permission::Armed | Permission::Drive)
    }

    fn is_driven(&self) -> bool {
        self.permission == Permission::Drive
    }

    /// Motors off; the first cause stays, for what follows is often its consequence.
    fn trip(&mut self, violation: Violation) {
        self.fault.get_or_insert(violation);
        if self.permission != Permission::Unmonitored {
            self.permission = Permission::Off;
        }
    }
}

impl ControlLoop {
    /// A loop that knows nothing of the arm.
    pub fn new(config: &LoopConfig) -> Self {
        let upright = Vector2::zeros();
        Self {
            estimate: config.control.estimator.at_rest(upright),
            is_fresh: true,
            monitors: Monitors::default(),
            commanded: DriveCommand::new(Drive::Hold, [0.0; JOINTS], 0),
            source: ReferenceSource::hold(upright),
            experiment: ActiveExperiment::default(),
            bump_nm: Vector2::zeros(),
            state: State::at_rest(upright),
            reference: Reference::at_rest(upright),
            command: ActuatorCommand::OFF,
        }
    }

    /// Estimates, monitors, controls: everything that is decided in a tick.
    pub fn step(&mut self, config: &LoopConfig, input: &TickInput) -> TickOutput {
        let mut verdict = Verdict {
            permission: input.permission,
            fault: None,
        };
        self.check_command(&mut verdict);
        let mut fallback = self
            .watch_host(config, input, &mut verdict)
            .or_else(|| self.watch_age(config, input, &mut verdict));
        let counts = input.samples.map(Sample::counts);
        let measured = config.control.angles(counts);
        let is_fresh = self.is_fresh;
        if let (true, [Some(a), Some(b)]) = (is_fresh, measured) {
            self.estimate = config.control.estimator.at_rest([a, b].into());
            self.bump_nm = Vector2::zeros();
            self.is_fresh = false;
        }
        let predicted_rad = self.estimate.state().q.into();
        let believed = if verdict.is_armed() && !is_fresh {
            config.monitors.gate_innovation(measured, predicted_rad)
        } else {
            measured
        };
        let state = config
            .control
            .estimator
            .correct(&mut self.estimate, believed);
        // Of the estimate with these samples, whichever state is reported.
        let posture = Posture::of(self.estimate.state().q);
        self.monitor(config, input, &mut verdict, |is_armed| MonitorInput {
            counts,
            missing: input.samples.map(Sample::missing),
            measured_rad: measured,
            predicted_rad,
            is_fresh,
            state: &state,
            torque_nm: input.in_force.total_nm().into(),
            gravity_nm: posture.gravity(&config.control.arm).into(),
            is_alarmed: input.alarms.map(|alarms| !alarms.and(SHUTDOWN).is_empty()),
            is_armed,
        });
        // What is decided now acts from the next samples on.
        let ahead = self.predict(config, &posture, &input.in_force);
        let mut reference = self.source.at(input.acts_us);
        let mut experiment_end = None;
        if verdict.is_driven() && self.drive() == Drive::Experiment {
            let pwm = input.in_force.pwm;
            let fast_ticks = config.monitors.fast_ticks();
            let (at_us, asked) = (input.acts_us, &mut reference);
            experiment_end = self
                .experiment
                .tick(pwm, &state, &ahead, at_us, fast_ticks, asked);
            if experiment_end.is_some() {
                self.source = ReferenceSource::braking(asked, at_us);
                fallback = Some(self.brake(at_us));
                reference = self.source.at(at_us);
            }
        }
        let mut guards = Guards::NONE;
        let command = if verdict.is_driven() {
            self.control(config, &input.in_force, &ahead, &reference, &mut guards)
                .unwrap_or_else(|violation| {
                    verdict.trip(violation);
                    ActuatorCommand::OFF
                })
        } else {
            ActuatorCommand::OFF
        };
        (self.state, self.reference, self.command) = (state, reference, command);
        TickOutput {
            command,
            estimate: state,
            reference,
            disturbance_nm: self.estimate.disturbance().into(),
            guards,
            is_complete: believed.iter().all(Option::is_some),
            fallback,
            experiment_end,
            fault: verdict.fault,
            token: input.token.stamp(Machine::ControlLoop),
        }
    }

    /// How long the host has been silent: hold, then let go.
    fn watch_host(
        &mut self,
        config: &LoopConfig,
        input: &TickInput,
        verdict: &mut Verdict,
    ) -> Option<Fallback> {
        if !verdict.is_armed() {
            return None;
        }
        let silent_us = input.host_silent_us;
        let limits = config.limits();
        let allowed_us = |ms: u16| u64::from(ms) * 1_000;
        if silent_us > allowed_us(limits.silence_ms) {
            verdict.trip(Violation {
                value: silent_us as f32 * 1e-6,
                limit: f32::from(limits.silence_ms) * 1e-3,
                ..Violation::plain(Fault::HostSilent)
            });
            return None;
        }
        if silent_us <= allowed_us(limits.hold_ms) || !verdict.is_driven() {
            return None;
        }
        match self.drive() {
            // They hold already.
            Drive::Regulate | Drive::Hold => None,
            Drive::Track => Some(self.brake(input.acts_us)),
            Drive::Torque => {
                verdict.permission = Permission::Armed;
                Some(Fallback::Release)
            }
            // It ends when this tick's samples have been looked at.
            Drive::Experiment => {
                self.experiment.note_quiet();
                None
            }
        }
    }

    /// A command that drives and is too old ends, however alive the host is.
    fn watch_age(
        &mut self,
        config: &LoopConfig,
        input: &TickInput,
        verdict: &mut Verdict,
    ) -> Option<Fallback> {
        if !verdict.is_driven() || !self.is_aged(config, input.acts_us) {
            return None;
        }
        if self.drive() == Drive::Track {
            return Some(self.brake(input.acts_us));
        }
        verdict.permission = Permission::Armed;
        Some(Fallback::Release)
    }

    /// Whether what drives was commanded too long ago, at this time.
    pub fn is_aged(&self, config: &LoopConfig, at_us: u64) -> bool {
        let limits = config.limits();
        let most_ms = match self.drive() {
            Drive::Torque => limits.torque_age_ms,
            Drive::Track if self.source.is_streamed() => limits.stream_age_ms,
            Drive::Regulate | Drive::Hold => limits.setpoint_age_ms,
            Drive::Track | Drive::Experiment => 0,
        };
        most_ms > 0 && self.commanded.age_us(at_us) > u64::from(most_ms) * 1_000
    }

    /// Nothing is driven by a command that is not what was commanded.
    fn check_command(&self, verdict: &mut Verdict) {
        if verdict.is_armed() && !self.commanded.is_intact() {
            verdict.trip(Violation::plain(Fault::Corrupted));
        }
    }

    /// Turns a bit of what drives, chosen by `draw`: for tests of what becomes of it.
    pub fn inject_error(&mut self, draw: u32) {
        self.commanded.inject_error(draw);
    }

    fn brake(&mut self, at_us: u64) -> Fallback {
        self.commanded = self.commanded.with_drive(Drive::Hold);
        self.source.brake(at_us);
        Fallback::Brake
    }

    fn monitor<'a>(
        &mut self,
        config: &LoopConfig,
        input: &TickInput,
        verdict: &mut Verdict,
        seen: impl FnOnce(bool) -> MonitorInput<'a>,
    ) {
        if verdict.permission != Permission::Unmonitored {
            let seen = seen(verdict.is_armed());
            if let Err(violation) = self.monitors.judge(&config.monitors, &seen) {
                verdict.trip(violation);
            }
        }
        if verdict.is_armed() && !input.is_config_intact {
            verdict.trip(Violation::plain(Fault::Corrupted));
        }
    }

    /// The state at the next samples, until which `in_force` acts.
    fn predict(
        &mut self,
        config: &LoopConfig,
        posture: &Posture<f32>,
        in_force: &ActuatorCommand,
    ) -> State<f32> {
        let control = &config.control;
        self.bump_nm *= control.fade;
        let known_nm = if control.knows_friction {
            in_force.total_nm()
        } else {
            in_force.torque_nm
        };
        control
            .estimator
            .advance_from(&control.arm, posture, &mut self.estimate, known_nm)
    }

    /// What the controller asks for, less what the estimator knows of a disturbance.
    fn demand(
        &self,
        config: &LoopConfig,
        state: &State<f32>,
        reference: &Reference<f32>,
    ) -> Demand {
        let demand = config.control.demand(state, reference);
        Demand {
            torque_nm: demand.torque_nm + self.bump_nm - self.estimate.disturbance(),
            ..demand
        }
    }

    /// What drives the motors from the next tick on, within all limits.
    fn control(
        &mut self,
        config: &LoopConfig,
        in_force: &ActuatorCommand,
        ahead: &State<f32>,
        reference: &Reference<f32>,
        guards: &mut Guards,
    ) -> Result<ActuatorCommand, Violation> {
        let Demand {
            mut torque_nm,
            mut friction_nm,
        } = match self.drive() {
            Drive::Torque => Demand {
                torque_nm: self.commanded.torque_nm().into(),
                friction_nm: Vector2::zeros(),
            },
            Drive::Regulate | Drive::Track | Drive::Hold | Drive::Experiment => {
                self.demand(config, ahead, reference)
            }
        };
        let control = &config.control;
        let exactly = (self.drive() == Drive::Experiment).then(|| {
            self.experiment
                .override_torque(&control.joints, &mut torque_nm, &mut friction_nm)
        });
        let before_nm = in_force.total_nm();
        let monitors = &config.monitors;
        let limited = self
            .monitors
            .limit(monitors, &control.arm, ahead, torque_nm, before_nm)?;
        let pwm_max = config.limits().pwm_counts;
        let commands = match exactly {
            None => control.commands(limited.torque_nm, friction_nm, pwm_max),
            Some(exactly) => {
                control.commands_exactly(exactly, limited.torque_nm, friction_nm, pwm_max)
            }
        };
        let (command, is_limited) = commands.ok_or(Violation::plain(Fault::NotFinite))?;
        *guards = limited.guards;
        if is_limited {
            *guards = guards.or(Guards::PWM);
        }
        self.monitors.note_pwm(monitors, is_limited)?;
        Ok(command)
    }

    /// What drives the motors while that is permitted.
    pub fn drive(&self) -> Drive {
        self.commanded.drive()
    }

    /// Samples of this joint that are missing in a row.
    pub fn lost_in_row(&self, joint: usize) -> u32 {
        self.monitors.lost_in_row(joint)
    }

    /// Nothing is commanded yet, at this time in µs.
    pub fn reset_command(&mut self, now_us: u64) {
        self.commanded = DriveCommand::new(Drive::Hold, [0.0; JOINTS], now_us);
    }

    /// The arm may be anywhere: the estimator begins anew with the next samples, and
    /// no reference is left of before.
    pub fn reset_estimate(&mut self) {
        self.is_fresh = true;
        self.source = ReferenceSource::hold(Vector2::zeros());
    }

    /// The monitors begin anew.
    pub fn reset_monitors(&mut self) {
        self.monitors = Monitors::default();
    }

    /// Goes over to another configuration, without a step in the torque if motors are
    /// driven; what is decided next acts at `acts_us`.
    pub fn install(
        &mut self,
        before: &LoopConfig,
        config: &LoopConfig,
        is_driven: bool,
        acts_us: u64,
    ) {
        if is_driven {
            let reference = self.source.at(acts_us);
            let asked = self.demand(before, &self.estimate.state(), &reference);
            self.estimate = config.control.estimator.take_over(&self.estimate);
            self.fade_from(config, asked.torque_nm, &reference);
        } else {
            self.is_fresh = true;
            self.estimate = config.control.estimator.at_rest(Vector2::zeros());
            self.bump_nm = Vector2::zeros();
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
        let own = self.demand(config, &self.estimate.state(), reference);
        self.bump_nm = torque_nm - own.torque_nm;
    }

    /// Constant joint torques in N m from the next tick on, commanded at this time.
    pub fn hold_torque(&mut self, torque_nm: [f32; JOINTS], now_us: u64) {
        self.commanded = DriveCommand::new(Drive::Torque, torque_nm, now_us);
    }

    /// Holds the arm at these angles in rad, a step if it is elsewhere.
    pub fn regulate(&mut self, config: &LoopConfig, angle_rad: [f32; JOINTS], now: Instant) {
        let source = ReferenceSource::hold(angle_rad.into());
        self.follow(config, Drive::Regulate, source, now);
    }

    /// Makes the arm follow a source, from a torque that followed none without a step.
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

    /// The source, or, if the arm follows none, rest where it is.
    #[inline(never)]
    pub fn present_source(&self, now: Instant) -> ReferenceSource {
        match self.drive() {
            _ if !now.is_driven => ReferenceSource::hold(self.state.q),
            Drive::Torque => ReferenceSource::hold(self.state.q),
            Drive::Regulate | Drive::Track | Drive::Hold => self.source.clone(),
            // Nothing has been decided by it.
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

    /// Where a motion that is asked for now would begin.
    pub fn start_point(&self, now: Instant) -> StartPoint {
        self.present_source(now).start_point(now.us)
    }

    /// The source with a planned motion added.
    ///
    /// # Errors
    /// Its time has passed, or it would begin elsewhere than the arm is asked to be.
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
    /// Why the point cannot be.
    pub fn with_point(&self, point: Point<f32>, now: Instant) -> Result<ReferenceSource, Refusal> {
        let mut source = self.present_source(now);
        source.push(now.us, point)?;
        Ok(source)
    }

    /// Whether the very same experiment is what drives the motors.
    pub fn is_running(&self, plan: &Experiment, is_driven: bool) -> bool {
        is_driven && self.drive() == Drive::Experiment && self.experiment.plan == *plan
    }

    /// Where the arm comes to rest for an experiment that begins now, if it may.
    ///
    /// # Errors
    /// Why it may not.
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
        self.experiment = ActiveExperiment::of(plan);
    }

    /// What drives the motors is this: of a recorded tick.
    pub fn set_drive(&mut self, drive: Drive) {
        self.commanded = self.commanded.with_drive(drive);
    }

    /// Goes on from what a recorded tick estimated and asked for.
    pub fn resume(&mut self, state: State<f32>, reference: Reference<f32>) {
        (self.state, self.reference) = (state, reference);
    }
}
