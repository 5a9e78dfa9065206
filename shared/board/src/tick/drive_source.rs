//! Drive source: what drives the motors, a constant torque, a reference or an experiment; and the
//! time-outs that end it.
//!
//! | condition                     | time-out                | reaction                       |
//! |-------------------------------|-------------------------|--------------------------------|
//! | the host is silent            | `hold_ms`               | track: brake; torque: off; experiment: its end |
//! | the host is silent            | `silence_ms`            | a fault, whatever drives       |
//! | constant torque, not repeated | `torque_age_ms`         | torque ends                    |
//! | stream, not continued         | `stream_age_ms`         | the reference brakes, the arm is held |
//! | setpoint, not repeated        | `setpoint_age_ms`, if any | torque ends                  |
//! | motion, no other commanded    | `setpoint_age_ms`, if any | the reference brakes, the arm is held |
//!
//! Where the arm has a pose to be parked in, it is [parked](super::park) instead of a fault for
//! silence, and of a torque that ends.
//!
//! An arm that is held after any of these is held at a setpoint as old as the braking. By
//! default a motion goes on to its end, ten minutes at most, and its end is held.

use super::drive_command::DriveCommand;
use super::experiment::ActiveExperiment;
use super::lowering::{Lowered, Rest};
use super::reference::ReferenceSource;
use super::status::{Instant, TickStatus};
use armbridge_control::arm::State;
use armbridge_control::trajectory::Reference;
use armbridge_link::experiment::{Experiment, ExperimentEnd};
use armbridge_link::message::{Drive, Fault, Limits};
use armbridge_link::record::{Fallback, Permission, TickInput, Violation};
use armbridge_servo::{JOINTS, Pwm};
use nalgebra::Vector2;

/// See the [module](self).
#[derive(Clone, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct DriveSource {
    /// Which source drives the motors while that is permitted.
    pub(super) command: DriveCommand,
    pub(super) reference: ReferenceSource,
    /// Experiment of [`Drive::Experiment`].
    pub(super) experiment: ActiveExperiment,
    /// Rest without torque of the joint that a park lowers.
    pub(super) rest: Option<Rest>,
}

impl DriveSource {
    /// An arm that is held upright, once that is permitted.
    pub(super) fn new() -> Self {
        Self {
            command: DriveCommand::new(Drive::Hold, [0.0; JOINTS], 0),
            reference: ReferenceSource::hold(Vector2::zeros()),
            experiment: ActiveExperiment::default(),
            rest: None,
        }
    }

    /// The source that drives.
    pub(super) fn drive(&self) -> Drive {
        self.command.drive()
    }

    /// Joints that a park lowers, or has lowered.
    pub(super) fn lowered(&self) -> Lowered {
        match self.reference.lowered_joint() {
            Some(last) if self.drive() == Drive::Park => [true, last > 0],
            Some(_) | None => [false; JOINTS],
        }
    }

    /// Clears the command: another has to precede any torque.
    pub(super) fn clear(&mut self) {
        self.command = DriveCommand::new(Drive::Hold, [0.0; JOINTS], 0);
    }

    /// Checks the source before it drives anything: its memory, the silence of the host, its age.
    pub(super) fn check(
        &mut self,
        limits: &Limits,
        input: &TickInput,
        status: &mut TickStatus,
    ) -> Option<Fallback> {
        if !status.is_armed() {
            return None;
        }
        if !(self.command.is_intact() && self.reference.is_intact()) {
            status.trip(Violation::plain(Fault::Corrupted));
            return None;
        }
        if status.permission == Permission::Park {
            // It has a limit of its own.
            return None;
        }
        self.check_host_silence(limits, input, status)
            .or_else(|| self.check_age(limits, input, status))
    }

    /// Checks the silence of the host: first hold, then park, or torque off.
    fn check_host_silence(
        &mut self,
        limits: &Limits,
        input: &TickInput,
        status: &mut TickStatus,
    ) -> Option<Fallback> {
        let silent_ms = input.host_silent_ms;
        if let Some(violation) = host_silence(limits, silent_ms) {
            if limits.park.is_some() && status.is_drive_permitted() {
                return Some(Fallback::Park);
            }
            status.trip(violation);
            return None;
        }
        if silent_ms <= limits.hold_ms || !status.is_drive_permitted() {
            return None;
        }
        match self.drive() {
            // The arm is held already, or stays where it is.
            Drive::Regulate | Drive::Hold | Drive::Float | Drive::Park => None,
            Drive::Track => Some(self.brake(input.acts_us())),
            Drive::Torque => Some(end_torque(limits, status)),
            // The experiment ends after this tick's samples have been processed.
            Drive::Experiment => {
                self.experiment.note_host_silence();
                None
            }
        }
    }

