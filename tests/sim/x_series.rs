//! Servos of the X series on the bench: found, made ready, driven, and off.

use armbridge_analysis::plan_runner::{PlanError, PlanRunner, Script};
use armbridge_board::bridge::Channels;
use armbridge_link::message::{Command, Fault, Mode, Refusal, Setup};
use armbridge_servo::Firmware;
use armbridge_servo::protocol2::{model, register};
use armbridge_sim::Bench;
use armbridge_sim::board::VirtualBoard;
use armbridge_sim::cosim::{Cosim, CosimError};
use armbridge_sim::plant::Plant;
use armbridge_sim::x_servo::XServo;
use armbridge_tests::torque_off::rig::{self, WATCHDOG_US, World, between_obstacles, with_rig};
use armbridge_tests::torque_off::x_servos::{
    register_of, settings_are_saved_while_servos_are_ready,
};
use armbridge_tests::transparent_port::bench;
use armbridge_tests::{assert_undisturbed, calibrations, plant, settling_s, with_encoders};

/// Code of 1 Mbaud.
const BAUD_1_000_000: u8 = 3;

fn setup() -> Setup {
    Setup {
        joints: calibrations(Firmware::XSeries),
        ..Setup::best()
    }
}

/// Holds an arm of X servos upright at 1 kHz, and checks that it does; the bench afterwards.
#[track_caller]
fn hold(bench: Bench) -> Bench {
    let mut channels = Channels::new();
    let board = VirtualBoard::new(channels.split()).unwrap();
    let runner = PlanRunner::new(Script::upright(setup(), 3_000_000));
    let mut cosim = Cosim::new(board, bench, runner);
    cosim.run().expect("a run");
    let servos = cosim.host.status().servos.unwrap();
    assert_eq!(
        (servos.firmware, servos.baud),
        (Firmware::XSeries, 1_000_000)
    );
    let records = cosim.host.into_parts().0;
    assert_undisturbed(&records);
    let settled = [0, 1].map(|joint| settling_s(&records, joint, 0.02).expect("settled"));
    let rest = &records[records.len() - 500..];
    let far = rest.iter().flat_map(|record| record.output.angle_rad);
    let rest_rad = far.fold(0.0, |most: f32, angle| most.max(angle.abs()));
    let bus_us = records
        .iter()
        .map(|record| record.timing.bus_us)
        .max()
        .unwrap();
    println!("settled {settled:.2?} s, at rest off by {rest_rad:.4} rad, bus {bus_us} us");
    // A count is 1.5 mrad.
    assert!(rest_rad < 0.005, "{rest_rad}");
    assert!(bus_us <= 1_000, "{bus_us}");
    cosim.bench
}

#[test]
fn an_arm_of_two_x_servos_is_held_at_1_khz_and_given_back_off() {
    let bench = hold(bench(
        &plant([0.3, -0.25], true),
        [Firmware::XSeries; 2],
        1_000_000,
    ));
    for servo in [0, 1] {
        // PWM control mode, a return delay of 50 us, a watchdog of 20 ms.
        for (address, value) in [
            (register::OPERATING_MODE, 16),
            (register::RETURN_DELAY, 25),
            (register::BUS_WATCHDOG, 1),
        ] {
            assert_eq!(register_of(&bench, servo, address), value, "{address}");
        }
    }
}

/// An XL330-M288 and an XL430-W250, in either order.
#[test]
fn servos_of_two_models_are_held_as_those_of_one() {
    let models = [1_200, 1_060].map(|number| model::find(number).expect("a model"));
    for order in [[0, 1], [1, 0]] {
        let arm = with_encoders(plant([0.3, -0.25], true), Firmware::XSeries);
        let servos = [0, 1].map(|servo| {
            let (model, id) = (models[order[servo]], servo as u8 + 1);
            XServo::new(model, id, BAUD_1_000_000).into()
        });
        let bench = hold(Bench::with_devices(Plant::new(arm, 1), servos.into()));
        let held = [0, 1].map(|servo| register_of(&bench, servo, register::MODEL_NUMBER));
        let numbers = order.map(|index| i32::from(models[index].number));
        assert_eq!(held, numbers);
    }
}

#[test]
fn a_calibration_of_other_servos_is_refused() {
    let mut channels = Channels::new();
    let board = VirtualBoard::new(channels.split()).unwrap();
    let bench = bench(&plant([0.1, -0.1], true), [Firmware::XSeries; 2], 1_000_000);
    let runner = PlanRunner::new(Script::upright(Setup::best(), 1_000_000));
    let mut cosim = Cosim::new(board, bench, runner);
    match cosim.run() {
        Err(CosimError::Host(PlanError::Refused {
            refusal: Refusal::OtherEncoder { joint: 0 },
            ..
        })) => {}
        other => panic!("{other:?}"),
    }
    assert_eq!(
        [0, 1].map(|servo| cosim.bench.applied_pwm(servo)),
        [1_000; 2]
    );
}

