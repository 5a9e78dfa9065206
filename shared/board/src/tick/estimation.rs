//! Estimation: the state of the arm at the samples, and at the samples of the next tick.
//!
//! ```text
//! prediction of the last tick, samples  -> correct -> state      monitors, record
//! state, torque in force                -> predict -> ahead      controller
//! ```
//!
//! The torque that a tick decides begins to act one period after its samples, when the command
//! is sent. The controller acts on the state *there*: the delay of one period is in the
//! prediction, and no gain has to tolerate it.

use super::actuator_command::ActuatorCommand;
use super::config::{ControlConfig, LoopConfig};
use super::sense::Sensed;
use armbridge_control::arm::{Posture, State};
use armbridge_control::estimate::Estimate;
use armbridge_servo::JOINTS;
use nalgebra::Vector2;

/// Estimate of the arm, between two ticks.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Estimation {
    estimate: Estimate<f32>,
    /// Whether there has been no tick with a sample of each joint since the last reset.
    is_fresh: bool,
}

/// Results of a correction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Estimated {
    /// State at the samples, as reported: that before them from an estimator of the prediction
    /// form.
    pub(super) state: State<f32>,
    /// Angles in rad before the samples.
    pub(super) predicted_rad: [f32; JOINTS],
    /// Whether the estimate begins with these samples, without a prediction.
    pub(super) is_fresh: bool,
    /// Whether every joint has a sample that passed the innovation gate.
    pub(super) is_complete: bool,
    /// Posture at the samples, with them, whichever state is reported.
    pub(super) posture: Posture<f32>,
    /// Torque in N m that gravity takes there.
    pub(super) gravity_nm: Vector2<f32>,
}

impl Estimation {
    /// An estimate that begins at the next samples.
    pub(super) fn new(config: &ControlConfig) -> Self {
        Self {
            estimate: config.estimator.at_rest(Vector2::zeros()),
            is_fresh: true,
        }
    }

    /// Begins anew at the next samples.
    pub(super) fn reset(&mut self) {
        self.is_fresh = true;
    }

    /// Goes on with another estimator, from the same state.
    pub(super) fn take_over(&mut self, config: &ControlConfig) {
        self.estimate = config.estimator.take_over(&self.estimate);
    }

    /// Whether there is a state to control: each joint has had a sample.
    pub(super) fn has_state(&self) -> bool {
        !self.is_fresh
    }

    /// Present state.
    pub(super) fn state(&self) -> State<f32> {
        self.estimate.state()
    }

    /// Estimated disturbance torque in N m, positive as the motor's.
    pub(super) fn disturbance_nm(&self) -> Vector2<f32> {
        self.estimate.disturbance()
    }

    /// Corrects the prediction by the samples; while armed, only by those that pass the
    /// innovation gate.
    pub(super) fn correct(
        &mut self,
        config: &LoopConfig,
        sensed: &Sensed,
        is_armed: bool,
    ) -> Estimated {
        let (control, measured_rad) = (&config.control, sensed.measured_rad);
        let is_fresh = self.is_fresh;
        if let (true, [Some(a), Some(b)]) = (is_fresh, measured_rad) {
            self.estimate = control.estimator.at_rest([a, b].into());
            self.is_fresh = false;
        }
        let predicted_rad = self.estimate.state().q.into();
        let gated = if is_armed && !is_fresh {
            config.monitors.gate_innovation(measured_rad, predicted_rad)
        } else {
            measured_rad
        };
        let state = control.estimator.correct(&mut self.estimate, gated);
        let posture = Posture::of(self.estimate.state().q);
        Estimated {
            state,
            predicted_rad,
            is_fresh,
            is_complete: gated.iter().all(Option::is_some),
            posture,
            gravity_nm: posture.gravity(&control.arm),
        }
    }

    /// Predicts the state at the next samples, until which the torque in force acts. Under
    /// motors that are off and stay so the arm rests on something: a model that falls would
    /// estimate a speed there, so it is predicted as held against gravity.
    pub(super) fn predict(
        &mut self,
        config: &ControlConfig,
        estimated: &Estimated,
        in_force: &ActuatorCommand,
        drives_motors: bool,
    ) -> State<f32> {
        let known_nm = if drives_motors || *in_force != ActuatorCommand::OFF {
            in_force.known_nm(config.knows_friction)
        } else {
            estimated.gravity_nm
        };
        let (arm, posture) = (&config.arm, &estimated.posture);
        config
            .estimator
            .advance_from(arm, posture, &mut self.estimate, known_nm)
    }
}