    /// Ends a command that is too old, even while heartbeats arrive.
    fn check_age(
        &mut self,
        limits: &Limits,
        input: &TickInput,
        status: &mut TickStatus,
    ) -> Option<Fallback> {
        if !status.is_drive_permitted() || !self.is_aged(limits, input.acts_us()) {
            return None;
        }
        if self.drive() == Drive::Track {
            return Some(self.brake(input.acts_us()));
        }
        Some(end_torque(limits, status))
    }

    /// Whether the command that drives is too old at this time.
    fn is_aged(&self, limits: &Limits, at_us: u64) -> bool {
        let limit_ms = match self.drive() {
            Drive::Torque => limits.torque_age_ms,
            Drive::Track if self.reference.is_streamed() => limits.stream_age_ms,
            Drive::Regulate | Drive::Hold | Drive::Track | Drive::Float => limits.setpoint_age_ms,
            // It has an end and an envelope of its own.
            Drive::Experiment | Drive::Park => 0,
        };
        limit_ms > 0 && self.command.age_us(at_us) > u64::from(limit_ms) * 1_000
    }

    /// Brakes the reference, then holds the arm. The setpoint is of this time, for torque that
    /// ends at once would let a moving arm fall.
    fn brake(&mut self, at_us: u64) -> Fallback {
        self.command = self.command.continued(Drive::Hold, at_us);
        self.reference.brake(at_us);
        Fallback::Brake
    }

    /// The reference at `acts_us`, and the end of an experiment, if it ends; `states` are those at
    /// the samples and at that time, under this PWM.
    #[inline]
    pub(super) fn reference(
        &mut self,
        fast_ticks: u32,
        pwm: [Pwm; JOINTS],
        states: [&State<f32>; 2],
        acts_us: u64,
        is_drive_permitted: bool,
    ) -> (Reference<f32>, Option<ExperimentEnd>) {
        let mut reference = self.reference.at(acts_us);
        let mut end = None;
        if is_drive_permitted && self.drive() == Drive::Experiment {
            end = self.override_reference(fast_ticks, pwm, states, acts_us, &mut reference);
        }
        (reference, end)
    }

    /// Runs a tick of the experiment, which overrides the reference, for an arm that is at
    /// `state` and will be at `ahead` at `acts_us`, under this PWM. Its end brakes the arm.
    #[inline(never)]
    fn override_reference(
        &mut self,
        fast_ticks: u32,
        pwm: [Pwm; JOINTS],
        [state, ahead]: [&State<f32>; 2],
        acts_us: u64,
        reference: &mut Reference<f32>,
    ) -> Option<ExperimentEnd> {
        let end = self
            .experiment
            .tick(pwm, state, ahead, acts_us, fast_ticks, reference);
        if end.is_some() {
            self.reference = ReferenceSource::braking(reference, acts_us);
            self.brake(acts_us);
            *reference = self.reference.at(acts_us);
        }
        end
    }

    /// Whether the same experiment drives the motors.
    pub(super) fn is_running(&self, plan: &Experiment, is_driven: bool) -> bool {
        is_driven && self.drive() == Drive::Experiment && self.experiment.plan == *plan
    }

    /// Reference source that a request begins from if not from the one in force: rest at the
    /// angles of the arm where it follows none, or braking from an experiment. `state` and
    /// `reference` are those of the last tick.
    #[inline(never)]
    pub(super) fn initial(
        &self,
        now: Instant,
        state: &State<f32>,
        reference: &Reference<f32>,
    ) -> Option<ReferenceSource> {
        match self.drive() {
            _ if !now.is_driven => Some(ReferenceSource::hold(state.q)),
            Drive::Torque | Drive::Float => Some(ReferenceSource::hold(state.q)),
            Drive::Regulate | Drive::Track | Drive::Hold | Drive::Park => None,
            // No tick has used the experiment yet.
            Drive::Experiment if !self.experiment.is_started() => None,
            Drive::Experiment => {
                let from = Reference {
                    ddq: Vector2::zeros(),
                    ..*reference
                };
                Some(ReferenceSource::braking(&from, now.acts_us))
            }
        }
    }
}

/// The violation of a host that has been silent for this time in ms, if that is too long.
#[inline]
pub(crate) fn host_silence(limits: &Limits, silent_ms: u16) -> Option<Violation> {
    (silent_ms > limits.silence_ms).then(|| Violation {
        value: f32::from(silent_ms) * 1e-3,
        limit: f32::from(limits.silence_ms) * 1e-3,
        ..Violation::plain(Fault::HostSilent)
    })
}

/// Ends the torque of a command that has expired: parks the arm, or switches off.
fn end_torque(limits: &Limits, status: &mut TickStatus) -> Fallback {
    if limits.park.is_some() {
        return Fallback::Park;
    }
    status.permission = Permission::Armed;
    Fallback::Release
}
