//! The firmware's own run, through the same code on the host.

use armbridge::bench::Bench;
use armbridge::bench::cosim::Cosim;
use armbridge::bench::plant::Plant;
use armbridge::emulator::{EmulatedBoard, Qemu, QemuOptions, Time, qemu};
use armbridge::log::event::What;
use armbridge::operator::{Operator, Script};
use armbridge_shared::link::message::{Command, Setup, ToHost};
use armbridge_shared::link::motion::Motion;
use armbridge_tests::plant;

use crate::assert_all_equal;
use armbridge_tests::world::{Overheard, replay};

#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn what_the_processor_computed_is_the_same_here() {
    let board = Qemu::start(&QemuOptions {
        image: qemu::default_image(),
        time: Time::Lockstep,
        icount: false,
        provoke: None,
    });
    let board = EmulatedBoard::new(board.unwrap()).unwrap();
    let wave = Motion::Sinusoid {
        centre_rad: [0.0; 2],
        amplitude_rad: [0.2, 0.1],
        frequency_hz: [1.0, 0.7],
        phase_rad: [0.0; 2],
        ramp_s: 0.7,
        duration_s: 1.6,
    };
    let there = Motion::MinimumJerk {
        to_rad: [0.2, -0.2],
        duration_s: None,
    };
    let script = Script {
        setup: Setup::best(),
        commands: vec![
            (0, Command::Regulate([0.0; 2])),
            (400_000, Command::Follow(there)),
            (900_000, Command::Follow(wave)),
            (1_900_000, Command::Configure(Setup::default())),
            (2_500_000, Command::Torque([0.02, 0.0])),
            (2_600_000, Command::Regulate([0.1, 0.0])),
        ],
        duration_us: 2_800_000,
    };
    let bench = Bench::new(Plant::new(plant([0.2, -0.2], true), 1));
    let mut run = Cosim::new(board, bench, Overheard::new(Operator::new(script)));
    run.run().unwrap();
    let report = replay(&run.host.events);
    assert_all_equal(&report);
    assert!(report.compared > 2_000, "{}", report.text());
    // The log names the program.
    let image = run.host.events.iter().find_map(|event| match event.what {
        What::Told(_, ToHost::Board(report)) => report.image,
        _ => None,
    });
    assert!(image.is_some());
}
