//! The firmware's own run, through the same code on the host.

use armbridge_analysis::plan_runner::{PlanRunner, Script};
use armbridge_client::event::EventKind;
use armbridge_control::experiment::Signal;
use armbridge_link::experiment::{Experiment, Role};
use armbridge_link::message::{Command, Drive, Record, Setup, ToHost};
use armbridge_link::motion::Motion;
use armbridge_sim::Bench;
use armbridge_sim::cosim::Cosim;
use armbridge_sim::emulator::{EmulatedBoard, Image, Qemu, QemuOptions, Time};
use armbridge_sim::plant::Plant;
use armbridge_tests::tapped_bench::{TappedHost, assert_all_equal, records, replay};
use armbridge_tests::{plant, sinusoid};

#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn what_the_processor_computed_is_the_same_here() {
    let board = Qemu::start(&QemuOptions {
        image: Image::current().unwrap(),
        time: Time::Lockstep,
        icount: false,
        provoke: None,
    });
    let board = EmulatedBoard::new(board.unwrap()).unwrap();
    let there = Motion::MinimumJerk {
        to_rad: [0.2, -0.2],
        duration_s: None,
    };
    let mut commands = vec![
        (0, Command::Regulate([0.0; 2])),
        (400_000, Command::Follow(there)),
        (900_000, Command::Follow(sinusoid(1.6))),
        (1_900_000, Command::Configure(Setup::default())),
        (2_500_000, Command::Torque([0.02, 0.0])),
        (2_600_000, Command::Regulate([0.0, 0.0])),
    ];
    let mut at_us = 3_200_000;
    for roles in experiments() {
        let plan = Experiment {
            roles,
            duration_s: 0.3,
            angle_rad: [[-0.9, 0.9]; 2],
            speed_rad_s: [2.5; 2],
        };
        commands.push((at_us, Command::Experiment(plan)));
        commands.push((at_us + 350_000, Command::Regulate([0.0; 2])));
        at_us += 700_000;
    }
    let script = Script {
        setup: Setup::best(),
        limits: Script::limits(),
        commands,
        duration_us: at_us,
    };
    let bench = Bench::new(Plant::new(plant([0.2, -0.2], true), 1));
    let mut run = Cosim::new(board, bench, TappedHost::new(PlanRunner::new(script)));
    run.run().unwrap();
    let report = replay(&run.host.events);
    assert_all_equal(&report);
    assert!(report.compared > 5_000, "{}", report.text());
    let is_experiment = |record: &Record| record.mode.drive() == Some(Drive::Experiment);
    let ticks = records(&run.host.events).filter(is_experiment).count();
    assert!(ticks > 1_000, "{ticks}");
    // The log names the program.
    let image = run.host.events.iter().find_map(|event| match event.kind {
        EventKind::Received(_, ToHost::Board(report)) => report.image,
        _ => None,
    });
    assert!(image.is_some());
}

/// Every kind of role and of signal.
fn experiments() -> [[Role; 2]; 4] {
    [
        [
            Role::Angle(Signal::Multisine {
                amplitude: 0.015,
                lowest_hz: 0.5,
                lines: 3,
                ramp_s: 0.1,
            }),
            Role::Pwm(Signal::Prbs {
                amplitude: 200.0,
                hold_s: 0.02,
                seed: 5,
            }),
        ],
        [
            Role::Hold,
            Role::Torque(Signal::Chirp {
                offset: 0.0,
                amplitude: 0.2,
                from_hz: 1.0,
                to_hz: 20.0,
                ramp_s: 0.05,
            }),
        ],
        [
            Role::Torque(Signal::Triangle {
                offset: 0.01,
                amplitude: 0.1,
                period_s: 0.13,
            }),
            Role::Pwm(Signal::Staircase {
                from: -90.0,
                to: 120.0,
                steps: 7,
                dwell_s: 0.01,
            }),
        ],
        [
            Role::Off,
            Role::Pwm(Signal::Steps {
                first: 50.0,
                increment: 33.3,
                steps: 9,
                on_s: 0.02,
                off_s: 0.013,
                alternating: true,
            }),
        ],
    ]
}
