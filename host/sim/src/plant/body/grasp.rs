//! Grasp of a hand: a spring and a damper between the end of a link and a hand that moves.
//!
//! ```text
//! force  = stiffness (hand - end) + damping (hand speed - end speed)      in N
//! torque = J' force                                                       in N m
//! ```
//!
//! Hand and end are points in space: the hand is where the end of the link would be at its
//! joint angles, which go from one point of its path to the next at constant speed, with ramps of
//! [`RAMP_S`] at either end.
//!
//! ```text
//! end of link 2 = ( l2 sin q2, sin q1 (l1 + l2 cos q2), cos q1 (l1 + l2 cos q2) )    in m
//! ```

use armbridge_client::simulation::Grip;
use armbridge_control::arm::{Parameters, State};
use nalgebra::{Matrix3x2, Vector2, Vector3};

/// Time in s in which a hand reaches its speed, and comes to rest.
const RAMP_S: f64 = 0.15;

/// A hand on its way from one point of its path to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grasp {
    grip: Grip,
    from_rad: Vector2<f64>,
    to_rad: Vector2<f64>,
    start_s: f64,
    duration_s: f64,
}

impl Grasp {
    /// A hand that begins to move at `start_ns`.
    pub(crate) fn new(
        grip: Grip,
        from_rad: Vector2<f64>,
        to_rad: Vector2<f64>,
        start_ns: u64,
        duration_ns: u64,
    ) -> Self {
        Self {
            grip,
            from_rad,
            to_rad,
            start_s: start_ns as f64 * 1e-9,
            duration_s: duration_ns as f64 * 1e-9,
        }
    }

    /// Angles to which it moves, in rad.
    pub(crate) fn end_rad(&self) -> Vector2<f64> {
        self.to_rad
    }

    /// Angles and speeds of the hand.
    fn state(&self, at_s: f64) -> State<f64> {
        let ramp_s = RAMP_S.min(0.5 * self.duration_s);
        let since_s = (at_s - self.start_s).clamp(0.0, self.duration_s);
        let left_s = self.duration_s - since_s;
        let per_s = 1.0 / (self.duration_s - ramp_s);
        // Share of the way, and share of the full speed.
        let (share, speed) = if since_s < ramp_s {
            (0.5 * since_s * since_s / ramp_s, since_s / ramp_s)
        } else if left_s < ramp_s {
            (
                self.duration_s - ramp_s - 0.5 * left_s * left_s / ramp_s,
                left_s / ramp_s,
            )
        } else {
            (since_s - 0.5 * ramp_s, 1.0)
        };
        let way = self.to_rad - self.from_rad;
        State {
            q: self.from_rad + way * (share * per_s),
            dq: way * (speed * per_s),
        }
    }

    /// Torque on the joints of an arm in this state, in N m.
    pub(super) fn torque_nm(
        &self,
        arm: &Parameters<f64>,
        state: &State<f64>,
        at_s: f64,
    ) -> Vector2<f64> {
        let hand = self.state(at_s);
        let link = self.grip.link;
        let (hand_end, end) = (End::of(arm, link, hand.q), End::of(arm, link, state.q));
        let force_n = (hand_end.at_m - end.at_m) * self.grip.stiffness_n_m
            + (hand_end.jacobian * hand.dq - end.jacobian * state.dq) * self.grip.damping_n_s_m;
        end.jacobian.transpose() * force_n
    }
}

/// End of a link: its place in m, and the slope of that in the angles.
struct End {
    at_m: Vector3<f64>,
    jacobian: Matrix3x2<f64>,
}

impl End {
    fn of(arm: &Parameters<f64>, link: usize, q: Vector2<f64>) -> Self {
        let ((sin1, cos1), (sin2, cos2)) = (q.x.sin_cos(), q.y.sin_cos());
        let l2 = if link == 0 { 0.0 } else { arm.l2 };
        let reach = arm.l1 + l2 * cos2;
        Self {
            at_m: Vector3::new(l2 * sin2, sin1 * reach, cos1 * reach),
            #[rustfmt::skip]
            jacobian: Matrix3x2::new(
                0.0, l2 * cos2,
                cos1 * reach, -sin1 * l2 * sin2,
                -sin1 * reach, -cos1 * l2 * sin2,
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_jacobian_is_the_slope_of_the_end() {
        let arm = Parameters::<f64>::paper();
        for link in 0..2 {
            let q = Vector2::new(0.4, -0.7);
            let end = End::of(&arm, link, q);
            for joint in 0..2 {
                let mut ahead = q;
                ahead[joint] += 1e-6;
                let slope = (End::of(&arm, link, ahead).at_m - end.at_m) / 1e-6;
                assert!((slope - end.jacobian.column(joint)).norm() < 1e-6);
            }
        }
    }

    /// A hand that holds the arm away from its place pulls it there with its stiffness.
    #[test]
    fn a_hand_pulls_to_its_place() {
        let arm = Parameters::<f64>::paper();
        let grip = Grip {
            link: 1,
            stiffness_n_m: 100.0,
            damping_n_s_m: 10.0,
        };
        let at = Vector2::new(0.01, 0.0);
        let grasp = Grasp::new(grip, Vector2::zeros(), at, 0, 1_000);
        let torque_nm = grasp.torque_nm(&arm, &State::at_rest(Vector2::zeros()), 1.0);
        let reach = arm.l1 + arm.l2;
        assert!(
            (torque_nm.x - 100.0 * reach * reach * 0.01).abs() < 1e-5,
            "{torque_nm}"
        );
        assert!(torque_nm.y.abs() < 1e-12);
    }
}
