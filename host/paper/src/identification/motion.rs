//! Simulation of joint 1 over dual numbers, which gives each sample with its derivatives
//! with respect to the parameters and the initial state.
//!
//! Fourth-order Runge-Kutta. A joint begins to slide if the torque on it exceeds
//! its Coulomb friction: it did move, so its static friction was overcome. Where its speed
//! changes sign, the step is cut at that moment. There the joint sticks or reverses; the
//! angle at which it stops depends smoothly on all parameters because its speed there is 0.

use num_dual::DualNum;

use super::joint_parameters::JointParameters;

/// Longest step in s: at 5 ms the error is below 1e-7 rad.
const STEP_S: f64 = 0.005;
/// Ratio of static to Coulomb friction of a joint that has stopped.
pub(super) const STATIC_RATIO: f64 = 1.25;

/// A joint in motion.
struct Motion<'a, D> {
    parameters: &'a JointParameters<D>,
    torque_nm: D,
    /// Towards larger (1) or smaller (-1) angles; none while the joint sticks.
    direction: Option<f64>,
    q: D,
    v: D,
}

/// A simulated motion.
pub(super) struct Angles<D> {
    /// Angles in rad at each sample.
    pub(super) rad: Vec<D>,
    /// The joint sticks at the start, so no parameter has an effect.
    pub(super) sticks: bool,
}

/// Simulates `samples` angles from an initial angle in rad and speed in rad/s, with or
/// without the motor torque of the parameters.
pub(super) fn simulate<D: DualNum<Primitive = f64> + Copy>(
    parameters: &JointParameters<D>,
    is_pushed: bool,
    [start_rad, start_rad_s]: [D; 2],
    period_s: f64,
    samples: usize,
) -> Angles<D> {
    let steps = (period_s / STEP_S).ceil().max(1.0);
    let torque_nm = if is_pushed {
        parameters.torque_nm
    } else {
        D::from(0.0)
    };
    let mut motion = Motion {
        parameters,
        torque_nm,
        direction: None,
        q: start_rad,
        v: start_rad_s,
    };
    let speed = start_rad_s.re();
    motion.direction = if speed == 0.0 {
        motion.slide_direction(1.0)
    } else {
        Some(speed.signum())
    };
    let sticks = motion.direction.is_none();
    let mut rad = Vec::with_capacity(samples);
    for _ in 0..samples {
        rad.push(motion.q);
        for _ in 0..steps as u32 {
            motion.step(period_s / steps);
        }
    }
    Angles { rad, sticks }
}

impl JointParameters {
    /// Simulates times in s and angles in rad under the torque, from rest at `from_rad`.
    pub(crate) fn motion(
        self,
        from_rad: f64,
        period_s: f64,
        samples: usize,
    ) -> impl Iterator<Item = (f64, f64)> {
        let angles = simulate(&self, true, [from_rad, 0.0], period_s, samples);
        let angles = angles.rad.into_iter().enumerate();
        angles.map(move |(k, rad)| (k as f64 * period_s, rad))
    }
}

