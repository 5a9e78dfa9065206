//! The rigid arm with dry friction and end stops, under a given torque.
//!
//! # Time
//!
//! Runge-Kutta of fourth order on a fixed grid, by default of [`STEP_NS`]. The torque is
//! constant between changes, and a change off the grid cuts the step there; the
//! next step ends on the grid again. A state between grid points is
//! computed by a partial step that is then discarded. So the motion depends only on the
//! torque and the times of its changes, never on the times of readings: splitting an
//! advance in two gives the same bits.
//!
//! # Dry friction
//!
//! After Karnopp, with the crossing of zero speed in the place of a speed
//! threshold. A sliding joint feels its Coulomb torque against its motion. In the moment in
//! which its speed changes sign, within a step, it stops, and sticks for as long as the rest
//! of the torque stays within the static one: truly at rest, no creep. It breaks
//! away in the direction of that rest. After Stribeck, friction of a sliding joint
//! may come down from the static torque to the Coulomb one as it gets faster,
//! instead of at once. Because M(q) is diagonal, a stuck joint
//! passes nothing on to the other but its angle.
//!
//! # End stops
//!
//! Inelastic: a joint that reaches one loses its speed and stays there while it
//! is pushed against it.
//!
//! # Hand
//!
//! A [grasp] adds the torque of a spring and damper between the end of a link and a hand that
//! moves. It is computed at each stage of a step, from state and time.

mod friction;
pub mod grasp;

use armbridge_control::arm::{Parameters, Posture, State};
use armbridge_servo::JOINTS;
use nalgebra::Vector2;

pub use friction::Friction;
use friction::{Contact, contact_of};
use grasp::Grasp;

/// Limit of the reversals of joints within a step. The rest of a step with more is
/// skipped; the motion in it is small.
const REVERSALS_MAX: usize = 4;
/// Default grid of the integration, in ns.
pub const STEP_NS: u64 = 100_000;

/// A joint's collision with one of its stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// Joint, counting from 0.
    pub joint: usize,
    /// Speed that the joint lost, in rad/s.
    pub speed_rad_s: f64,
    /// Energy of the arm before, kinetic and potential, in J.
    pub energy_j: f64,
}

/// The arm's mechanics.
#[derive(Clone, Copy, Debug)]
pub struct Body {
    arm: Parameters<f64>,
    friction: [Friction; JOINTS],
    stops_rad: [[f64; 2]; JOINTS],
    /// Grid of the integration.
    step_ns: u64,
    time_ns: u64,
    state: State<f64>,
    contact: [Contact; JOINTS],
    torque_nm: Vector2<f64>,
    /// Part of the torque that is not the motors'.
    external_nm: Vector2<f64>,
    grasp: Option<Grasp>,
    /// All joints are at rest until the torque changes.
    still: bool,
    /// Fastest impact since the last call of [`Body::take_impact`].
    impact: Option<Impact>,
}

impl Body {
    /// The arm at time zero, without torque. `stops_rad` are the smallest and largest
    /// angle of each joint.
    pub fn new(
        arm: Parameters<f64>,
        friction: [Friction; JOINTS],
        stops_rad: [[f64; 2]; JOINTS],
        initial: State<f64>,
    ) -> Self {
        let contact = contact_of(&friction, &initial);
        Self {
            arm,
            friction,
            stops_rad,
            step_ns: STEP_NS,
            time_ns: 0,
            state: initial,
            contact,
            torque_nm: Vector2::zeros(),
            external_nm: Vector2::zeros(),
            grasp: None,
            still: false,
            impact: None,
        }
    }

    /// The same on another grid, of at least 1 ns.
    #[must_use]
    pub(super) fn with_step(self, step_ns: u64) -> Self {
        Self { step_ns, ..self }
    }

    /// The fastest impact since the last call, up to the last grid point.
    pub fn take_impact(&mut self) -> Option<Impact> {
        self.impact.take()
    }

    /// Advances to the last grid point that is not after `to_ns`.
    pub fn advance(&mut self, to_ns: u64) {
        while let Some(next_ns) = self.next_grid_point().filter(|&next| next <= to_ns) {
            self.step(next_ns);
            if self.still {
                self.time_ns = to_ns;
            }
        }
    }

    /// Angles and speeds at `at_ns`, which is not before the last change.
    pub fn state(&self, at_ns: u64) -> State<f64> {
        let mut copy = *self;
        copy.advance(at_ns);
        copy.step(at_ns);
        copy.state
    }

    /// The same, and the torque of dry friction in N m; that of a joint at rest is the one
    /// that keeps it there.
    pub fn state_and_friction(&self, at_ns: u64) -> (State<f64>, Vector2<f64>) {
        let mut copy = *self;
        copy.advance(at_ns);
        copy.step(at_ns);
        copy.break_away(0.0);
        let applied_nm = copy.applied_nm(&copy.state, 0.0);
        let free = copy.arm.acceleration(&copy.state, applied_nm);
        let acceleration = copy.derivative(&copy.state, 0.0).dq;
        let reaction_nm = copy.arm.mass(copy.state.q) * (acceleration - free);
        let load_nm = copy.load_friction_nm(&copy.state, 0.0);
        // The rest of it is that of an end stop.
        let friction_nm = Vector2::from_fn(|joint, _| {
            let Friction {
                coulomb_nm,
                static_nm,
                ..
            } = copy.friction[joint];
            let most_nm = static_nm.max(coulomb_nm) + load_nm[joint];
            reaction_nm[joint].clamp(-most_nm, most_nm)
        });
        (copy.state, friction_nm)
    }

