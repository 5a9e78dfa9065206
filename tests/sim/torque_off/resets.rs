//! Reset of a servo in mid-run: it lets go of its shaft. A stock servo answers as before, and an X
//! servo is silent for as long as it boots.

use armbridge_link::message::{Command, Fault, Mode, Setup};
use armbridge_servo::{Firmware, JOINTS};
use armbridge_sim::plant::PlantConfig;
use armbridge_tests::torque_off::cases::{all, check, run_cases};
use armbridge_tests::torque_off::rig::{STOP_US, World, bench, between_obstacles, with_rig};
use armbridge_tests::{calibrations, plant};

/// Time from the reset to the fault, in µs.
const NOTICED_US: u64 = 100_000;

/// Instants of a reset in ms of the run, so that it meets each phase of the readings of the
/// torque enable, and their very packets.
const PHASES_MS: std::ops::Range<u64> = 500..590;

/// State of the arm at the reset.
#[derive(Clone, Copy, Debug)]
enum Arm {
    Stands,
    Leans,
    Presses,
}

impl Arm {
    fn plant(self) -> PlantConfig {
        match self {
            Self::Stands => plant([0.0; 2], true),
            Self::Leans => plant([0.3, -0.2], true),
            Self::Presses => between_obstacles(),
        }
    }

    fn command(self) -> Command {
        match self {
            Self::Stands => Command::Regulate([0.0; 2]),
            Self::Leans => Command::Regulate([0.3, -0.2]),
            Self::Presses => Command::Torque([0.2, 0.2]),
        }
    }
}

fn is_noticed(firmware: Firmware, arm: Arm, servo: usize, after_ms: u64) -> Result<(), String> {
    let expected = match firmware {
        Firmware::Morpheus | Firmware::Stock => Fault::ServoReset,
        Firmware::XSeries => Fault::ServoSilent,
    };
    with_rig(World::Bench, bench(&arm.plant(), firmware), |rig| {
        rig.prepare();
        let setup = Setup {
            joints: calibrations(firmware),
            ..Setup::best()
        };
        assert_eq!(rig.command(Command::Configure(setup)), Ok(()));
        rig.drive(arm.command());
        rig.pass_ms(after_ms);
        let mode = rig.mode();
        assert!(
            mode.is_some_and(|mode| mode.drive().is_some()),
            "{arm:?}: {mode:?}"
        );
        rig.cosim.bench.power_cycle(servo);
        let reset_us = rig.now_us();
        rig.until_us(reset_us + NOTICED_US);
        let (mode, fault) = (rig.mode(), rig.fault());
        all([
            check(matches!(mode, Some(Mode::Fault(_))), || {
                format!("{} ms after the reset {mode:?}", NOTICED_US / 1_000)
            }),
            check(fault == Some(expected), || {
                format!("reported fault {fault:?}")
            }),
            rig.stays_off(reset_us + NOTICED_US + STOP_US, World::Bench.watch_ms()),
            rig.reports_are_true(),
        ])
    })
}

#[test]
fn a_servo_that_is_reset_ends_the_run() {
    let arms = [Arm::Stands, Arm::Leans, Arm::Presses];
    let cases = [Firmware::Stock, Firmware::XSeries]
        .into_iter()
        .flat_map(|firmware| {
            let both = move |arm| [0, JOINTS - 1].map(move |servo| (firmware, arm, servo));
            arms.into_iter().flat_map(both)
        });
    run_cases(cases, |(firmware, arm, servo)| {
        is_noticed(*firmware, *arm, *servo, PHASES_MS.start)
    });
}

#[test]
fn a_stock_servo_that_is_reset_at_any_instant_ends_the_run() {
    let cases = PHASES_MS.flat_map(|after_ms| [0, JOINTS - 1].map(|servo| (after_ms, servo)));
    run_cases(cases, |(after_ms, servo)| {
        is_noticed(Firmware::Stock, Arm::Leans, *servo, *after_ms)
    });
}