#[test]
fn a_servo_without_a_bus_is_off_by_its_own_watchdog() {
    let servos = rig::bench(&between_obstacles(), Firmware::XSeries);
    with_rig(World::Bench, servos, |rig| {
        assert_eq!(rig.command(Command::Configure(setup())), Ok(()));
        rig.prepare();
        // Beyond the obstacles.
        rig.drive(Command::Regulate([0.2; 2]));
        rig.pass_ms(200);
        assert_ne!(rig.is_on(), [false; 2], "it presses against an obstacle");
        // Both wires are cut: no packet reaches a servo, whatever the board does.
        for servo in [0, 1] {
            rig.cosim.bench.disconnect(servo);
        }
        let cut_us = rig.now_us();
        let after = rig.stays_off(cut_us + WATCHDOG_US, 2_000);
        assert_eq!(after, Ok(()));
        assert!(
            matches!(rig.mode(), Some(Mode::Fault(Fault::ServoSilent))),
            "{:?}",
            rig.mode()
        );
    });
}

/// Units of 20 ms of the watchdog, by the tick's period in µs.
const WATCHDOGS: [(u32, i32); 4] = [(1_000, 1), (4_000, 1), (5_000, 2), (10_000, 3)];

#[test]
fn the_watchdog_of_a_servo_follows_the_period() {
    for (period_us, units) in WATCHDOGS {
        let servos = rig::bench(&plant([0.0; 2], true), Firmware::XSeries);
        with_rig(World::Bench, servos, |rig| {
            // Ready at another period, then made ready for this one without being asked to.
            assert_eq!(rig.command(Command::Configure(setup())), Ok(()));
            rig.prepare();
            let at_period = Setup {
                period_us,
                ..setup()
            };
            assert_eq!(rig.command(Command::Configure(at_period)), Ok(()));
            rig.until("ready", 2_000_000, |rig| rig.mode() == Some(Mode::Idle));
            for servo in [0, 1] {
                let watchdog = register_of(&rig.cosim.bench, servo, register::BUS_WATCHDOG);
                assert_eq!(watchdog, units, "{period_us} us");
            }
            // Where its weight has to be held.
            rig.drive(Command::Regulate([0.4, 0.2]));
            rig.pass_ms(1_000);
            assert_ne!(rig.is_on(), [false; 2], "it holds its weight");
            // The bus is silent for nearly as long as the board allows.
            let silent_us = 4 * u64::from(period_us);
            for servo in [0, 1] {
                rig.cosim.bench.disconnect(servo);
            }
            rig.until_us(rig.now_us() + silent_us);
            for servo in [0, 1] {
                rig.cosim.bench.reconnect(servo);
            }
            rig.pass_ms(200);
            assert!(
                matches!(rig.mode(), Some(Mode::Running(_))),
                "{period_us} us: {:?}",
                rig.mode()
            );
            // And then for good.
            for servo in [0, 1] {
                rig.cosim.bench.disconnect(servo);
            }
            let off_us = rig.now_us() + WATCHDOG_US + (units as u64 - 1) * 20_000;
            assert_eq!(rig.stays_off(off_us, 1_000), Ok(()), "{period_us} us");
        });
    }
}

/// Runs on one board, at periods that need other watchdogs.
#[test]
fn a_run_at_another_period_waits_for_servos_that_are_made_ready_again() {
    let run = |period_us| {
        let setup = Setup {
            period_us,
            ..setup()
        };
        PlanRunner::new(Script::upright(setup, 1_000_000))
    };
    let mut channels = Channels::new();
    let board = VirtualBoard::new(channels.split()).unwrap();
    // Upright, friction keeps it where it is between two runs.
    let bench = bench(
        &plant([0.05, -0.05], true),
        [Firmware::XSeries; 2],
        1_000_000,
    );
    let mut cosim = Cosim::new(board, bench, run(1_000));
    for (period_us, units) in [(1_000, 1), (10_000, 3), (2_000, 1)] {
        cosim.host = run(period_us);
        cosim
            .run()
            .unwrap_or_else(|error| panic!("{period_us} us: {error:?}"));
        let watchdog = register_of(&cosim.bench, 0, register::BUS_WATCHDOG);
        assert_eq!(watchdog, units, "{period_us} us");
    }
}

#[test]
fn settings_are_saved_while_they_are_ready() {
    settings_are_saved_while_servos_are_ready(World::Bench);
}
