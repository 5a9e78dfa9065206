//! Emergency stops while a client of the transparent port drives the motors: they are
//! off and stay off, whatever the client does.

use armbridge_tests::torque_off::METHODS;
use armbridge_tests::torque_off::cases::run_cases;
use armbridge_tests::torque_off::passthrough::{Stop, befores, is_stopped, stops};
use armbridge_tests::torque_off::rig::{World, bench, between_obstacles, with_rig};

#[test]
fn every_stop_ends_what_a_client_drives() {
    let cases = METHODS.into_iter().flat_map(stops);
    run_cases(cases, |case| is_stopped(World::Bench, case));
}

#[test]
fn a_client_that_floods_or_changes_the_rate_is_stopped() {
    let cases = METHODS.into_iter().flat_map(befores);
    run_cases(cases, |case| is_stopped(World::Bench, case));
}

/// A fault that is latched lends the bus to no client, and a stop in it changes
/// nothing.
#[test]
fn a_client_that_comes_after_a_stop_drives_nothing() {
    run_cases(METHODS, |method| {
        let bench = bench(&between_obstacles(), method.firmware());
        with_rig(World::Bench, bench, |rig| {
            rig.stop(Stop::Host);
            rig.pass_ms(100);
            let (from_us, before_us) = (rig.now_us(), rig.on_us());
            rig.client_drives(*method);
            rig.stop(Stop::Host);
            rig.pass_ms(World::Bench.watch_ms());
            rig.was_off(from_us, before_us)
        })
    });
}
