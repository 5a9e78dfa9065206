//! A million ticks with servos of the X series: none is missed, and bench and emulated image are
//! equal in every bit.

use armbridge_analysis::plan_runner::{PlanRunner, Script};
use armbridge_board::bridge::Channels;
use armbridge_link::message::{Command, Record, Setup};
use armbridge_servo::Firmware;
use armbridge_sim::board::{Board, VirtualBoard};
use armbridge_sim::cosim::Cosim;
use armbridge_tests::transparent_port::bench;
use armbridge_tests::{assert_undisturbed, calibrations, emulated_board, plant, sinusoid};

/// Ticks of a run; there are two, of different set-ups.
const TICKS: u64 = 500_000;

fn records<B: Board>(board: B, baud: u32, script: Script) -> Vec<Record>
where
    B::Error: std::fmt::Debug,
{
    let bench = bench(&plant([0.1, -0.1], true), [Firmware::XSeries; 2], baud);
    let mut cosim = Cosim::new(board, bench, PlanRunner::new(script));
    cosim.run().expect("a run");
    let mut records = cosim.host.into_parts().0;
    for record in &mut records {
        record.timing.compute_ns = 0;
    }
    records
}

fn a_million_ticks(baud: u32, period_us: u32) {
    let mut driven = 0;
    for setup in [Setup::best(), Setup::default()] {
        let run_us = TICKS * u64::from(period_us);
        let script = Script {
            setup: Setup {
                period_us,
                joints: calibrations(Firmware::XSeries),
                ..setup
            },
            limits: Script::limits(),
            // Sinusoids of both joints, a minute each.
            commands: (0..run_us)
                .step_by(60_000_000)
                .map(|at_us| (at_us, Command::Follow(sinusoid(59.0))))
                .collect(),
            duration_us: run_us,
        };
        let mut channels = Channels::new();
        let virtual_board = VirtualBoard::new(channels.split()).unwrap();
        let bench = records(virtual_board, baud, script.clone());
        let emulated = records(emulated_board(false), baud, script);
        assert!(bench == emulated, "{baud}: bench and emulator differ");
        assert_undisturbed(&bench);
        let is_driven = |record: &&Record| record.mode.drive().is_some();
        driven += bench.iter().filter(is_driven).count();
        let bus_us = bench.iter().map(|record| record.timing.bus_us);
        println!(
            "{baud} baud, {period_us} us: {} records, bus {:?} us",
            bench.len(),
            bus_us.max()
        );
    }
    assert!(driven as u64 > 2 * TICKS - 2_000, "{driven}");
}

#[test]
fn at_one_kilohertz_and_one_megabaud() {
    a_million_ticks(1_000_000, 1_000);
}

#[test]
fn at_two_kilohertz_and_four_megabaud() {
    a_million_ticks(4_000_000, 500);
}
