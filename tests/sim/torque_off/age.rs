//! Age of commands: heartbeats alone keep a setpoint and a motion, unless their age is limited,
//! but neither a constant torque nor a stream.

use armbridge_link::message::{Command, Drive, Limits, Mode, Setup};
use armbridge_servo::Firmware;
use armbridge_tests::torque_off::cases::{all, check, run_cases};
use armbridge_tests::torque_off::rig::{World, bench, between_obstacles, with_rig};
use armbridge_tests::{plant, sinusoid};

/// Age at which a command no longer drives, in µs: the default of 2 s, with time for
/// the tick and the bus.
const AGE_US: u64 = 2_100_000;
/// Time between two points of a stream and how far ahead they are, in µs.
const POINT_US: u64 = 10_000;
const AHEAD_US: u64 = 50_000;

#[test]
fn a_constant_torque_that_is_not_repeated_ends() {
    let torques = [[0.1, 0.0], [0.2, -0.15], [-0.3, 0.3]];
    run_cases(torques, |torque_nm| {
        let bench = bench(&between_obstacles(), Firmware::Morpheus);
        with_rig(World::Bench, bench, |rig| {
            rig.drive(Command::Torque(*torque_nm));
            let commanded_us = rig.now_us();
            rig.pass_ms(300);
            assert!(rig.is_on()[0], "driven: {:?}", rig.motors());
            let off = rig.stays_off(commanded_us + AGE_US, 10_000);
            let mode = rig.mode();
            let is_calm = matches!(mode, Some(Mode::Armed | Mode::Idle));
            all([off, check(is_calm, || format!("then {mode:?}"))])
        })
    });
}

#[test]
fn a_constant_torque_that_is_repeated_goes_on() {
    let torque = Command::Torque([0.2, 0.2]);
    let bench = bench(&between_obstacles(), Firmware::Morpheus);
    with_rig(World::Bench, bench, |rig| {
        rig.drive(torque);
        rig.pass_ms(20);
        let before_us = rig.on_us();
        for _ in 0..6 {
            rig.pass_ms(1_000);
            assert_eq!(rig.command(torque), Ok(()));
        }
        let on_us = [0, 1].map(|servo| rig.on_us()[servo] - before_us[servo]);
        assert!(on_us.iter().all(|us| *us >= 6_000_000), "{on_us:?}");
    });
}

/// The arm is on its way at the end of the stream.
#[test]
fn a_stream_that_ends_is_braked_and_held() {
    let bench = bench(&plant([0.0; 2], true), Firmware::Morpheus);
    with_rig(World::Bench, bench, |rig| {
        assert_eq!(rig.command(Command::Configure(Setup::best())), Ok(()));
        rig.drive(Command::Regulate([0.0; 2]));
        rig.pass_ms(300);
        let begun_us = rig.now_us();
        for point in 0..100 {
            let elapsed_us = point * POINT_US;
            let angle_rad = 0.2 * (elapsed_us as f32 * 1e-6);
            let stream = Command::Stream {
                at_us: begun_us + elapsed_us + AHEAD_US,
                angle_rad: [angle_rad, -angle_rad],
                speed_rad_s: Some([0.2, -0.2]),
            };
            assert_eq!(rig.command(stream), Ok(()), "point {point}");
            rig.until_us(begun_us + elapsed_us + POINT_US);
        }
        assert_eq!(rig.mode(), Some(Mode::Running(Drive::Track)));
        let last_us = begun_us + 99 * POINT_US + AHEAD_US;
        rig.until_us(last_us + AGE_US);
        let (mode, speed) = (rig.mode(), rig.cosim.bench.plant().state().dq);
        assert_eq!(
            mode,
            Some(Mode::Running(Drive::Hold)),
            "{} ms after the last point",
            AGE_US / 1_000
        );
        assert!(speed.amax() < 0.1, "at rest: {speed}");
        rig.pass_ms(3_000);
        assert_eq!(rig.mode(), mode, "held on");
    });
}

#[test]
fn a_setpoint_is_held_for_a_minute_of_heartbeats() {
    const SETPOINT_RAD: [f32; 2] = [0.2, -0.1];
    let bench = bench(&plant([0.0; 2], true), Firmware::Morpheus);
    with_rig(World::Bench, bench, |rig| {
        assert_eq!(rig.command(Command::Configure(Setup::best())), Ok(()));
        rig.drive(Command::Regulate(SETPOINT_RAD));
        rig.pass_ms(100);
        let since_us = rig.now_us();
        rig.pass_ms(60_000);
        let modes = rig.modes_from(since_us);
        assert_eq!(modes, [Some(Mode::Running(Drive::Regulate))]);
        let angle_rad = rig.cosim.bench.plant().state().q;
        for joint in 0..2 {
            let apart_rad = angle_rad[joint] - f64::from(SETPOINT_RAD[joint]);
            assert!(apart_rad.abs() < 0.03, "joint {joint}: {apart_rad} rad");
        }
    });
}

/// Nobody may have been there for a minute when a motion of a minute is still under way.
#[test]
fn a_motion_is_braked_at_its_age_and_let_go_at_that_of_a_setpoint() {
    let bench = bench(&plant([0.0; 2], true), Firmware::Morpheus);
    with_rig(World::Bench, bench, |rig| {
        let limits = Limits {
            setpoint_age_ms: 2_000,
            ..Limits::default()
        };
        assert_eq!(rig.command(Command::Limit(limits)), Ok(()));
        assert_eq!(rig.command(Command::Configure(Setup::best())), Ok(()));
        rig.drive(Command::Regulate([0.0; 2]));
        assert_eq!(rig.command(Command::Follow(sinusoid(59.0))), Ok(()));
        let commanded_us = rig.now_us();
        for (age_us, mode) in [
            (AGE_US - 200_000, Mode::Running(Drive::Track)),
            (AGE_US, Mode::Running(Drive::Hold)),
            (2 * AGE_US - 300_000, Mode::Running(Drive::Hold)),
            (2 * AGE_US, Mode::Armed),
        ] {
            rig.until_us(commanded_us + age_us);
            assert_eq!(rig.mode(), Some(mode), "{age_us} us after the motion");
        }
    });
}