    /// The joint torque from `at_ns` on, all of it the motors'.
    pub fn set_torque(&mut self, at_ns: u64, torque_nm: Vector2<f64>) {
        self.set_torques(at_ns, torque_nm, Vector2::zeros());
    }

    /// The joint torque from `at_ns` on, of motors and pushes.
    pub(super) fn set_torques(
        &mut self,
        at_ns: u64,
        motor_nm: Vector2<f64>,
        push_nm: Vector2<f64>,
    ) {
        let torque_nm = motor_nm + push_nm;
        if torque_nm != self.torque_nm || push_nm != self.external_nm {
            self.advance(at_ns);
            self.step(at_ns);
            self.torque_nm = torque_nm;
            self.external_nm = push_nm;
            self.still = false;
        }
    }

    /// The grasp of a hand from `at_ns` on, if there is one.
    pub(super) fn set_grasp(&mut self, at_ns: u64, grasp: Option<Grasp>) {
        self.advance(at_ns);
        self.step(at_ns);
        self.grasp = grasp;
        self.still = false;
    }

    /// The grasp of a hand.
    pub(super) fn grasp(&self) -> Option<&Grasp> {
        self.grasp.as_ref()
    }

    /// Torque of the hand on the joints at `at_ns`, in N m.
    pub(super) fn hand_nm(&self, at_ns: u64) -> Vector2<f64> {
        self.grasp.map_or_else(Vector2::zeros, |grasp| {
            grasp.torque_nm(&self.arm, &self.state(at_ns), at_ns as f64 * 1e-9)
        })
    }

    /// Torque of motors, pushes and hand on the joints in N m, in a state so long before the end
    /// of the step.
    fn applied_nm(&self, state: &State<f64>, before_s: f64) -> Vector2<f64> {
        match &self.grasp {
            Some(grasp) => {
                let at_s = self.time_ns as f64 * 1e-9 - before_s;
                self.torque_nm + grasp.torque_nm(&self.arm, state, at_s)
            }
            None => self.torque_nm,
        }
    }

    /// Dry friction of the torque that the gears transmit, in N m, in a state so long before the
    /// end of the step.
    fn load_friction_nm(&self, state: &State<f64>, before_s: f64) -> Vector2<f64> {
        let load = self.friction.map(|friction| friction.load);
        if load.iter().all(|load| *load <= 0.0) {
            return Vector2::zeros();
        }
        // Torques of pushes and hands are in the applied ones once, with the other sign.
        let external_nm = self.applied_nm(state, before_s) - self.torque_nm + self.external_nm;
        let motor_nm = self.torque_nm - self.external_nm - self.arm.viscous_torque(state.dq);
        let gears_nm = motor_nm + self.arm.gravity(state.q) - external_nm;
        gears_nm.abs().component_mul(&Vector2::from(load))
    }

    /// Advances time without motion: the arm is held.
    pub(super) fn hold(&mut self, until_ns: u64) {
        self.time_ns = self.time_ns.max(until_ns);
    }

    /// Advances time, and sets angles and speeds, within the stops: a hand guides the arm.
    pub(super) fn guide(&mut self, until_ns: u64, mut state: State<f64>) {
        for joint in 0..JOINTS {
            let [lowest, highest] = self.stops_rad[joint];
            let free = state.q[joint];
            state.q[joint] = free.clamp(lowest, highest);
            if free.to_bits() != state.q[joint].to_bits() {
                state.dq[joint] = 0.0;
            }
        }
        self.hold(until_ns);
        self.state = state;
        self.contact = contact_of(&self.friction, &state);
        self.still = false;
    }

    /// Whether it was last in exactly this state.
    pub(super) fn rests_at(&self, state: &State<f64>) -> bool {
        self.state == *state
    }

    /// Joint torque in force, in N m.
    pub fn torque(&self) -> Vector2<f64> {
        self.torque_nm
    }

    fn next_grid_point(&self) -> Option<u64> {
        (self.time_ns / self.step_ns + 1).checked_mul(self.step_ns)
    }

    /// One step, at most that of the grid.
    fn step(&mut self, to_ns: u64) {
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
    fn break_away(&mut self, before_s: f64) {
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
        let load_nm = self.load_friction_nm(&self.state, before_s);
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

    fn derivative(&self, state: &State<f64>, before_s: f64) -> State<f64> {
        let mut torque = self.applied_nm(state, before_s);
        let load_nm = self.load_friction_nm(state, before_s);
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

#[cfg(test)]
mod tests;
