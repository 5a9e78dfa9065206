//! Armed and commanded over USB by the host's own client code, with servos of either firmware:
//! the arm is held, and what the processor decided is what this program decides.

use std::ops::Range;

use armbridge_analysis::plan_runner::{PlanRunner, Script};
use armbridge_control::experiment::Signal;
use armbridge_link::experiment::{Experiment, Role};
use armbridge_link::message::{Command, Drive, Limits, Record, Setup, ToBoard};
use armbridge_link::motion::Motion;
use armbridge_servo::Firmware;
use armbridge_sim::Bench;
use armbridge_sim::plant::Plant;
use armbridge_sim::servo_kind::ServoKind;
use armbridge_stm32_emulator::system::BusFaults;
use armbridge_stm32_emulator::time::Time;
use armbridge_tests::board_image::BoardRun;
use armbridge_tests::tapped_bench::{Action, ScriptedHost, assert_all_equal, replay};
use armbridge_tests::transparent_port;
use armbridge_tests::{assert_undisturbed, calibrations, plant};

use super::{TestBoard, us};

/// Instructions of an armed millisecond, all interrupts, telemetry and USB included.
const ARMED_MAX: u64 = 11_100;
/// Longest time from the end of the last stop bit until the direction pin is low.
const RELEASE_MAX: Time = us(2);

/// A host that has the arm regulated for 0.6 s.
fn regulation(setup: Setup) -> PlanRunner {
    PlanRunner::new(Script {
        setup,
        limits: Script::limits(),
        commands: vec![(0, Command::Regulate([0.0, 0.0]))],
        duration_us: 600_000,
    })
}

/// The run of a board that does so, to its end.
fn held(board: TestBoard, setup: Setup, bench: Bench) -> BoardRun<PlanRunner> {
    let mut run = board.on(bench, regulation(setup)).powered_up();
    let is_done = run.run_until(4_000, |run| {
        run.host_error.is_some() || armbridge_client::Host::is_done(&run.host)
    });
    assert!(is_done && run.host_error.is_none(), "{:?}", run.host_error);
    run
}

/// Times from the end of each transmission to the release of the bus, between these times.
fn releases(run: &BoardRun<PlanRunner>, during: Range<Time>) -> Vec<Time> {
    let system = &run.machine.system;
    let completed = system.bus_port().completed();
    let falls = system
        .edges()
        .iter()
        .filter(|edge| edge.pin == system.board.direction && !edge.is_high)
        .filter(|edge| during.contains(&edge.at));
    falls
        .filter_map(|edge| {
            let before = completed.partition_point(|end| *end <= edge.at);
            Some(edge.at - *completed.get(before.checked_sub(1)?)?)
        })
        .collect()
}

/// Records while the arm is regulated.
fn regulated(run: &BoardRun<PlanRunner>) -> Vec<Record> {
    let is_regulated = |record: &Record| record.mode.drive() == Some(Drive::Regulate);
    run.records().filter(is_regulated).collect()
}

/// Asserts that nothing was lost on link or bus, and that every tick is what this program computes
/// from the same samples, to the bit.
#[track_caller]
fn assert_intact(run: &BoardRun<PlanRunner>, driven: &[Record]) {
    assert!(driven.iter().all(|record| record.dropped == 0));
    assert_all_equal(&replay(&run.host.events));
    let system = &run.machine.system;
    assert_eq!(system.bus_faults(), BusFaults::default());
    assert_eq!(system.bus_port().overruns(), 0);
    assert_eq!(system.otg.refused(), 0);
}

fn the_arm_is_held_upright_as_the_bench_would(board: TestBoard) {
    for setup in [Setup::default(), Setup::best()] {
        let bench = Bench::new(Plant::new(plant([0.02, -0.02], true), 1));
        let run = held(board, setup, bench);
        let driven = regulated(&run);
        assert!(driven.len() > 550, "{}", driven.len());
        let angles = driven.iter().flat_map(|record| record.output.angle_rad);
        let furthest = angles.fold(0.0_f32, |most, angle| most.max(angle.abs()));
        assert!(furthest < 0.06, "{furthest} rad");
        assert!(driven.iter().all(|record| record.timing.missed == 0));
        assert_intact(&run, &driven);
        let latest = releases(&run, us(60_000)..run.machine.now())
            .into_iter()
            .max()
            .unwrap();
        assert!(latest <= RELEASE_MAX, "{} ns", latest.as_ns());
    }
}

