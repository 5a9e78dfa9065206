//! Torque off in the firmware: the scenarios of the bench, on the emulated board.

use armbridge_tests::torque_off::cases::run_cases;
use armbridge_tests::torque_off::client::Method;
use armbridge_tests::torque_off::passthrough::{befores, is_stopped, stops};
use armbridge_tests::torque_off::rig::World;
use armbridge_tests::torque_off::sessions::{End, sessions_end};
use armbridge_tests::torque_off::silence::{cases, is_ended};

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
    let cases = Method::ALL.into_iter().flat_map(stops);
    run_cases(cases, |case| is_stopped(World::Emulator, case));
}

#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn a_client_that_floods_or_changes_the_rate_is_stopped_by_the_firmware() {
    let cases = Method::ALL.into_iter().flat_map(befores);
    run_cases(cases, |case| is_stopped(World::Emulator, case));
}
