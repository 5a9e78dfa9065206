//! Calibrations that are wrong: the arm stays where it may be.

use armbridge_analysis::plan_runner::Script;
use armbridge_board::bridge::{Channels, settings_refusal};
use armbridge_client::Host;
use armbridge_control::actuator::{Direction, Joint, bounds};
use armbridge_control::encoder::Encoder;
use armbridge_link::limits::hard;
use armbridge_link::message::{Command, Refusal, Settings, Setup};
use armbridge_sim::board::VirtualBoard;
use armbridge_sim::cosim::Cosim;
use armbridge_tests::command_host::{CommandHost, Request, bench};
use armbridge_tests::random::Random;
use armbridge_tests::{bench_run, plant};

/// From the detection of an angle to motors off, at the fastest: 10 rad/s for a tick and a
/// stop sequence.
const BRAKING_RAD: f64 = 0.1;

/// Largest true angle in rad of a driven arm whose board has this calibration; the arm is that
/// of the paper.
fn farthest_rad(joint: Joint<f32>, command: Command, seed: u64) -> f64 {
    let script = Script {
        setup: Setup {
            joints: [joint; 2],
            ..Setup::best()
        },
        limits: Script::limits(),
        commands: vec![(0, command)],
        duration_us: 2_000_000,
    };
    let mut channels = Channels::new();
    let mut run = bench_run(&mut channels, plant([0.0; 2], true), seed, script);
    let mut farthest_rad: f64 = 0.0;
    // The plan ends early with a fault.
    while !run.host.is_done() && run.step().is_ok() {
        if run.board.mode().drive().is_some() {
            let now_us = run.now_us();
            farthest_rad = farthest_rad.max(run.bench.state_at(now_us).q.amax());
        }
    }
    farthest_rad
}

/// Calibrations at the bounds and between.
fn accepted(random: &mut Random) -> Joint<f32> {
    let mut between = |[low, high]: [f64; 2]| match random.below(3) {
        0 => low,
        1 => high,
        _ => low + (high - low) * random.below(1_000) as f64 / 1_000.0,
    };
    let zero_off = between([-1.0, 1.0].map(|way| way * Encoder::Ax12a.zero_off_counts()));
    Joint {
        zero_count: (f64::from(Encoder::Ax12a.middle_count()) + zero_off) as f32,
        rad_per_count: between([0.004_601, 0.005_699]) as f32,
        gain_counts_per_nm: between(bounds::GAIN_COUNTS_PER_NM) as f32,
        offset_counts: between([-bounds::OFFSET_COUNTS, bounds::OFFSET_COUNTS]) as f32,
        direction: if zero_off > 0.0 {
            Direction::Reverse
        } else {
            Direction::Forward
        },
    }
}

#[test]
fn no_accepted_calibration_takes_the_arm_beyond_its_hard_bound() {
    let mut random = Random::new(1);
    let mut farthest: f64 = 0.0;
    for seed in 0..60 {
        let joint = accepted(&mut random);
        assert!(joint.is_valid(), "{joint:?}");
        let sign = if seed % 2 == 0 { 1.0 } else { -1.0 };
        let command = match seed % 3 {
            0 => Command::Regulate([1.2 * sign; 2]),
            1 => Command::Torque([1.2 * sign, 0.4]),
            _ => Command::Torque([0.2, 1.2 * sign]),
        };
        let reached = farthest_rad(joint, command, seed);
        assert!(
            reached < f64::from(hard::ANGLE_RAD) + BRAKING_RAD,
            "{joint:?} {command:?}: {reached} rad"
        );
        farthest = farthest.max(reached);
    }
    // They do reach it.
    assert!(farthest > 1.3, "{farthest}");
}

#[test]
fn the_calibration_stays_while_armed() {
    let mut setup = Setup::best();
    let same = Request::Command(Command::Configure(setup));
    setup.joints[1].zero_count += 1.0;
    let other = Request::Command(Command::Configure(setup));
    let hold = Request::Command(Command::Regulate([0.0; 2]));
    let idle = Request::Command(Command::Idle);
    let mut channels = Channels::new();
    let board = VirtualBoard::new(channels.split()).unwrap();
    let host = CommandHost::new([Request::Arm, other, same, hold, other, idle, other]);
    let mut run = Cosim::new(board, bench(), host);
    while !run.host.is_done() {
        run.step().unwrap();
    }
    let kept = Err(Refusal::NotIdle);
    assert_eq!(
        run.host.received.answers,
        [Ok(()), kept, Ok(()), Ok(()), kept, Ok(()), Ok(())]
    );
}

#[test]
fn a_calibration_that_is_no_servo_is_refused() {
    let paper = Joint::<f32>::paper();
    #[rustfmt::skip]
    let none = [
        Joint { zero_count: 411.0, ..paper },
        Joint { zero_count: 613.0, ..paper },
        Joint { rad_per_count: 1e-4, ..paper },
        Joint { rad_per_count: 0.0058, ..paper },
        Joint { gain_counts_per_nm: 82.0, ..paper },
        Joint { gain_counts_per_nm: -834.0, ..paper },
        Joint { offset_counts: 151.0, ..paper },
        Joint { offset_counts: f32::NAN, ..paper },
    ];
    for joint in none {
        let mut settings = Settings::default();
        settings.setup.joints[1] = joint;
        assert_eq!(
            settings_refusal(&settings),
            Some(Refusal::OutOfRange),
            "{joint:?}"
        );
    }
}
