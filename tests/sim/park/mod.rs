//! Park: arms that differ from the board's model are moved to a pose and lowered there, whatever
//! ends the drive.

mod ends;
mod hidden_arms;

use armbridge_board::bridge::limits::PARK_US;
use armbridge_control::arm::State;
use armbridge_link::limits::Milliradians;
use armbridge_link::message::{Limits, Setup};
use armbridge_servo::JOINTS;
use armbridge_sim::plant::PlantConfig;
use nalgebra::Vector2;

/// Relative spread of the drawn parameters.
const SPREAD: f64 = 0.2;
/// Largest speed in rad/s with which a parked arm may meet the table.
const CONTACT_RAD_S: f64 = 0.3;
/// Angle in rad from which on the first joint is about to meet the table, at π/2.
const NEAR_TABLE_RAD: f64 = 1.5;
/// Longest duration of a park, in ms.
const PARK_MS: u64 = PARK_US / 1_000;

/// A hidden arm that stands, and the set-up of a board that knows no more of it than the way its
/// servos turn.
fn hidden(seed: u64) -> (PlantConfig, Setup) {
    let drawn = PlantConfig::drawn(seed, SPREAD);
    let mut setup = Setup::default();
    for (joint, true_joint) in setup.joints.iter_mut().zip(drawn.joints) {
        joint.direction = true_joint.direction;
    }
    let config = PlantConfig {
        initial: State::at_rest(Vector2::new(0.05, -0.05)),
        ..drawn
    };
    (config, setup)
}

/// These limits with a pose in rad.
fn with_pose(limits: Limits, pose_rad: [f32; JOINTS]) -> Limits {
    Limits {
        park: Some(pose_rad.map(|rad| Milliradians((rad * 1e3).round() as i16))),
        ..limits
    }
}
