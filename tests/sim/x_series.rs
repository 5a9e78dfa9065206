//! Servos of the X series on the bench: found, made ready, driven, and off.

use armbridge_analysis::plan_runner::{PlanError, PlanRunner, Script};
use armbridge_board::bridge::Channels;
use armbridge_link::message::{Command, Fault, Mode, Refusal, Setup};
use armbridge_servo::Firmware;
use armbridge_servo::protocol2::register;
use armbridge_sim::Bench;
use armbridge_sim::board::VirtualBoard;
use armbridge_sim::cosim::{Cosim, CosimError};
use armbridge_sim::half_duplex_bus::Device;
use armbridge_tests::torque_off::rig::{self, World, between_obstacles, with_rig};
use armbridge_tests::transparent_port::bench;
use armbridge_tests::{calibrations, plant, settling_s};

/// Time within which an X servo that receives nothing is off, in µs: its watchdog, a control step
/// and the packet before.
const WATCHDOG_US: u64 = 22_000;

fn setup() -> Setup {
    Setup {
        joints: calibrations(Firmware::XSeries),
        ..Setup::best()
    }
}

/// A register of a servo on the bench.
fn register_of(bench: &Bench, servo: usize, address: u16) -> i32 {
    match &bench.servos()[servo] {
        Device::X(servo) => servo.register(address).expect("a register"),
        Device::Morpheus(_) | Device::Stock(_) => panic!("an X servo"),
    }
}

#[test]
fn an_arm_of_two_x_servos_is_held_at_1_khz_and_given_back_off() {
    let mut channels = Channels::new();
    let board = VirtualBoard::new(channels.split()).unwrap();
    let bench = bench(
        &plant([0.3, -0.25], true),
        [Firmware::XSeries; 2],
        1_000_000,
    );
    let runner = PlanRunner::new(Script::upright(setup(), 3_000_000));
    let mut cosim = Cosim::new(board, bench, runner);
    cosim.run().expect("a run");
    let servos = cosim.host.status().servos.unwrap();
    assert_eq!(
        (servos.firmware, servos.baud),
        (Firmware::XSeries, 1_000_000)
    );
    for servo in [0, 1] {
        // PWM control mode, a return delay of 50 us, a watchdog of 20 ms.
        for (address, value) in [
            (register::OPERATING_MODE, 16),
            (register::RETURN_DELAY, 25),
            (register::BUS_WATCHDOG, 1),
        ] {
            assert_eq!(
                register_of(&cosim.bench, servo, address),
                value,
                "{address}"
            );
        }
    }
    let records = cosim.host.into_parts().0;
    let missing = records.iter().flat_map(|record| record.input.samples);
    assert_eq!(
        missing.filter(|sample| sample.counts().is_none()).count(),
        0
    );
    let last = records.last().unwrap();
    assert_eq!(last.timing.missed, records[0].timing.missed);
    assert!(!matches!(last.mode, Mode::Fault(_)), "{:?}", last.mode);
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
