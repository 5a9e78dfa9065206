//! The firmware image under QEMU, in lockstep with the bench.
//!
//! No clock is involved: how busy the machine is changes how long these tests
//! take, and nothing else.

use armbridge::bench::Bench;
use armbridge::bench::cosim::Cosim;
use armbridge::bench::plant::Plant;
use armbridge::emulator::{EmulatedBoard, Qemu, QemuOptions, Time, qemu};
use armbridge::operator::{Operator, Script};
use armbridge_shared::link::message::{Record, Setup};
use armbridge_tests::{plant, records, settling_s};

fn script() -> Script {
    let duration_us = 2_000_000;
    Script {
        setup: Setup::default(),
        setpoints: vec![(0, [0.0, 0.0]), (1_500_000, [0.1, -0.1])],
        duration_us,
    }
}

fn emulate(icount: bool) -> Vec<Record> {
    let options = QemuOptions {
        image: qemu::default_image(),
        time: Time::Lockstep,
        icount,
    };
    let board = EmulatedBoard::new(Qemu::start(&options).unwrap()).unwrap();
    let bench = Bench::new(Plant::new(plant([0.2, -0.2], false), 1));
    let mut run = Cosim::new(board, bench, Operator::new(script()));
    run.run().unwrap();
    run.host.into_parts().0
}

fn without_measured_times(mut records: Vec<Record>) -> Vec<Record> {
    for record in &mut records {
        record.timing.compute_ns = 0;
    }
    records
}

/// One test, so that the runs are compared with each other.
#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn firmware_balances_and_repeats_and_agrees_with_the_bench() {
    let first = emulate(false);
    let to_first_setpoint: Vec<_> = first
        .iter()
        .copied()
        .take_while(|r| r.reference_rad == [0.0, 0.0])
        .collect();
    for joint in 0..2 {
        let settled_s = settling_s(&to_first_setpoint, joint, 0.020);
        assert!(
            settled_s.is_some_and(|s| s < 1.3),
            "joint {joint}: {settled_s:?}"
        );
    }
    assert!(first.iter().all(|record| record.timing.missed == 0));
    assert!(
        first.iter().any(|record| record.timing.compute_ns > 0),
        "compute time is measured"
    );

    let first = without_measured_times(first);
    assert_eq!(
        first,
        without_measured_times(emulate(false)),
        "two runs differ"
    );

    // The same code on another processor: the same bits.
    let bench = records(plant([0.2, -0.2], false), 1, script());
    assert_eq!(
        first,
        without_measured_times(bench),
        "emulator and bench differ"
    );
}

#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn with_icount_measured_times_repeat_too() {
    assert_eq!(emulate(true), emulate(true));
}
