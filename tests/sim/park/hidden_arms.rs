//! Hidden arms that are parked by command.

use super::{CONTACT_RAD_S, NEAR_TABLE_RAD, PARK_MS, hidden, with_pose};
use armbridge_analysis::plan_runner::Script;
use armbridge_board::bridge::Channels;
use armbridge_control::arm::State;
use armbridge_link::message::{Command, Drive, Mode};
use armbridge_servo::JOINTS;
use armbridge_tests::bench_run;
use armbridge_tests::random::Random;
use nalgebra::Vector2;

/// Number of arms.
const ARMS: u64 = 40;
/// Time of the command to park, in ms.
const COMMANDED_MS: u64 = 1_000;

/// A park, as the true arm shows it.
struct Parked {
    lasted_ms: usize,
    contact_rad_s: f64,
    end: State<f64>,
    mode: Mode,
}

fn park(seed: u64, drive: Command, pose_rad: [f32; JOINTS]) -> Parked {
    let (config, setup) = hidden(seed);
    let until_ms = COMMANDED_MS + PARK_MS + 500;
    let script = Script {
        setup,
        limits: with_pose(Script::limits(), pose_rad),
        commands: vec![(0, drive), (COMMANDED_MS * 1_000, Command::Park)],
        duration_us: until_ms * 1_000,
    };
    let mut channels = Channels::new();
    let mut run = bench_run(&mut channels, config, seed, script);
    let mut contact_rad_s = 0.0_f64;
    for at_us in (0..until_ms).map(|ms| ms * 1_000) {
        while run.now_us() < at_us {
            run.step_until(at_us).unwrap();
        }
        let state = run.bench.plant().state();
        if state.q.x.abs() > NEAR_TABLE_RAD {
            contact_rad_s = contact_rad_s.max(state.dq.amax());
        }
    }
    let end = run.bench.plant().state();
    let records = run.host.into_parts().0;
    let parks = |drive| drive == Some(Drive::Park);
    Parked {
        lasted_ms: records.iter().filter(|r| parks(r.mode.drive())).count(),
        contact_rad_s,
        end,
        mode: records.last().unwrap().mode,
    }
}

/// From anywhere to either side, while it is held or floats.
#[test]
fn hidden_arms_are_laid_on_the_table() {
    let (mut fastest_rad_s, mut longest_ms, mut on_table) = (0.0_f64, 0, 0);
    for seed in 0..ARMS {
        let mut random = Random::new(seed);
        let mut angle = |most: f32| (random.below(2_001) as f32 * 1e-3 - 1.0) * most;
        let (at_rad, pose_rad) = ([angle(0.6), angle(0.6)], [angle(1.2), angle(1.2)]);
        let drive = if seed % 4 == 0 {
            Command::Float
        } else {
            Command::Regulate(at_rad)
        };
        let parked = park(seed, drive, pose_rad);
        assert_eq!(parked.mode, Mode::Idle, "seed {seed}");
        let contact_rad_s = parked.contact_rad_s;
        assert!(
            contact_rad_s <= CONTACT_RAD_S,
            "seed {seed}: {contact_rad_s}"
        );
        let end = parked.end;
        let lies = end.q.x.abs() > NEAR_TABLE_RAD;
        // Friction holds a first joint that is parked near upright.
        assert!(lies || end.q.x.abs() < 0.3, "seed {seed}: {end:?}");
        assert_eq!(end.dq, Vector2::zeros(), "seed {seed}");
        on_table += usize::from(lies);
        (fastest_rad_s, longest_ms) = (
            fastest_rad_s.max(contact_rad_s),
            longest_ms.max(parked.lasted_ms),
        );
    }
    assert!(on_table > ARMS as usize * 3 / 4, "{on_table}");
    println!("contact at most {fastest_rad_s:.2} rad/s, after {longest_ms} ms at most");
}
