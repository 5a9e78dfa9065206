//! Current control mode of X servos that measure their current, and the drive mode that bring-up
//! leaves and changes.

use armbridge_analysis::plan_runner::plan::{Base, Change};
use armbridge_link::message::{Command, Fault, Limits, Mode, Refusal, Settings, ToHost};
use armbridge_servo::protocol2::{model, register};
use armbridge_servo::{ControlMode, JOINTS};
use armbridge_sim::half_duplex_bus::Device;
use armbridge_sim::plant::PlantConfig;
use armbridge_tests::torque_off::rig::{Rig, WATCHDOG_US, World, with_rig};
use armbridge_tests::torque_off::x_servos::{
    is_held, register_of, xl330, xl330_bench, xl330_setup,
};

fn registers(rig: &Rig<'_>, address: u16) -> [i32; JOINTS] {
    [0, 1].map(|servo| register_of(&rig.cosim.bench, servo, address))
}

#[test]
fn an_arm_is_held_by_current_as_by_pwm() {
    // A count is 1.5 mrad.
    for mode in [ControlMode::Pwm, ControlMode::Current] {
        let off_rad = is_held(World::Bench, mode, 3_000);
        assert!(off_rad < 0.01, "{mode:?}: {off_rad}");
    }
}

#[test]
fn a_servo_driven_by_current_is_off_by_its_own_watchdog() {
    with_rig(World::Bench, xl330_bench(&xl330([0.0; JOINTS])), |rig| {
        assert_eq!(
            rig.command(Command::Configure(xl330_setup(ControlMode::Current))),
            Ok(())
        );
        rig.prepare();
        // Where its weight has to be held.
        rig.drive(Command::Regulate([0.4, 0.2]));
        rig.pass_ms(1_000);
        assert_ne!(rig.is_on(), [false; JOINTS], "it holds its weight");
        for servo in [0, 1] {
            rig.cosim.bench.disconnect(servo);
        }
        rig.until_us(rig.now_us() + WATCHDOG_US);
        // By the motor's current, not its duty, which follows the speed as the arm falls. Where the
        // arm meets a stop, the servo's PWM slope, of 18 ms over the whole supply, lags behind.
        let mut driven_ms = 0;
        for _ in 0..1_000 {
            rig.pass_ms(1);
            let counts = registers(rig, register::PRESENT_CURRENT).map(i32::abs);
            driven_ms += u32::from(counts.iter().any(|counts| *counts > 20));
        }
        println!("a current in {driven_ms} of 1000 ms");
        assert!(driven_ms <= 20, "{driven_ms}");
        let counts = registers(rig, register::PRESENT_CURRENT).map(i32::abs);
        assert!(counts.iter().all(|counts| *counts <= 5), "{counts:?}");
        assert_eq!(rig.fault(), Some(Fault::ServoSilent));
    });
}

/// Another mode makes the servos ready again without being asked to, and PWM is as it was.
#[test]
fn the_control_mode_is_changed_on_a_board_whose_servos_are_ready() {
    with_rig(World::Bench, xl330_bench(&xl330([0.0; JOINTS])), |rig| {
        let modes = [ControlMode::Pwm, ControlMode::Current, ControlMode::Pwm];
        rig.prepare();
        for (mode, code) in modes.into_iter().zip([16, 0, 16]) {
            assert_eq!(rig.command(Command::Configure(xl330_setup(mode))), Ok(()));
            rig.until("ready", 2_000_000, |rig| rig.mode() == Some(Mode::Idle));
            assert_eq!(registers(rig, register::OPERATING_MODE), [code; JOINTS]);
            rig.drive(Command::Regulate([0.1, -0.1]));
            rig.pass_ms(500);
            assert!(
                matches!(rig.mode(), Some(Mode::Running(_))),
                "{:?}",
                rig.mode()
            );
            // Not while it is armed.
            let other = xl330_setup(modes[usize::from(mode == ControlMode::Pwm)]);
            assert_eq!(
                rig.command(Command::Configure(other)),
                Err(Refusal::NotIdle)
            );
            assert_eq!(rig.command(Command::Idle), Ok(()));
            rig.until("idle", 100_000, |rig| rig.mode() == Some(Mode::Idle));
        }
    });
}

/// Servos that do not measure their current, or limit it below what the board may command.
#[test]
fn a_servo_that_would_ignore_a_current_is_not_made_ready() {
    let of_model = |number| PlantConfig {
        x_servo: model::find(number).unwrap(),
        ..xl330([0.0; JOINTS])
    };
    // XL430-W250; XC330-T288 with a current limit of 910.
    for (number, counts, is_ready) in [
        (1_060, 1_000, false),
        (1_220, 1_000, false),
        (1_220, 910, true),
    ] {
        with_rig(World::Bench, xl330_bench(&of_model(number)), |rig| {
            let limits = Limits {
                pwm_counts: counts,
                ..Limits::default()
            };
            assert_eq!(rig.command(Command::Limit(limits)), Ok(()));
            assert_eq!(
                rig.command(Command::Configure(xl330_setup(ControlMode::Current))),
                Ok(())
            );
            assert_eq!(rig.command(Command::Prepare), Ok(()));
            rig.pass_ms(2_000);
            let mut messages = rig.cosim.host.messages.iter();
            let is_refused =
                messages.any(|(_, message)| *message == ToHost::Unprepared { joint: 0 });
            assert_eq!(is_refused, !is_ready, "{number}");
            let session = rig.host().session();
            let result = rig.command(Command::Arm { session });
            assert_eq!(result.is_ok(), is_ready, "{number}: {result:?}");
            assert!(is_ready || rig.is_on() == [false; JOINTS]);
        });
    }
}

/// Bits of the drive mode: direction of rotation, and torque by a goal.
#[test]
fn torque_by_a_goal_is_ended_and_restored_and_the_direction_stays() {
    let found = 1 | register::TORQUE_BY_GOAL;
    let mut bench = xl330_bench(&xl330([0.0; JOINTS]));
    for servo in [0, 1] {
        if let Device::X(servo) = bench.servo_mut(servo) {
            servo.set_register(register::DRIVE_MODE, &[found]);
        }
    }
    with_rig(World::Bench, bench, |rig| {
        assert_eq!(
            rig.command(Command::Configure(xl330_setup(ControlMode::Pwm))),
            Ok(())
        );
        rig.prepare();
        assert_eq!(registers(rig, register::DRIVE_MODE), [1; JOINTS]);
        assert_eq!(rig.command(Command::Release), Ok(()));
        rig.pass_ms(2_000);
        assert_eq!(
            registers(rig, register::DRIVE_MODE),
            [i32::from(found); JOINTS]
        );
        assert_eq!(registers(rig, register::OPERATING_MODE), [3; JOINTS]);
    });
}

/// A scenario's control is of the board's arm and of its servos as they are driven.
#[test]
fn another_control_leaves_the_control_mode() {
    let before = Settings {
        setup: xl330_setup(ControlMode::Current),
        ..Settings::default()
    };
    for base in [Base::Board, Base::Paper, Base::Compensated] {
        let change = Change {
            base,
            groups: Vec::new(),
        };
        let after = change.apply(&before).unwrap().setup;
        assert_eq!(after.control_mode, ControlMode::Current, "{base:?}");
        assert_eq!(after.joints, before.setup.joints, "{base:?}");
    }
}
