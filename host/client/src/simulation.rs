//! Truth of a simulated arm: its state and the torques on it, as no board can measure them.
//!
//! A simulation passes it to the [`Tap`](crate::Tap)s of its link. Times are those of the
//! simulation, in ns, on the same clock as the link's.

use armbridge_servo::JOINTS;
use serde::{Deserialize, Serialize};

/// External torque on a joint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Push {
    /// Joint, counting from 0.
    pub joint: usize,
    /// Torque, in N m.
    pub torque_nm: f64,
    /// Start, in ns.
    pub start_ns: u64,
    /// Duration, in ns.
    pub duration_ns: u64,
}

/// Hand that leads the arm through a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Lead {
    /// Link, stiffness and damping.
    pub grip: Grip,
    /// Start in ns: it grasps the arm where it is then.
    pub start_ns: u64,
    /// Points of its path, in order of time.
    pub path: Vec<LeadPoint>,
    /// Time in ns after the start at which it lets go.
    pub release_ns: u64,
}

/// Point of a hand's path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeadPoint {
    /// Time in ns after the start.
    pub after_ns: u64,
    /// Joint angles in rad.
    pub angle_rad: [f64; JOINTS],
}

/// Spring and damper by which a hand holds the end of a link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grip {
    /// Link, counting from 0.
    pub link: usize,
    /// Stiffness in N/m.
    pub stiffness_n_m: f64,
    /// Damping in N s/m.
    pub damping_n_s_m: f64,
}

/// State of the arm at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TrueState {
    /// The instant, in ns.
    pub at_ns: u64,
    /// Angles in rad.
    pub angle_rad: [f32; JOINTS],
    /// Speeds in rad/s.
    pub speed_rad_s: [f32; JOINTS],
    /// Torques of the motors in N m.
    pub torque_nm: [f32; JOINTS],
    /// Torques of dry friction in N m, with the sign of their effect.
    pub friction_nm: [f32; JOINTS],
    /// External torques in N m.
    pub push_nm: [f32; JOINTS],
}

/// Event of a simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SimulationEvent {
    /// State when the board ran because its time had come, as at the start of a tick.
    State(TrueState),
    /// A push begins.
    Push(Push),
}
