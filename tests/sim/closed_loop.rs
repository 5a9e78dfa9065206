//! The whole slice on the bench: link, bridge, bus, servos, arm.

use armbridge_analysis::plan_runner::{PlanError, PlanRunner, Script};
use armbridge_board::bridge::Channels;
use armbridge_client::status::Obstacle;
use armbridge_control::arm::Mounting;
use armbridge_control::estimate::Config;
use armbridge_link::message::{
    Command, Controller, Drive, Fault, Gains, Guards, Missing, Mode, Record, Sample, Setup,
};
use armbridge_sim::Bench;
use armbridge_sim::board::VirtualBoard;
use armbridge_sim::cosim::{Cosim, CosimError};
use armbridge_sim::faults::host::{FaultyHost, LinkFault};
use armbridge_sim::plant::{Plant, PlantConfig};
use armbridge_tests::{bench_run, plant, records, settling_s};

/// One encoder count of an AX-12A in rad: 300 degrees over 1023.
const COUNT_RAD: f64 = 300.0 / 1023.0 * std::f64::consts::PI / 180.0;

fn upright(setup: Setup, duration_s: f64) -> Script {
    Script::upright(setup, (duration_s * 1e6) as u64)
}

/// Mean angle error of both joints over the last `ticks` in Regulate, in rad.
fn rest_error(records: &[Record], ticks: usize) -> [f64; 2] {
    let regulated: Vec<_> = records
        .iter()
        .filter(|r| r.mode.drive() == Some(Drive::Regulate))
        .collect();
    let tail = &regulated[regulated.len() - ticks..];
    [0, 1].map(|joint| {
        let error =
            |r: &&Record| f64::from(r.output.angle_rad[joint] - r.output.reference_rad[joint]);
        tail.iter().map(error).sum::<f64>() / ticks as f64
    })
}

#[test]
fn frictionless_arm_settles_and_rests_within_a_count() {
    for seed in 1..=5 {
        let script = upright(Setup::default(), 3.0);
        let records = records(plant([0.30, -0.25], false), seed, script);
        for joint in 0..2 {
            let settled_s = settling_s(&records, joint, 0.020);
            assert!(
                settled_s.is_some_and(|s| s < 1.3),
                "seed {seed} joint {joint}: {settled_s:?}"
            );
        }
        let rest = rest_error(&records, 500);
        assert!(
            rest.iter().all(|error| error.abs() < COUNT_RAD),
            "seed {seed}: {rest:?}"
        );
        assert_eq!(records.last().unwrap().timing.missed, 0);
    }
}

/// The board's model hangs too, and its gains are designed for that.
#[test]
fn an_arm_that_hangs_is_regulated_as_well() {
    let hanging = |mut config: PlantConfig| {
        config.arm.mounting = Mounting::Hanging;
        config
    };
    for (base, friction_on) in [(Setup::default(), false), (Setup::best(), true)] {
        let mut setup = base;
        setup.arm.mounting = Mounting::Hanging;
        for target_rad in [[0.0, 0.0], [-0.4, 0.5]] {
            let script = Script {
                limits: Script::limits(),
                commands: vec![(0, Command::Regulate(target_rad))],
                ..upright(setup, 4.0)
            };
            let records = records(hanging(plant([0.30, -0.25], friction_on)), 1, script);
            for joint in 0..2 {
                let settled_s = settling_s(&records, joint, 0.020);
                assert!(
                    settled_s.is_some_and(|s| s < 1.7),
                    "{target_rad:?} joint {joint}: {settled_s:?}"
                );
            }
            let rest = rest_error(&records, 500);
            assert!(
                rest.iter().all(|error| error.abs() < COUNT_RAD),
                "{target_rad:?}: {rest:?}"
            );
            // Away from its zero it is pulled back, and held against that.
            let last = records.last().unwrap();
            for (joint, target) in target_rad.into_iter().enumerate() {
                let torque_nm = last.output.torque_nm[joint];
                assert!(target == 0.0 || torque_nm * target > 0.0, "{last:?}");
            }
        }
    }
}

