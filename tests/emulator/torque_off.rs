//! Torque off in the firmware: the scenarios of the bench, on the emulated board.

use armbridge_link::message::{Command, Fault, Limits, Mode, Refusal, Setup};
use armbridge_servo::{ControlMode, Firmware};
use armbridge_sim::faults::sensor::SensorFault;
use armbridge_sim::plant::PlantConfig;
use armbridge_tests::torque_off::METHODS;
use armbridge_tests::torque_off::cases::run_cases;
use armbridge_tests::torque_off::passthrough::{befores, is_stopped, stops};
use armbridge_tests::torque_off::rig::{World, bench, with_rig};
use armbridge_tests::torque_off::sessions::{End, sessions_end};
use armbridge_tests::torque_off::silence::{cases, is_ended};
use armbridge_tests::torque_off::x_servos::{is_held, settings_are_saved_while_servos_are_ready};

#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn a_hello_disarms_the_firmware_behind_any_number_of_frames() {
    sessions_end(World::Emulator, End::Hello);
}

#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn a_goodbye_disarms_the_firmware_behind_any_number_of_frames() {
    sessions_end(World::Emulator, End::Goodbye);
}

#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn a_client_that_hangs_is_ended_by_the_firmware() {
    run_cases(cases(), |(method, writes)| {
        is_ended(World::Emulator, *method, *writes)
    });
}

#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn every_stop_of_the_firmware_ends_what_a_client_drives() {
    let cases = METHODS.into_iter().flat_map(stops);
    run_cases(cases, |case| is_stopped(World::Emulator, case));
}

#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn a_client_that_floods_or_changes_the_rate_is_stopped_by_the_firmware() {
    let cases = METHODS.into_iter().flat_map(befores);
    run_cases(cases, |case| is_stopped(World::Emulator, case));
}

/// An arm without noise in its encoders, whose samples do not tell a stopped one from one at rest.
#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn a_quiet_encoder_that_stops_ends_the_drive_of_the_firmware() {
    let arm = PlantConfig {
        noise_lsb_rms: 0.0,
        ..PlantConfig::default()
    };
    with_rig(World::Emulator, bench(&arm, Firmware::Morpheus), |rig| {
        rig.drive(Command::Regulate([0.05, -0.05]));
        rig.pass_ms(2_000);
        assert!(
            matches!(rig.mode(), Some(Mode::Running(_))),
            "{:?}",
            rig.mode()
        );
        rig.cosim.bench.fail_sensor(1, SensorFault::Frozen);
        rig.pass_ms(800);
        assert_eq!(rig.mode(), Some(Mode::Fault(Fault::EncoderFrozen)));
        rig.pass_ms(20);
        assert_eq!(rig.is_on(), [false; 2]);
    });
}

#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn the_firmware_does_not_arm_motors_that_it_cannot_check_unless_that_is_confirmed() {
    let arm = PlantConfig::default();
    with_rig(World::Emulator, bench(&arm, Firmware::Morpheus), |rig| {
        let slow = Setup {
            period_us: 45_000,
            ..Setup::default()
        };
        assert_eq!(rig.command(Command::Configure(slow)), Ok(()));
        rig.pass_ms(5_000);
        let session = rig.host().session();
        let arming = Command::Arm { session };
        assert_eq!(rig.command(arming), Err(Refusal::MotorsUnchecked));
        let unchecked = Limits {
            check_rad_s2: 0,
            ..Limits::default()
        };
        assert_eq!(rig.command(Command::Limit(unchecked)), Ok(()));
        assert_eq!(rig.command(arming), Ok(()));
    });
}

#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn settings_are_saved_by_the_firmware_while_x_servos_are_ready() {
    settings_are_saved_while_servos_are_ready(World::Emulator);
}

#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn an_arm_is_held_by_current_of_the_firmware() {
    let off_rad = is_held(World::Emulator, ControlMode::Current, 1_500);
    // A count is 1.5 mrad.
    assert!(off_rad < 0.01, "{off_rad}");
}
