//! The paper's two experiments on a virtual arm: the bench's body, sampled as the paper
//! did, every 45 ms by an encoder of 300°/1023 with 2 mrad of noise.
//!
//! Both leave the range of an encoder that has 0 in its middle, and the free fall that of
//! the table: the paper turned the arm's foot for it. So here is no track that ends and
//! nothing in the way.

use armbridge_shared::JOINTS;
use armbridge_shared::actuator::Joint;
use armbridge_shared::arm::{Parameters, State};
use armbridge_sim::plant::{Body, Friction};
use nalgebra::Vector2;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg32;

use super::sampled::{Kind, Sampled, Start};
use crate::paper::printed;

/// The paper's period in ns, section 4.
const PERIOD_NS: u64 = printed::PERIOD_US as u64 * 1000;

/// A virtual arm and who looks at it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VirtualArm {
    /// As it truly is.
    pub arm: Parameters<f64>,
    /// Dry friction of joint 1.
    pub friction: Friction,
    /// Standard deviation of the encoder's noise in rad.
    pub noise_rad: f64,
    /// Angle of an encoder's count in rad, to which angles are rounded; 0: they are not.
    pub count_rad: f64,
    /// Of that noise.
    pub seed: u64,
}

impl VirtualArm {
    /// The paper's arm with this b1 in N m s/rad and this dry friction in N m, a quarter
    /// more at rest.
    pub fn paper(b1: f64, coulomb_nm: f64, seed: u64) -> Self {
        let friction = Friction {
            coulomb_nm,
            static_nm: super::motion::STATIC_RATIO * coulomb_nm,
            stribeck_rad_s: 0.0,
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

    /// The same, seen exactly.
    #[must_use]
    pub fn seen_exactly(self) -> Self {
        Self {
            noise_rad: 0.0,
            count_rad: 0.0,
            ..self
        }
    }

    /// A free fall as the paper's may have been, until it is at rest: let go as far beyond
    /// where static friction does as to be sure.
    pub fn paper_fall(&self) -> Sampled {
        /// Where it is let go, over where it would be loose.
        const BEYOND_LOOSE: f64 = 1.15;
        const DURATION_S: f64 = 4.0;

        self.free_fall(BEYOND_LOOSE * self.loose_rad(), DURATION_S)
    }

    /// Angle in rad at which gravity just overcomes static friction; infinite if it never
    /// does.
    pub fn loose_rad(&self) -> f64 {
        let gravity_nm = -self.arm.gravity_slope(Vector2::zeros()).m11;
        let share = self.friction.static_nm / gravity_nm.abs();
        if share < 1.0 {
            share.asin()
        } else {
            f64::INFINITY
        }
    }

    /// Lets go at `from_rad`.
    pub fn free_fall(&self, from_rad: f64, duration_s: f64) -> Sampled {
        self.experiment(Kind::FreeFall, from_rad, 0.0, duration_s)
    }

    /// Pushes from [`PUSH_FROM_RAD`](super::PUSH_FROM_RAD) with a motor torque in N m.
    pub fn constant_input(&self, torque_nm: f64, duration_s: f64) -> Sampled {
        self.experiment(
            Kind::ConstantInput,
            printed::PUSH_FROM_RAD,
            torque_nm,
            duration_s,
        )
    }

    fn experiment(&self, kind: Kind, from_rad: f64, torque_nm: f64, duration_s: f64) -> Sampled {
        let initial = State::at_rest(Vector2::new(from_rad, 0.0));
        let stops = [[-100.0, 100.0]; JOINTS];
        let mut body = Body::new(self.arm, [self.friction; JOINTS], stops, initial);
        body.set_torque(0, Vector2::new(torque_nm, 0.0));
        let mut noise = Pcg32::new(self.seed, kind as u64);
        let samples = (duration_s * 1e9 / PERIOD_NS as f64).ceil() as u64;
        let angles = (0..samples).map(|k| {
            body.advance(k * PERIOD_NS);
            let drawn: f64 = StandardNormal.sample(&mut noise);
            let seen = body.state(k * PERIOD_NS).q.x + self.noise_rad * drawn;
            Some(if self.count_rad > 0.0 {
                (seen / self.count_rad).round() * self.count_rad
            } else {
                seen
            })
        });
        Sampled {
            kind,
            period_s: PERIOD_NS as f64 * 1e-9,
            angles_rad: angles.collect(),
            start_rad: from_rad,
            start: Start::Known,
            told_nm: (kind == Kind::ConstantInput).then_some(torque_nm),
        }
    }
}