/// 0.06 N m of static friction hold the arm up to 56 and 65 mrad off, where the
/// net stiffness (1.08 and 0.92 N m/rad) no longer moves it.
#[test]
fn with_friction_the_arm_rests_where_stiction_holds_it() {
    for seed in 1..=5 {
        let records = records(
            plant([0.30, -0.25], true),
            seed,
            upright(Setup::default(), 4.0),
        );
        let rest = rest_error(&records, 500);
        assert!(
            rest.iter().all(|error| error.abs() < 0.065),
            "seed {seed}: {rest:?}"
        );
    }
}

/// The paper's period and its printed gain, over the bus, with encoder counts
/// and the delay: by finite differences, as the paper did, on an encoder that
/// only rounds, and by the default observer on one that is noisy too.
#[test]
fn paper_gain_at_45_ms_stands() {
    let setup = Setup {
        period_us: 45_000,
        controller: Controller::StateFeedback(Gains::Paper),
        ..Setup::default()
    };
    let differences = Config::FiniteDifference { filter_s: 0.0 };
    for (estimator, noise_lsb_rms) in [(differences, 0.0), (setup.estimator, 1.0)] {
        let config = PlantConfig {
            noise_lsb_rms,
            ..plant([0.30, -0.25], false)
        };
        let mut channels = Channels::new();
        let script = upright(Setup { estimator, ..setup }, 4.0);
        let mut run = bench_run(&mut channels, config, 1, script);
        // The true arm: samples 45 ms apart contain little about it.
        let (mut begun_us, mut outside_us) = (None, 0);
        while run.now_us() < 4_000_000 {
            run.step().unwrap();
            if run.board.mode().drive() == Some(Drive::Regulate) {
                begun_us = begun_us.or(Some(run.now_us()));
                if run.bench.plant().state().q.amax() >= 0.020 {
                    outside_us = run.now_us();
                }
            }
        }
        let settled_us = outside_us - begun_us.unwrap();
        assert!(settled_us < 1_300_000, "{estimator:?}: {settled_us} µs");
    }
}

#[test]
fn a_seed_repeats_to_the_bit_and_another_does_not() {
    let of = |seed| {
        let script = Script::demo(Setup::default(), 1_000_000);
        records(plant([0.30, -0.25], true), seed, script)
    };
    let first = of(1);
    assert!(first.len() >= 1_000);
    assert_eq!(first, of(1));
    assert_ne!(first, of(2));
}

/// A servo cut off in mid run: the bridge notices within 20 ms, and the servo
/// it can still reach is off.
#[test]
fn losing_a_servo_switches_the_other_off() {
    let mut channels = Channels::new();
    let script = upright(Setup::default(), 2.0);
    let mut run = bench_run(&mut channels, plant([0.30, -0.25], true), 1, script);
    while run.now_us() < 200_000 {
        run.step().unwrap();
    }
    assert_ne!(run.bench.applied_pwm(0), 1000);
    run.bench.disconnect(1);
    while run.now_us() < 230_000 {
        run.step().unwrap();
    }
    assert_eq!(run.bench.applied_pwm(0), 1000);
    run.run().unwrap();
    let records = run.host.into_parts().0;
    let lost = |r: &&Record| r.input.samples[1] == Sample::Missing(Missing::Silence);
    let ridden_through = records
        .iter()
        .filter(lost)
        .filter(|r| r.mode.drive() == Some(Drive::Regulate))
        .count();
    assert_eq!(ridden_through, 19);
    assert!(
        records
            .iter()
            .any(|r| r.mode == Mode::Fault(Fault::ServoSilent))
    );
}

