//! Ends of a drive that park the arm, and those of a park.

use super::{CONTACT_RAD_S, NEAR_TABLE_RAD, PARK_MS, hidden, with_pose};
use armbridge_board::bridge::limits::REFERENCE_MAX_RAD;
use armbridge_link::message::{Command, Drive, Fault, Limits, Mode, Refusal, StopSource, ToBoard};
use armbridge_link::motion::Motion;
use armbridge_servo::{Firmware, JOINTS, Pwm};
use armbridge_tests::torque_off::rig::{Rig, STOP_US, World, bench, with_rig};

const POSE_RAD: [f32; JOINTS] = [1.2, 0.2];
const PARKING: Option<Mode> = Some(Mode::Running(Drive::Park));
/// Age of setpoints, and of torques, in ms.
const AGE_MS: u16 = 400;

/// What ends the drive.
#[derive(Clone, Copy, Debug)]
enum End {
    Goodbye,
    Silence,
    OtherHost,
    SetpointExpires,
    TorqueExpires,
    Command,
}

/// Runs a test on a hidden arm with a pose that this drives.
fn driven<T>(drive: Command, test: impl FnOnce(&mut Rig<'_>) -> T) -> T {
    let (config, setup) = hidden(7);
    with_rig(World::Bench, bench(&config, Firmware::Morpheus), |rig| {
        let limits = Limits {
            setpoint_age_ms: AGE_MS,
            torque_age_ms: AGE_MS,
            ..with_pose(Limits::default(), POSE_RAD)
        };
        assert_eq!(rig.command(Command::Limit(limits)), Ok(()));
        assert_eq!(rig.command(Command::Configure(setup)), Ok(()));
        rig.drive(drive);
        rig.pass_ms(100);
        test(rig)
    })
}

/// Fastest joint near the table, in rad/s, until the motors are off.
fn contact_until_off(rig: &mut Rig<'_>) -> f64 {
    let (begun_us, mut fastest_rad_s) = (rig.now_us(), 0.0_f64);
    while rig.mode().is_some_and(Mode::is_armed) {
        assert!(rig.now_us() < begun_us + PARK_MS * 1_000, "it does not end");
        rig.pass_ms(1);
        let state = rig.cosim.bench.plant().state();
        if state.q.x.abs() > NEAR_TABLE_RAD {
            fastest_rad_s = fastest_rad_s.max(state.dq.amax());
        }
    }
    fastest_rad_s
}

#[test]
fn each_end_of_a_session_parks_the_arm() {
    let regulate = Command::Regulate([0.0, 0.0]);
    let ends = [
        (End::Goodbye, regulate, Mode::Idle),
        (End::Silence, regulate, Mode::Fault(Fault::HostSilent)),
        (End::OtherHost, regulate, Mode::Idle),
        (End::SetpointExpires, regulate, Mode::Idle),
        (End::TorqueExpires, Command::Torque([0.05, 0.0]), Mode::Idle),
        (End::Command, regulate, Mode::Idle),
        (End::Silence, Command::Float, Mode::Fault(Fault::HostSilent)),
    ];
    for (end, drive, last) in ends {
        driven(drive, |rig| {
            match end {
                End::Goodbye => {
                    rig.host().send(ToBoard::Goodbye);
                    rig.host().is_silent = true;
                }
                End::Silence => rig.host().is_silent = true,
                End::OtherHost => rig.host().begin_session(),
                End::SetpointExpires | End::TorqueExpires => {}
                End::Command => assert_eq!(rig.command(Command::Park), Ok(())),
            }
            rig.until("parking", 1_000_000, |rig| rig.mode() == PARKING);
            let contact_rad_s = contact_until_off(rig);
            println!("{end:?}: contact at {contact_rad_s:.2} rad/s");
            assert!(contact_rad_s <= CONTACT_RAD_S, "{end:?}: {contact_rad_s}");
            assert_eq!(rig.mode(), Some(last), "{end:?}");
            let lies_rad = rig.cosim.bench.plant().state().q.x;
            assert!(lies_rad > NEAR_TABLE_RAD, "{end:?}: {lies_rad}");
            let off_us = rig.now_us() + STOP_US;
            rig.stays_off(off_us, 1_000).unwrap();
        });
    }
}

/// A session that begins while the arm is parked drives it on, without a step in the torque; but no
/// motion begins from beyond the bounds of motions, where it is lowered.
#[test]
fn a_host_that_comes_back_takes_over() {
    for park_ms in [200, 1_500, 2_500, 3_500] {
        driven(Command::Regulate([0.0, 0.0]), |rig| {
            rig.host().is_silent = true;
            rig.until("parking", 1_000_000, |rig| rig.mode() == PARKING);
            rig.pass_ms(park_ms);
            rig.host().begin_session();
            rig.pass_ms(20);
            assert_eq!(rig.mode(), PARKING, "{park_ms}");
            let session = rig.host().session();
            assert_eq!(rig.command(Command::Arm { session }), Ok(()));
            let there = Motion::MinimumJerk {
                to_rad: [0.2, -0.2],
                duration_s: None,
            };
            let taken_us = rig.now_us();
            let answer = rig.command(Command::Follow(there));
            if rig.cosim.bench.plant().state().q.x > f64::from(REFERENCE_MAX_RAD) {
                assert!(matches!(answer, Err(Refusal::Beyond { .. })), "{answer:?}");
                assert!(contact_until_off(rig) <= CONTACT_RAD_S);
                assert_eq!(rig.mode(), Some(Mode::Idle));
                return;
            }
            assert_eq!(answer, Ok(()), "{park_ms}");
            let (mut before, mut step) = (rig.motors(), 0);
            for _ in 0..200 {
                rig.pass_ms(1);
                let motors = rig.motors();
                let steps = (0..JOINTS).map(|joint| motors[joint].abs_diff(before[joint]));
                step = step.max(steps.max().unwrap());
                before = motors;
            }
            println!("after {park_ms} ms: PWM steps of {step} counts at most");
            assert!(step < 60, "{park_ms}: {step}");
            let is_driven = |mode: &Option<Mode>| mode.is_some_and(|mode| mode.drive().is_some());
            assert!(rig.modes_from(taken_us).iter().all(is_driven), "{park_ms}");
            assert_eq!(rig.mode(), Some(Mode::Running(Drive::Track)), "{park_ms}");
        });
    }
}

#[test]
fn a_stop_and_a_command_to_disarm_end_a_park_at_once() {
    let stop = Fault::EmergencyStop(StopSource::Host);
    let ends = [
        (ToBoard::Stop, Mode::Fault(stop)),
        (ToBoard::Command(Command::Idle), Mode::Idle),
    ];
    for (message, mode) in ends {
        driven(Command::Regulate([0.0, 0.0]), |rig| {
            assert_eq!(rig.command(Command::Park), Ok(()));
            rig.pass_ms(1_500);
            assert_eq!(rig.mode(), PARKING);
            let sent_us = rig.now_us();
            rig.host().send(message);
            rig.stays_off(sent_us + STOP_US, 500).unwrap();
            assert_eq!(rig.mode(), Some(mode));
        });
    }
}

/// Neither an arm that nothing drives nor one without a pose is moved.
#[test]
fn without_a_drive_or_a_pose_the_arm_is_only_disarmed() {
    driven(Command::Regulate([0.0, 0.0]), |rig| {
        assert_eq!(rig.command(Command::Idle), Ok(()));
        assert_eq!(rig.command(Command::Park), Ok(()));
        rig.pass_ms(100);
        assert_eq!(rig.mode(), Some(Mode::Idle));
        assert_eq!(rig.motors(), [Pwm::OFF.counts(); JOINTS]);
        assert_eq!(rig.command(Command::Limit(Limits::default())), Ok(()));
        rig.drive(Command::Regulate([0.0, 0.0]));
        rig.pass_ms(100);
        let parked_us = rig.now_us();
        assert_eq!(rig.command(Command::Park), Ok(()));
        rig.stays_off(parked_us + STOP_US, 100).unwrap();
        assert_eq!(rig.mode(), Some(Mode::Idle));
    });
}
