//! Float: arms that differ from the board's model stay where they are left, and are led by hand.
//!
//! Hidden arms are drawn: each of their parameters is up to a fifth off what the board believes.
//! The hand is a spring of 300 N/m and a damper of 10 N s/m at the end of link 2.

mod hands;
mod led;
mod taught;

use armbridge_analysis::plan_runner::Script;
use armbridge_control::arm::State;
use armbridge_link::message::{Command, Setup};
use armbridge_servo::JOINTS;
use armbridge_sim::plant::{Grip, Lead, LeadPoint, PlantConfig};
use armbridge_tests::random::Random;
use nalgebra::Vector2;

/// Relative spread of the drawn parameters.
const SPREAD: f64 = 0.2;
/// One encoder count of an AX-12A in rad: 300 degrees over 1023.
const COUNT_RAD: f64 = 300.0 / 1023.0 * std::f64::consts::PI / 180.0;

/// A hidden arm at rest anywhere within 1 rad, and the set-up of a board that knows no more of it
/// than the way its servos turn.
fn hidden(seed: u64, base: Setup) -> (PlantConfig, Setup) {
    let drawn = PlantConfig::drawn(seed, SPREAD);
    let mut setup = base;
    for (joint, true_joint) in setup.joints.iter_mut().zip(drawn.joints) {
        joint.direction = true_joint.direction;
    }
    let mut random = Random::new(seed | 1 << 32);
    let initial = [(); JOINTS].map(|()| random.below(2_001) as f64 * 1e-3 - 1.0);
    let config = PlantConfig {
        initial: State::at_rest(Vector2::from(initial)),
        ..drawn
    };
    (config, setup)
}

/// A script that floats for so long.
fn floating(setup: Setup, duration_us: u64) -> Script {
    Script {
        setup,
        limits: Script::limits(),
        commands: vec![(0, Command::Float)],
        duration_us,
    }
}

/// Time in ns from one point of a hand's path to the next: 0.5 rad at 0.5 rad/s, with its ramps.
const LEG_NS: u64 = 1_150_000_000;

/// A hand that leads link 2 through these angles in rad, and lets go after `release_ns`.
fn lead(start_ns: u64, path: &[[f64; JOINTS]], release_ns: u64) -> Lead {
    let points = (1..).zip(path).map(|(leg, angle_rad)| LeadPoint {
        after_ns: leg * LEG_NS,
        angle_rad: *angle_rad,
    });
    Lead {
        grip: Grip {
            link: 1,
            stiffness_n_m: 300.0,
            damping_n_s_m: 10.0,
        },
        start_ns,
        path: points.collect(),
        release_ns,
    }
}