/// A host that goes silent while torque is on.
#[test]
fn a_silent_host_switches_torque_off() {
    let mut channels = Channels::new();
    let script = upright(Setup::default(), 2.0);
    let board = VirtualBoard::new(channels.split()).unwrap();
    let bench = Bench::new(Plant::new(plant([0.30, -0.25], true), 1));
    let mut host = FaultyHost::new(PlanRunner::new(script));
    host.inject(LinkFault::Vanish, 100_000..u64::MAX, 1);
    let mut run = Cosim::new(board, bench, host);
    while run.now_us() < 600_000 {
        run.step().unwrap();
    }
    assert_eq!(run.board.mode(), Mode::Fault(Fault::HostSilent));
    assert_eq!(
        [run.bench.applied_pwm(0), run.bench.applied_pwm(1)],
        [1000, 1000]
    );
}

#[test]
fn a_servo_that_is_unplugged_is_named() {
    let mut channels = Channels::new();
    let script = upright(Setup::default(), 2.0);
    let mut run = bench_run(&mut channels, plant([0.1, 0.1], true), 1, script);
    run.bench.disconnect(1);
    let error = run.run().unwrap_err();
    let CosimError::Host(PlanError::Servos(last)) = error else {
        panic!("{error:?}");
    };
    let absent = Obstacle::Absent {
        joint: 1,
        missing: Missing::Silence,
    };
    assert_eq!(last, Some(absent));
}

/// A constant torque that drives the first joint towards its limit: the arm is
/// braked and held short of it, and let go when that does not end.
#[test]
fn a_joint_is_braked_before_its_limit_and_let_go_if_it_is_pushed_on() {
    let mut channels = Channels::new();
    let script = Script {
        limits: Script::limits(),
        commands: vec![(0, Command::Torque([0.7, 0.0]))],
        ..upright(Setup::default(), 3.0)
    };
    let mut run = bench_run(&mut channels, plant([0.30, -0.25], true), 1, script);
    let mut farthest_rad = 0.0_f64;
    while run.board.mode() != Mode::Fault(Fault::AngleLimit) {
        run.step().unwrap();
        assert!(run.now_us() < 3_000_000, "no fault: {:?}", run.board.mode());
        farthest_rad = farthest_rad.max(run.bench.plant().state().q.x);
    }
    assert!((1.3..1.42).contains(&farthest_rad), "{farthest_rad} rad");
    let later_us = run.now_us() + 10_000;
    while run.now_us() < later_us {
        run.step().unwrap();
    }
    assert_eq!(
        [run.bench.applied_pwm(0), run.bench.applied_pwm(1)],
        [1000, 1000]
    );
    let records = run.host.into_parts().0;
    let braked = records
        .iter()
        .filter(|r| r.output.guards.contains(Guards::BRAKED));
    // The last of half a second is the fault's.
    let braked_ms = 1 + braked.count();
    assert!((500..1_000).contains(&braked_ms), "{braked_ms} ms");
}

/// A hand or a stop holds the arm aside, where its weight would turn it: with motors off the
/// speed of an arm at rest is none.
#[test]
fn an_idle_arm_that_is_held_aside_has_no_speed() {
    let mut channels = Channels::new();
    let script = Script {
        limits: Script::limits(),
        commands: Vec::new(),
        ..upright(Setup::default(), 3.0)
    };
    let mut held = plant([0.3, -0.3], true);
    held.stops_rad = [[-0.3, 0.3]; 2];
    let mut run = bench_run(&mut channels, held, 1, script);
    while run.now_us() < 2_500_000 {
        run.step().unwrap();
    }
    let records = run.host.into_parts().0;
    let last = &records[records.len() - 500..];
    assert!(last.iter().all(|record| record.mode.drive().is_none()));
    for joint in 0..2 {
        let sum: f32 = last
            .iter()
            .map(|record| record.output.speed_rad_s[joint])
            .sum();
        let mean = sum / last.len() as f32;
        assert!(mean.abs() < 0.02, "joint {joint}: {mean} rad/s");
    }
}