fn an_armed_millisecond_costs_no_more_than_stated(board: TestBoard) {
    let bench = Bench::new(Plant::new(plant([0.02, -0.02], true), 1));
    let mut run = board.on(bench, regulation(Setup::default())).powered_up();
    let is_driven = |record: &Record| record.mode.drive() == Some(Drive::Regulate);
    let is_held = run.run_until(4_000, |run| run.records().filter(is_driven).count() > 200);
    assert!(is_held && run.host_error.is_none(), "{:?}", run.host_error);
    let (begun, before) = (run.machine.now(), run.machine.core.executed());
    let recorded = run.records().count();
    run.run_for(200);
    let executed = run.machine.core.executed() - before;
    let ms = (run.machine.now() - begun).as_ms();
    assert!(
        run.records()
            .skip(recorded)
            .all(|record| is_driven(&record))
    );
    assert!(run.records().count() > recorded + 190);
    let per_ms = (executed as f64 / ms) as u64;
    println!("{per_ms} instructions in an armed millisecond");
    assert!(per_ms <= ARMED_MAX, "{per_ms}");
}

/// Settings, motions, experiments of which one replaces another, and saves: the commands with the
/// deepest calls in the tick and in thread mode.
fn the_stack_has_room_for_every_command(board: TestBoard) {
    let hold = |torque_nm| {
        Command::Experiment(Experiment {
            roles: [Role::Hold, Role::Torque(Signal::Constant(torque_nm))],
            duration_s: 0.5,
            angle_rad: [[-0.8, 0.8]; 2],
            speed_rad_s: [2.0; 2],
        })
    };
    let motion = Motion::MinimumJerk {
        to_rad: [0.2, -0.2],
        duration_s: Some(1.0),
    };
    let commands = [
        (100, Command::Configure(Setup::best())),
        (150, Command::Limit(Limits::default())),
        (200, Command::Save),
        (300, Command::Arm { session: 0 }),
        (400, Command::Regulate([0.0, 0.0])),
        (500, Command::Follow(motion)),
        (2_000, hold(0.02)),
        (2_200, hold(0.03)),
        (2_800, Command::Idle),
        (2_900, Command::Save),
    ];
    let commands = commands.map(|(at_ms, command)| (at_ms * 1_000, Action::Command(command)));
    let first = (0, Action::Message(ToBoard::Heartbeat));
    let host = ScriptedHost::new([first].into_iter().chain(commands), 5_000_000);
    let mut run = board.with(host).powered_up();
    run.run_until(8_000, |run| armbridge_client::Host::is_done(&run.host));
    let drives: Vec<_> = run
        .records()
        .filter_map(|record| record.mode.drive())
        .collect();
    for drive in [Drive::Regulate, Drive::Track, Drive::Experiment] {
        assert!(drives.contains(&drive), "{drive:?}");
    }
    let stack = run.report().unwrap().stack.unwrap();
    println!("{} of {} bytes of stack", stack.used, stack.size);
    // More than what handlers above the tick take, 0.8 kB (`memory.x`).
    assert!(stack.used + 2_048 <= stack.size, "{stack:?}");
}

fn stock_servos_are_found_and_polled(board: TestBoard) {
    let kinds = [1, 2].map(|id| ServoKind::new(Firmware::Stock, id, 1_000_000).unwrap());
    let bench = Bench::with_servos(Plant::new(plant([0.02, -0.02], true), 1), &kinds);
    let host = ScriptedHost::new([], u64::MAX);
    let mut run = board.on(bench, host).powered_up();
    run.run_until(400, |_| false);
    let last = run.records().next_back();
    assert!(last.is_some_and(|record| {
        record
            .input
            .samples
            .iter()
            .all(|sample| sample.missing().is_none())
    }));
    assert_eq!(run.machine.system.bus_faults(), BusFaults::default());
}

/// X servos at the fastest rate of the board's port, at 1.8 and 2 kHz.
fn x_servos_are_driven_at_the_fastest_rate_of_the_port(board: TestBoard) {
    // USART3 at 42 MHz, USART6 at 84 MHz.
    let (baud, period_us) = if board.image == super::FEATHER.image {
        (3_000_000, 550)
    } else {
        (4_000_000, 500)
    };
    let setup = Setup {
        period_us,
        joints: calibrations(Firmware::XSeries),
        ..Setup::best()
    };
    let arm = plant([0.02, -0.02], true);
    let bench = transparent_port::bench(&arm, [Firmware::XSeries; 2], baud);
    let run = held(board, setup, bench);
    let driven = regulated(&run);
    assert!(driven.len() > 1_000, "{}", driven.len());
    assert_undisturbed(&driven);
    assert_intact(&run, &driven);
    // Amid the drive: a stop sequence keeps the line between its packets.
    let (from, until) = (
        run.machine.now() - us(500_000),
        run.machine.now() - us(200_000),
    );
    let latest = releases(&run, from..until).into_iter().max().unwrap();
    let bus_us = driven.iter().map(|record| record.timing.bus_us).max();
    println!(
        "{baud} baud: bus {bus_us:?} us, released after {} ns",
        latest.as_ns()
    );
    assert!(latest <= RELEASE_MAX, "{} ns", latest.as_ns());
}

on_each_board! {
    x_servos_are_driven_at_the_fastest_rate_of_the_port,
    the_arm_is_held_upright_as_the_bench_would,
    an_armed_millisecond_costs_no_more_than_stated,
    the_stack_has_room_for_every_command,
    stock_servos_are_found_and_polled,
}
