//! Outages of the wire to servos that are driven. Stock servos keep their last duty, and are off
//! as soon as the wire can carry a packet again; X servos are off by their watchdog during it.
//!
//! Standing is not off: an arm that presses against an obstacle, or leans on its
//! motors, stands still with its motors on. Nor is a servo off that hears the stop as the rest of
//! a long packet.

use armbridge_link::message::{Command, Setup};
use armbridge_servo::{Firmware, JOINTS};
use armbridge_sim::plant::PlantConfig;
use armbridge_tests::torque_off::cases::{all, run_cases};
use armbridge_tests::torque_off::rig::{
    STOP_US, WATCHDOG_US, World, bench, between_obstacles, with_rig,
};
use armbridge_tests::{calibrations, plant};

/// Lengths of outages in ms: longer than samples may be missing.
const CUTS_MS: [u64; 5] = [30, 60, 90, 200, 400];
/// Beginnings of outages within a tick of 1 ms, in µs.
const PHASES_US: [u64; 2] = [0, 550];
/// Time from the command to the outage, in ms.
const DRIVEN_MS: u64 = 500;

/// State of the arm when the wire is cut.
#[derive(Clone, Copy, Debug)]
enum Arm {
    /// It presses against an obstacle.
    Presses,
    /// It is held aslant; gravity and friction balance its last torque.
    Leans,
    /// It stands.
    Stands,
    /// It moves.
    Swings,
}

impl Arm {
    fn plant(self) -> PlantConfig {
        match self {
            Self::Presses => between_obstacles(),
            Self::Leans => plant([0.3, -0.2], true),
            Self::Stands => plant([0.0; 2], true),
            Self::Swings => plant([0.4, 0.4], false),
        }
    }

    fn command(self) -> Command {
        match self {
            Self::Presses => Command::Torque([0.25, 0.15]),
            Self::Leans => Command::Regulate([0.3, -0.2]),
            Self::Stands => Command::Regulate([0.0; 2]),
            Self::Swings => Command::Regulate([-0.6, 0.2]),
        }
    }

    fn driven_ms(self) -> u64 {
        match self {
            Self::Presses | Self::Leans | Self::Stands => DRIVEN_MS,
            Self::Swings => 150,
        }
    }
}

fn outage(firmware: Firmware, arm: Arm, cut_ms: u64, phase_us: u64) -> Result<(), String> {
    with_rig(World::Bench, bench(&arm.plant(), firmware), |rig| {
        rig.prepare();
        let setup = Setup {
            joints: calibrations(firmware),
            ..Setup::best()
        };
        assert_eq!(rig.command(Command::Configure(setup)), Ok(()));
        rig.drive(arm.command());
        rig.pass_ms(arm.driven_ms());
        rig.until_us(rig.now_us().next_multiple_of(1_000) + phase_us);
        let mode = rig.mode();
        assert!(
            mode.is_some_and(|mode| mode.drive().is_some()),
            "{arm:?}: {mode:?}"
        );
        rig.cosim.bench.hold_high(cut_ms * 1_000);
        let cut_us = rig.now_us();
        let off_us = match firmware {
            Firmware::XSeries => cut_us + WATCHDOG_US,
            Firmware::Morpheus | Firmware::Stock => cut_us + cut_ms * 1_000 + STOP_US,
        };
        all([
            rig.stays_off(off_us, World::Bench.watch_ms()),
            rig.reports_are_true(),
            rig.is_reported_off(),
        ])
    })
}

fn outages(arm: Arm) {
    let cases = [Firmware::Stock, Firmware::XSeries]
        .into_iter()
        .flat_map(|firmware| {
            let both = move |cut_ms| PHASES_US.map(move |phase_us| (firmware, cut_ms, phase_us));
            CUTS_MS.into_iter().flat_map(both)
        });
    run_cases(cases, |(firmware, cut_ms, phase_us)| {
        outage(*firmware, arm, *cut_ms, *phase_us)
    });
}

/// The longest packet to each servo, of which the rest never comes.
const BEGUN: [[u8; 4]; JOINTS] = [[0xFF, 0xFF, 1, 0xFE], [0xFF, 0xFF, 2, 0xFE]];

/// Five ticks, in ms: a fault then.
const FAULT_MS: u64 = 50;

/// Ticks that are 10 ms apart take 80 ms for the rest of such a packet.
#[test]
fn a_servo_that_waits_for_a_long_packet_after_an_outage_is_off() {
    let setup = Setup {
        period_us: 10_000,
        ..Setup::best()
    };
    let long_ms = CUTS_MS.into_iter().filter(|cut_ms| *cut_ms > FAULT_MS);
    let cases = long_ms.flat_map(|cut_ms| BEGUN.map(|begun| (begun, cut_ms)));
    run_cases(cases, |(begun, cut_ms)| {
        let bench = bench(&between_obstacles(), Firmware::Stock);
        with_rig(World::Bench, bench, |rig| {
            rig.prepare();
            assert_eq!(rig.command(Command::Configure(setup)), Ok(()));
            rig.drive(Arm::Presses.command());
            rig.pass_ms(DRIVEN_MS);
            rig.cosim.bench.hold_high(cut_ms * 1_000);
            rig.pass_ms(*cut_ms);
            let whole_us = rig.now_us();
            rig.cosim.bench.send_foreign(whole_us, begun, 1_000_000);
            all([
                rig.stays_off(whole_us + STOP_US, World::Bench.watch_ms()),
                rig.reports_are_true(),
                rig.is_reported_off(),
            ])
        })
    });
}

#[test]
fn an_arm_that_presses_against_an_obstacle_is_off_after_an_outage() {
    outages(Arm::Presses);
}

#[test]
fn an_arm_that_leans_is_off_after_an_outage() {
    outages(Arm::Leans);
}

#[test]
fn an_arm_that_stands_is_off_after_an_outage() {
    outages(Arm::Stands);
}

#[test]
fn an_arm_that_swings_is_off_after_an_outage() {
    outages(Arm::Swings);
}
