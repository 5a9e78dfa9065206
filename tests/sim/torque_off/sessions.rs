//! End of a session that drives the arm, by a hello or a goodbye behind a flood of frames.

use armbridge_tests::torque_off::rig::World;
use armbridge_tests::torque_off::sessions::{End, sessions_end};

#[test]
fn a_hello_disarms_behind_any_number_of_frames() {
    sessions_end(World::Bench, End::Hello);
}

#[test]
fn a_goodbye_disarms_behind_any_number_of_frames() {
    sessions_end(World::Bench, End::Goodbye);
}
