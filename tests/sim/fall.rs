//! Fall of the arm after torque off: speed and time of its contact with the table.
//!
//! The figures are those of the safety case, "Fall of the arm after torque off". The virtual arm's
//! damping is the same with motors on and off: with the paper's its motors brake while they are
//! off, with a tenth of it they coast.

use core::f64::consts::FRAC_PI_2;

use armbridge_analysis::plan_runner::Script;
use armbridge_board::bridge::Channels;
use armbridge_control::arm::{Parameters, State};
use armbridge_link::message::{Command, Fault, Mode, Setup, StopSource, ToBoard};
use armbridge_servo::{Firmware, JOINTS};
use armbridge_sim::plant::PlantConfig;
use armbridge_tests::bench_run;
use armbridge_tests::torque_off::rig::{World, bench, with_rig};
use nalgebra::Vector2;

/// Time for which the arm is held, in ms.
const HELD_MS: u64 = 2_000;
/// Length of a run, in ms: every arm that falls has met the table.
const UNTIL_MS: u64 = 6_000;
/// Angle in rad at which the table carries the first joint.
const TABLE_RAD: f64 = FRAC_PI_2 - 1e-6;
/// Relative tolerance of the figures.
const TOLERANCE: f64 = 0.05;
/// That of the time from upright, which depends on the encoders' noise.
const UPRIGHT_TOLERANCE: f64 = 0.15;

const UPRIGHT_RAD: [f32; JOINTS] = [0.05, -0.05];
const LEANING_RAD: [f32; JOINTS] = [0.6, 0.0];

/// Contact of the first joint with the table.
#[derive(Clone, Copy, Debug)]
struct Contact {
    speed_rad_s: f64,
    /// Time since the last torque of a motor.
    after_s: f64,
}

/// An arm at these angles, with this share of the paper's damping, and with or without dry
/// friction.
fn arm(at_rad: [f32; JOINTS], damping: f64, friction_on: bool) -> PlantConfig {
    let paper = Parameters::<f64>::paper();
    PlantConfig {
        arm: Parameters {
            b1: damping * paper.b1,
            b2: damping * paper.b2,
            ..paper
        },
        friction_on,
        initial: State::at_rest(Vector2::from(at_rad.map(f64::from))),
        ..PlantConfig::default()
    }
}

/// Holds the arm where it is, disarms, and returns its contact; `None` if it stays where it was
/// held.
fn let_go(config: &PlantConfig, at_rad: [f32; JOINTS]) -> Option<Contact> {
    let script = Script {
        setup: Setup::best(),
        limits: Script::limits(),
        commands: vec![
            (0, Command::Regulate(at_rad)),
            (HELD_MS * 1_000, Command::Idle),
        ],
        duration_us: UNTIL_MS * 1_000,
    };
    let mut channels = Channels::new();
    let mut run = bench_run(&mut channels, *config, 1, script);
    let (mut driven_us, mut speed_rad_s, mut contact) = (0, 0.0, None);
    for at_us in (0..UNTIL_MS).map(|ms| ms * 1_000) {
        while run.now_us() < at_us {
            run.step_until(at_us).unwrap();
        }
        let state = run.bench.plant().state();
        if run.bench.plant().torque() != Vector2::zeros() {
            driven_us = at_us;
        }
        if state.q.x.abs() >= TABLE_RAD {
            let after_s = (at_us - driven_us) as f64 * 1e-6;
            contact = Some(Contact {
                speed_rad_s,
                after_s,
            });
            break;
        }
        speed_rad_s = state.dq.x.abs();
    }
    let end = run.bench.plant().state();
    assert!(driven_us > HELD_MS * 1_000, "it was held: {driven_us} µs");
    if contact.is_none() {
        assert_eq!(end.dq, Vector2::zeros(), "{end:?}");
        assert!((end.q - config.initial.q).amax() < 0.02, "{end:?}");
    }
    let records = run.host.into_parts().0;
    assert_eq!(records.last().unwrap().mode, Mode::Idle);
    contact
}

fn is_near(found: f64, expected: f64, tolerance: f64) -> bool {
    (found - expected).abs() <= tolerance * expected
}

#[test]
fn an_arm_falls_at_the_speed_that_its_damping_allows() {
    // Damping and friction; speed in rad/s and time in s.
    let leaning = [
        (1.0, true, 2.09, 0.72),
        (1.0, false, 2.24, 0.67),
        (0.5, true, 3.30, 0.54),
        (0.1, true, 4.83, 0.44),
    ];
    let upright = [
        (1.0, false, 2.22, 2.0),
        (0.5, false, 3.55, 1.4),
        (0.1, false, 5.46, 1.1),
    ];
    let leaning = leaning.map(|fall| (LEANING_RAD, fall, TOLERANCE));
    let upright = upright.map(|fall| (UPRIGHT_RAD, fall, UPRIGHT_TOLERANCE));
    for (at_rad, fall, time_tolerance) in leaning.into_iter().chain(upright) {
        let (damping, friction_on, speed_rad_s, after_s) = fall;
        let contact = let_go(&arm(at_rad, damping, friction_on), at_rad);
        let name = format!("{at_rad:?}, damping {damping}, friction {friction_on}");
        println!("{name}: {contact:?}");
        let contact = contact.unwrap_or_else(|| panic!("{name}: it stands"));
        assert!(
            is_near(contact.speed_rad_s, speed_rad_s, TOLERANCE),
            "{name}: {contact:?}, not {speed_rad_s} rad/s"
        );
        assert!(
            is_near(contact.after_s, after_s, time_tolerance),
            "{name}: {contact:?}, not {after_s} s"
        );
    }
}

#[test]
fn dry_friction_holds_an_arm_upright() {
    for damping in [1.0, 0.1] {
        let contact = let_go(&arm(UPRIGHT_RAD, damping, true), UPRIGHT_RAD);
        assert!(contact.is_none(), "damping {damping}: {contact:?}");
    }
}

/// A stop of the host, after which stock servos have torque disabled and Morpheus servos PWM 1000.
#[test]
fn a_stop_drops_the_arm_as_a_disarm_does() {
    let stopped = Mode::Fault(Fault::EmergencyStop(StopSource::Host));
    for firmware in [Firmware::Morpheus, Firmware::Stock] {
        let config = arm(LEANING_RAD, 1.0, true);
        with_rig(World::Bench, bench(&config, firmware), |rig| {
            if firmware == Firmware::Stock {
                rig.prepare();
            }
            assert_eq!(rig.command(Command::Configure(Setup::best())), Ok(()));
            rig.drive(Command::Regulate(LEANING_RAD));
            rig.pass_ms(HELD_MS);
            rig.host().send(ToBoard::Stop);
            let (sent_us, mut speed_rad_s) = (rig.now_us(), 0.0);
            loop {
                rig.pass_ms(1);
                let fallen_us = rig.now_us() - sent_us;
                let state = rig.cosim.bench.plant().state();
                if state.q.x.abs() >= TABLE_RAD {
                    break;
                }
                assert!(fallen_us < 2_000_000, "{firmware}: {state:?}");
                speed_rad_s = state.dq.x.abs();
            }
            println!("{firmware}: contact at {speed_rad_s:.2} rad/s");
            assert!(is_near(speed_rad_s, 2.09, TOLERANCE), "{firmware}");
            assert_eq!(rig.mode(), Some(stopped), "{firmware}");
        });
    }
}