impl<D: DualNum<Primitive = f64> + Copy> Motion<'_, D> {
    /// Motor and gravity torque in N m.
    fn driving_torque(&self, q: D) -> D {
        self.torque_nm + self.parameters.gravity_nm * q.sin()
    }

    /// Direction in which a joint at rest begins to slide, if the driving torque exceeds
    /// `ratio` times its Coulomb friction.
    fn slide_direction(&self, ratio: f64) -> Option<f64> {
        let torque_nm = self.driving_torque(self.q).re();
        let holding_nm = ratio * self.parameters.coulomb_nm.re().max(0.0);
        (torque_nm.abs() > holding_nm).then(|| torque_nm.signum())
    }

    fn acceleration(&self, q: D, v: D, direction: f64) -> D {
        let JointParameters {
            b1,
            coulomb_nm,
            inertia_kg_m2,
            ..
        } = *self.parameters;
        (self.driving_torque(q) - b1 * v - coulomb_nm * direction) / inertia_kg_m2
    }

    /// Angle and speed after `h` seconds of sliding.
    fn slide(&self, direction: f64, h: f64) -> (D, D) {
        let acceleration = |q: D, v: D| self.acceleration(q, v, direction);
        let (q, v) = (self.q, self.v);
        let half = 0.5 * h;
        let a1 = acceleration(q, v);
        let v2 = v + a1 * half;
        let a2 = acceleration(q + v * half, v2);
        let v3 = v + a2 * half;
        let a3 = acceleration(q + v2 * half, v3);
        let v4 = v + a3 * h;
        let a4 = acceleration(q + v3 * h, v4);
        let sixth = h / 6.0;
        (
            q + (v + (v2 + v3) * 2.0 + v4) * sixth,
            v + (a1 + (a2 + a3) * 2.0 + a4) * sixth,
        )
    }

    fn step(&mut self, h: f64) {
        let Some(direction) = self.direction else {
            return;
        };
        let (q, v) = self.slide(direction, h);
        let before = self.v.re();
        if v.re() * direction >= 0.0 {
            (self.q, self.v) = (q, v);
            return;
        }
        // The time of zero speed: linear interpolation, then a Newton step.
        let estimate_s = h * before / (before - v.re());
        let (q, v) = self.slide(direction, estimate_s);
        let stop_s = estimate_s - (v / self.acceleration(q, v, direction)).re();
        (self.q, self.v) = self.slide(direction, stop_s);
        self.direction = self.slide_direction(STATIC_RATIO);
        match self.direction {
            None => self.v = D::from(0.0),
            Some(reversed) => {
                // At a reversal, the derivatives of speed through the time of the reversal
                // scale with the acceleration, which changes with the friction's sign.
                let rest = D::from(0.0);
                let before = self.acceleration(self.q, rest, direction).re();
                let after = self.acceleration(self.q, rest, reversed).re();
                self.v = (self.v - self.v.re()) * (after / before);
                (self.q, self.v) = self.slide(reversed, h - stop_s);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::joint_parameters::{COUNT, Unknown};
    use super::*;
    use armbridge_control::arm::{Parameters, State};
    use armbridge_servo::JOINTS;
    use armbridge_sim::plant::{Body, Friction};
    use nalgebra::Vector2;
    use num_dual::DualSVec64;

    const PERIOD_S: f64 = 0.045;

    /// Angles by the simulator's arm, with its own integration and dry friction.
    fn body(b1: f64, torque_nm: f64, coulomb_nm: f64, start_rad: f64) -> Vec<f64> {
        let arm = Parameters {
            b1,
            ..Parameters::paper()
        };
        let friction = Friction {
            coulomb_nm,
            static_nm: STATIC_RATIO * coulomb_nm,
            stribeck_rad_s: 0.0,
            load: 0.0,
        };
        let initial = State::at_rest(Vector2::new(start_rad, 0.0));
        let mut body = Body::new(arm, [friction; JOINTS], [[-9.0, 9.0]; JOINTS], initial);
        body.set_torque(0, Vector2::new(torque_nm, 0.0));
        let angle = |k: u64| {
            body.advance(k * 45_000_000);
            body.state(k * 45_000_000).q.x
        };
        (0..112).map(angle).collect()
    }

    fn parameters(b1: f64, torque_nm: f64, coulomb_nm: f64) -> JointParameters {
        JointParameters {
            b1,
            torque_nm,
            coulomb_nm,
            ..JointParameters::from_arm(&Parameters::paper())
        }
    }

    /// Small friction, which lets the arm swing back, to large friction.
    const CASES: [[f64; 4]; 6] = [
        [0.24, 0.0, 0.0, 0.1],
        [0.421, 0.0, 0.0, 0.1],
        [0.02, 0.0, 0.02, 2.0],
        [0.239, 0.0, 0.107, 0.27],
        [0.24, -0.3924, 0.0, 0.49],
        [0.24, -0.3924, 0.04, 0.49],
    ];

    #[test]
    fn it_moves_as_the_simulated_arm_does() {
        for [b1, torque_nm, coulomb_nm, start_rad] in CASES {
            let true_rad = body(b1, torque_nm, coulomb_nm, start_rad);
            // The simulator stops or reverses at the end of a step of 0.1 ms.
            let tolerance = if coulomb_nm > 0.0 { 3e-4 } else { 1e-6 };
            let parameters = parameters(b1, torque_nm, coulomb_nm);
            let model = simulate(
                &parameters,
                true,
                [start_rad, 0.0],
                PERIOD_S,
                true_rad.len(),
            );
            for (k, (model, truth)) in model.rad.iter().zip(&true_rad).enumerate() {
                let error = (model - truth).abs();
                assert!(
                    error < tolerance,
                    "{b1} {coulomb_nm} at sample {k}: {error:e}"
                );
            }
        }
    }

    #[test]
    fn slopes_are_those_of_the_motion_even_where_it_stops_or_turns() {
        for [b1, torque_nm, coulomb_nm, start_rad] in CASES {
            let at = parameters(b1, torque_nm, coulomb_nm);
            let lanes = Unknown::ALL.map(|unknown| {
                DualSVec64::<COUNT>::from_re(at.get(unknown)).derivative(unknown as usize)
            });
            let start = [start_rad, 0.0].map(DualSVec64::from_re);
            let exact = simulate(
                &JointParameters::from_array(lanes),
                true,
                start,
                PERIOD_S,
                112,
            );
            for unknown in Unknown::ALL {
                if at.get(unknown) == 0.0 {
                    continue;
                }
                let h = 1e-5 * at.get(unknown).abs();
                let moved = [h, -h].map(|h| {
                    let at = at.with(unknown, at.get(unknown) + h);
                    simulate(&at, true, [start_rad, 0.0], PERIOD_S, 112).rad
                });
                let largest = moved[0].iter().zip(&moved[1]);
                let largest = largest.map(|(a, b)| (a - b).abs() / (2.0 * h));
                let largest = largest.fold(0.0, f64::max);
                for (k, angle) in exact.rad.iter().enumerate() {
                    let slope = angle.eps.0.map_or(0.0, |eps| eps[unknown as usize]);
                    let difference = (moved[0][k] - moved[1][k]) / (2.0 * h);
                    let error = (slope - difference).abs() / largest;
                    assert!(
                        error < 1e-3,
                        "{unknown:?} at {k}: {slope}, not {difference}"
                    );
                }
            }
        }
    }

    #[test]
    fn it_sticks_where_friction_holds_it() {
        let stuck = simulate(&parameters(0.24, 0.0, 0.1), false, [0.1, 0.0], PERIOD_S, 10);
        assert!(stuck.sticks && stuck.rad.iter().all(|q| (q - 0.1).abs() <= 0.0));
    }
}
