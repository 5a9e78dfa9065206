//! A step of the integration: Runge-Kutta of fourth order, cut where a joint reverses, breaks away or
//! meets a stop.

use armbridge_control::arm::{Posture, State};
use armbridge_servo::JOINTS;

use super::friction::Contact;
use super::{Body, Impact};

/// Limit of the reversals of joints within a step. The rest of a step with more is
/// skipped; the motion in it is small.
const REVERSALS_MAX: usize = 4;

impl Body {
    /// One step, at most that of the grid.
    pub(super) fn step(&mut self, to_ns: u64) {
        if to_ns <= self.time_ns {
            return;
        }
        let step_s = (to_ns - self.time_ns) as f64 * 1e-9;
        self.time_ns = to_ns;
        if self.still {
            return;
        }
        let mut rest_s = step_s;
        for _ in 0..REVERSALS_MAX {
            self.break_away(rest_s);
            if self.contact == [Contact::Stuck; JOINTS] {
                // A hand that moves may free it at any time.
                self.still = self.grasp.is_none();
                return;
            }
            let next = self.runge_kutta(rest_s, rest_s);
            let Some((joint, reversal_s)) = self.first_reversal(&next, rest_s) else {
                self.state = next;
                self.stop_and_stick();
                return;
            };
            self.state = self.runge_kutta(reversal_s, rest_s);
            self.state.dq[joint] = 0.0;
            self.stop_and_stick();
            rest_s -= reversal_s;
        }
    }

    /// First sliding joint whose speed changes sign before `next`, and the time of that, in s.
    fn first_reversal(&self, next: &State<f64>, step_s: f64) -> Option<(usize, f64)> {
        let reversals = (0..JOINTS).filter_map(|joint| {
            let Contact::Sliding(direction) = self.contact[joint] else {
                return None;
            };
            let (from, to) = (self.state.dq[joint], next.dq[joint]);
            (from * direction > 0.0 && to * direction < 0.0).then(|| {
                // Speed is nearly linear over a step: one more step of the secant is exact.
                let per_s = (to - from) / step_s;
                let near_s = -from / per_s;
                let reversal_s = near_s - self.runge_kutta(near_s, step_s).dq[joint] / per_s;
                (joint, reversal_s.clamp(0.0, step_s))
            })
        });
        reversals.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Releases stuck joints whose torque exceeds static friction.
    pub(super) fn break_away(&mut self, before_s: f64) {
        if !self.contact.contains(&Contact::Stuck) {
            return;
        }
        let State { q, dq } = self.state;
        let posture = Posture::of(q);
        let applied_nm = self.applied_nm(&self.state, before_s);
        let acceleration = posture.forward_dynamics(&self.arm, dq, applied_nm);
        let push_nm = posture
            .mass_diagonal(&self.arm)
            .component_mul(&acceleration);
        let load_nm = self.load_friction_nm(&self.state, applied_nm);
        for joint in 0..JOINTS {
            let (angle, push) = (self.state.q[joint], push_nm[joint]);
            let [lowest, highest] = self.stops_rad[joint];
            let blocked = (angle <= lowest && push < 0.0) || (angle >= highest && push > 0.0);
            if self.contact[joint] == Contact::Stuck
                && push.abs() > self.friction[joint].static_nm + load_nm[joint]
                && !blocked
            {
                self.contact[joint] = Contact::Sliding(push.signum());
            }
        }
    }

    /// The state after `step_s`, from one that is `before_s` before the end of the step.
    fn runge_kutta(&self, step_s: f64, before_s: f64) -> State<f64> {
        let at = |speed: &State<f64>, seconds: f64| State {
            q: self.state.q + speed.q * seconds,
            dq: self.state.dq + speed.dq * seconds,
        };
        let half_s = 0.5 * step_s;
        let k1 = self.derivative(&self.state, before_s);
        let k2 = self.derivative(&at(&k1, half_s), before_s - half_s);
        let k3 = self.derivative(&at(&k2, half_s), before_s - half_s);
        let k4 = self.derivative(&at(&k3, step_s), before_s - step_s);
        let mean = State {
            q: k1.q + (k2.q + k3.q) * 2.0 + k4.q,
            dq: k1.dq + (k2.dq + k3.dq) * 2.0 + k4.dq,
        };
        at(&mean, step_s / 6.0)
    }

    /// Speeds and accelerations in a state so long before the end of the step.
    pub(super) fn derivative(&self, state: &State<f64>, before_s: f64) -> State<f64> {
        let mut torque = self.applied_nm(state, before_s);
        let load_nm = self.load_friction_nm(state, torque);
        for joint in 0..JOINTS {
            if let Contact::Sliding(direction) = self.contact[joint] {
                let sliding_nm = self.friction[joint].sliding_nm(state.dq[joint]);
                torque[joint] -= direction * (sliding_nm + load_nm[joint]);
            }
        }
        let mut derivative = State {
            q: state.dq,
            dq: self.arm.acceleration(state, torque),
        };
        for joint in 0..JOINTS {
            if self.contact[joint] == Contact::Stuck {
                derivative.q[joint] = 0.0;
                derivative.dq[joint] = 0.0;
            }
        }
        derivative
    }

    /// Ends the motion of joints that met a stop or whose speed changed sign.
    fn stop_and_stick(&mut self) {
        let before = self.state;
        for joint in 0..JOINTS {
            let (angle, speed) = (&mut self.state.q[joint], &mut self.state.dq[joint]);
            let [lowest, highest] = self.stops_rad[joint];
            let at_stop = (*angle <= lowest && *speed < 0.0) || (*angle >= highest && *speed > 0.0);
            *angle = angle.clamp(lowest, highest);
            let speed_rad_s = speed.abs();
            let fastest = self.impact.map_or(0.0, |impact| impact.speed_rad_s);
            if at_stop && speed_rad_s > fastest {
                self.impact = Some(Impact {
                    joint,
                    speed_rad_s,
                    energy_j: self.arm.energy(&before),
                });
            }
            match self.contact[joint] {
                Contact::Sliding(direction) if at_stop || *speed * direction <= 0.0 => {
                    *speed = 0.0;
                    self.contact[joint] = Contact::Stuck;
                }
                _ if at_stop => *speed = 0.0,
                _ => {}
            }
        }
    }
}
