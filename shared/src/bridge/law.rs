//! A set-up made ready: estimator, gain and actuators for one period.
//!
//! Building takes a Riccati solution, far too long for a tick; it is done on
//! the link's side, and the tick is handed the result as a whole.

use core::num::NonZeroU64;
use nalgebra::Vector2;

use super::limits::{PERIOD_MAX_US, PERIOD_MIN_US};
use crate::JOINTS;
use crate::actuator::{DeadZone, Joint, Pwm};
use crate::arm::{Parameters, State};
use crate::control::{Lqr, Setpoint, Weights};
use crate::estimate::{Config, Estimator};
use crate::link::message::{self, Gains, Refusal, Setup};

/// What a tick computes with.
#[derive(Clone, Debug)]
pub(super) struct Law {
    period_us: NonZeroU64,
    arm: Parameters<f32>,
    joints: [Joint<f32>; JOINTS],
    estimator: Estimator<f32>,
    lqr: Lqr<f32>,
    setpoint: Setpoint<f32>,
}

impl Law {
    /// Designs what `setup` asks for.
    pub(super) fn build(setup: &Setup) -> Result<Self, Refusal> {
        if !(PERIOD_MIN_US..=PERIOD_MAX_US).contains(&setup.period_us) {
            return Err(Refusal::OutOfRange);
        }
        let period_us = NonZeroU64::new(setup.period_us.into()).ok_or(Refusal::OutOfRange)?;
        let period_s = setup.period_us as f32 * 1e-6;
        let arm = Parameters::paper();
        let model = arm.linearise(Vector2::zeros()).zero_order_hold(period_s);
        let config = match setup.estimator {
            message::Estimator::FiniteDifference { filter_s } => {
                Config::FiniteDifference { filter_s }
            }
            message::Estimator::Luenberger { poles_45ms } => Config::Luenberger { poles_45ms },
        };
        let estimator = config
            .build(&arm, period_s)
            .map_err(|_| Refusal::OutOfRange)?;
        let lqr = match setup.gains {
            Gains::Paper => Lqr::paper(),
            Gains::Design { q, r } => {
                Lqr::design(&model, &Weights { q, r }).map_err(|_| Refusal::NoGains)?
            }
        };
        let dead_zone = setup.compensate_dead_zone.then(DeadZone::paper);
        Ok(Self {
            period_us,
            arm,
            joints: [Joint {
                dead_zone,
                ..Joint::paper()
            }; JOINTS],
            estimator,
            lqr,
            setpoint: Setpoint::new(&arm, Vector2::zeros()),
        })
    }

    pub(super) fn period_us(&self) -> NonZeroU64 {
        self.period_us
    }

    /// Where the controller is to hold the arm, in rad.
    pub(super) fn set_reference(&mut self, reference_rad: [f32; JOINTS]) {
        self.setpoint = Setpoint::new(&self.arm, reference_rad.into());
    }

    /// That reference.
    pub(super) fn reference_rad(&self) -> [f32; JOINTS] {
        self.setpoint.q().into()
    }

    /// Joint angles in rad for encoder counts.
    pub(super) fn angles(&self, counts: [Option<u16>; JOINTS]) -> [Option<f32>; JOINTS] {
        let ([joint_a, joint_b], [a, b]) = (&self.joints, counts);
        [
            a.map(|count| joint_a.angle(count)),
            b.map(|count| joint_b.angle(count)),
        ]
    }

    /// The estimator begins at rest at these angles.
    pub(super) fn reset(&mut self, angle_rad: [f32; JOINTS]) {
        self.estimator.reset(angle_rad.into());
    }

    /// The state at these samples.
    pub(super) fn correct(&mut self, measured_rad: [Option<f32>; JOINTS]) -> State<f32> {
        self.estimator.correct(measured_rad)
    }

    /// The state at the next samples, until which this torque acts.
    pub(super) fn advance(&mut self, in_force_nm: Vector2<f32>) -> State<f32> {
        self.estimator.advance(in_force_nm)
    }

    /// Commands that regulate, for a state. `None` if anything is not finite.
    pub(super) fn regulate(&self, state: &State<f32>) -> Option<Decision> {
        let torque_nm = self.lqr.torque(state, &self.setpoint);
        self.commands(torque_nm, self.setpoint.torque())
    }

    /// Commands for a constant torque; `None` if it is not finite.
    pub(super) fn constant(&self, torque_nm: [f32; JOINTS]) -> Option<Decision> {
        self.commands(torque_nm.into(), Vector2::zeros())
    }

    fn commands(&self, torque_nm: Vector2<f32>, balance_nm: Vector2<f32>) -> Option<Decision> {
        let [joint_a, joint_b] = &self.joints;
        let a = joint_a.command(torque_nm.x, balance_nm.x).ok()?;
        let b = joint_b.command(torque_nm.y, balance_nm.y).ok()?;
        Some(Decision {
            pwm: [a.pwm, b.pwm],
            torque_nm: Vector2::new(a.torque_nm, b.torque_nm),
        })
    }
}

/// What the servos are to be told, and the torque that it stands for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Decision {
    pub(super) pwm: [Pwm; JOINTS],
    /// In N m, after clamp and rounding, less what dry friction takes.
    pub(super) torque_nm: Vector2<f32>,
}

impl Decision {
    /// Motors off.
    pub(super) fn off() -> Self {
        Self {
            pwm: [Pwm::OFF; JOINTS],
            torque_nm: Vector2::zeros(),
        }
    }
}
