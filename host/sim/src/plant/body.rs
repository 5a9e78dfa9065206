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
mod step;

use armbridge_control::arm::{Parameters, Posture, State};
use armbridge_control::controller::friction::gear_torque;
use armbridge_servo::JOINTS;
use nalgebra::Vector2;

pub use friction::Friction;
use friction::{Contact, contact_of};
use grasp::Grasp;

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
        let load_nm = copy.load_friction_nm(&copy.state, applied_nm);
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

    /// Dry friction of the torque that the gears transmit in a state, in N m, under this torque of
    /// motors, pushes and hands.
    fn load_friction_nm(&self, state: &State<f64>, applied_nm: Vector2<f64>) -> Vector2<f64> {
        let load = self.friction.map(|friction| friction.load);
        if load.iter().all(|load| *load <= 0.0) {
            return Vector2::zeros();
        }
        let hand_nm = applied_nm - self.torque_nm;
        let motor_nm = self.torque_nm - self.external_nm;
        let gears_nm = gear_torque(&self.arm, &Posture::of(state.q), state, motor_nm);
        let transmitted_nm = gears_nm - (hand_nm + self.external_nm);
        transmitted_nm.abs().component_mul(&Vector2::from(load))
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
}

#[cfg(test)]
mod tests;
