//! Silence of a client of the transparent port that has driven the motors: its turn
//! on the bus ends.

use armbridge_tests::torque_off::METHODS;
use armbridge_tests::torque_off::cases::{check, run_cases};
use armbridge_tests::torque_off::rig::{World, bench, between_obstacles, with_rig};
use armbridge_tests::torque_off::silence::{cases, is_ended};

/// Time between two questions of a client that only asks, in µs.
const ASK_US: u64 = 100_000;

#[test]
fn a_client_that_hangs_is_ended() {
    run_cases(cases(), |(method, writes)| {
        is_ended(World::Bench, *method, *writes)
    });
}

/// A client that drives once and then only asks is not silent.
#[test]
fn a_client_that_asks_keeps_the_bus() {
    run_cases(METHODS, |method| {
        let bench = bench(&between_obstacles(), method.firmware());
        with_rig(World::Bench, bench, |rig| {
            rig.client_prepares(*method);
            rig.client.send(&method.packets());
            rig.client.stream(method.question(), ASK_US);
            rig.pass_ms(100);
            let before_us = rig.on_us();
            rig.pass_ms(3_000);
            let on_us = [0, 1].map(|servo| rig.on_us()[servo] - before_us[servo]);
            check(on_us == [3_000_000; 2], || {
                format!("motors on for {on_us:?} µs of 3 s")
            })
        })
    });
}
