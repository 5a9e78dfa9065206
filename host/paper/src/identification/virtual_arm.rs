//! The paper's two experiments on a virtual arm: the simulator's body, sampled as in the
//! paper, every 45 ms by an encoder of 300°/1023 with 2 mrad of noise.
//!
//! Both leave the range of an encoder with 0 at its centre, and the free fall that of
//! the table: the paper turned the arm's base for it. This arm therefore has an unlimited
//! encoder and no obstacle.

use armbridge_control::actuator::Joint;
use armbridge_control::arm::{Parameters, State};
use armbridge_servo::JOINTS;
use armbridge_sim::plant::{Body, Friction};
use nalgebra::Vector2;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg32;

use super::sampled_experiment::{ExperimentKind, InitialState, SampledExperiment};
use crate::printed;

/// The paper's period in ns, section 4.
const PERIOD_NS: u64 = printed::PERIOD_US as u64 * 1000;

/// A virtual arm and its encoder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VirtualArm {
    /// True parameters.
    pub arm: Parameters<f64>,
    /// Dry friction of joint 1.
    pub friction: Friction,
    /// Standard deviation of the encoder's noise in rad.
    pub noise_rad: f64,
    /// Angle of an encoder count in rad, to which angles are rounded; 0: no rounding.
    pub count_rad: f64,
    /// Seed of the noise.
    pub seed: u64,
}

impl VirtualArm {
    /// The paper's arm with `b1` in N m s/rad and dry friction in N m; static friction is a
    /// quarter larger.
    pub fn paper(b1: f64, coulomb_nm: f64, seed: u64) -> Self {
        let friction = Friction {
            coulomb_nm,
            static_nm: super::motion::STATIC_RATIO * coulomb_nm,
            stribeck_rad_s: 0.0,
            load: 0.0,
        };
        Self {
            arm: Parameters {
                b1,
                ..Parameters::paper()
            },
            friction: if coulomb_nm > 0.0 {
                friction
            } else {
                Friction::NONE
            },
            noise_rad: 0.002,
            count_rad: Joint::<f64>::paper().rad_per_count,
            seed,
        }
    }

    /// The same arm with an encoder without noise and rounding.
    #[must_use]
    pub fn with_ideal_encoder(self) -> Self {
        Self {
            noise_rad: 0.0,
            count_rad: 0.0,
            ..self
        }
    }

    /// A free fall that may resemble the paper's, until the arm is at rest. The start angle
    /// is clearly beyond the breakaway angle.
    pub fn paper_fall(&self) -> SampledExperiment {
        /// Ratio of the start angle to the breakaway angle.
        const START_RATIO: f64 = 1.15;
        const DURATION_S: f64 = 4.0;

        self.free_fall(START_RATIO * self.breakaway_rad(), DURATION_S)
    }

    /// Angle in rad at which the gravity torque equals static friction; infinite if there is
    /// none.
    pub fn breakaway_rad(&self) -> f64 {
        let gravity_nm = -self.arm.gravity_slope(Vector2::zeros()).m11;
        let ratio = self.friction.static_nm / gravity_nm.abs();
        if ratio < 1.0 {
            ratio.asin()
        } else {
            f64::INFINITY
        }
    }

    /// Simulates a free fall from rest at `from_rad`.
    pub fn free_fall(&self, from_rad: f64, duration_s: f64) -> SampledExperiment {
        self.experiment(ExperimentKind::FreeFall, from_rad, 0.0, duration_s)
    }

    /// Simulates a push from [`PUSH_FROM_RAD`](super::PUSH_FROM_RAD) with a motor torque in N m.
    pub fn constant_input(&self, torque_nm: f64, duration_s: f64) -> SampledExperiment {
        self.experiment(
            ExperimentKind::ConstantInput,
            printed::PUSH_FROM_RAD,
            torque_nm,
            duration_s,
        )
    }

    fn experiment(
        &self,
        kind: ExperimentKind,
        from_rad: f64,
        torque_nm: f64,
        duration_s: f64,
    ) -> SampledExperiment {
        let initial = State::at_rest(Vector2::new(from_rad, 0.0));
        let stops = [[-100.0, 100.0]; JOINTS];
        let mut body = Body::new(self.arm, [self.friction; JOINTS], stops, initial);
        body.set_torque(0, Vector2::new(torque_nm, 0.0));
        let mut noise = Pcg32::new(self.seed, kind as u64);
        let samples = (duration_s * 1e9 / PERIOD_NS as f64).ceil() as u64;
        let angles = (0..samples).map(|k| {
            body.advance(k * PERIOD_NS);
            let draw: f64 = StandardNormal.sample(&mut noise);
            let angle_rad = body.state(k * PERIOD_NS).q.x + self.noise_rad * draw;
            Some(if self.count_rad > 0.0 {
                (angle_rad / self.count_rad).round() * self.count_rad
            } else {
                angle_rad
            })
        });
        SampledExperiment {
            kind,
            period_s: PERIOD_NS as f64 * 1e-9,
            angles_rad: angles.collect(),
            start_rad: from_rad,
            start: InitialState::Known,
            commanded_nm: (kind == ExperimentKind::ConstantInput).then_some(torque_nm),
        }
    }
}
