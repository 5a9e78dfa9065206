//! Limits of angle and temperature: a driven arm that is beyond one is off.

use armbridge_link::limits::hard;
use armbridge_link::message::{Command, Fault, Limits, Mode, Refusal, Setup};
use armbridge_servo::{Firmware, JOINTS};
use armbridge_sim::faults::sensor::SensorFault;
use armbridge_sim::plant::{PlantConfig, Push};
use armbridge_tests::calibrations;
use armbridge_tests::torque_off::cases::{all, check, run_cases};
use armbridge_tests::torque_off::rig::{Rig, STOP_US, World, bench, with_rig};

/// Torque in N m that takes a joint along, whatever its motor does.
const PUSHING_NM: f64 = 2.0;
/// Counts of an encoder that an estimate may be behind, in rad.
const BEHIND_RAD: f64 = 0.02;
/// Time for which it pushes, in µs: the arm is beyond its limit sooner.
const PUSHED_US: u64 = 1_000_000;
/// Time between two looks at the arm, in µs.
const STEP_US: u64 = 100;
/// Time in ms from a temperature beyond its limit to the fault: both servos are polled.
const POLLED_MS: u64 = 1_000;

/// Regulates at upright, at this period.
fn stand(rig: &mut Rig<'_>, firmware: Firmware, period_us: u32, limits: Limits) {
    let setup = Setup {
        period_us,
        joints: calibrations(firmware),
        ..Setup::best()
    };
    assert_eq!(rig.command(Command::Configure(setup)), Ok(()));
    assert_eq!(rig.command(Command::Limit(limits)), Ok(()));
    // X servos get the watchdog for this period.
    rig.until("ready", 2_000_000, |rig| rig.mode() == Some(Mode::Idle));
    rig.drive(Command::Regulate([0.0; JOINTS]));
    rig.pass_ms(300);
}

fn angle_rad(rig: &mut Rig<'_>, joint: usize) -> f64 {
    let now_us = rig.now_us();
    rig.cosim.bench.state_at(now_us).q[joint]
}

/// Limit of the angle in rad, period in µs, joint and torque in N m.
fn pushes() -> Vec<(f32, u32, usize, f64)> {
    let mut cases = Vec::new();
    // At the hard limit the counts of the encoder are a guard of their own.
    for limit_rad in [1.0, hard::ANGLE_RAD] {
        for period_us in [1_000, 5_000, 10_000] {
            for joint in 0..JOINTS {
                for torque_nm in [PUSHING_NM, -PUSHING_NM] {
                    cases.push((limit_rad, period_us, joint, torque_nm));
                }
            }
        }
    }
    cases
}

#[test]
fn an_arm_that_is_pushed_beyond_its_angle_limit_is_off_within_two_ticks() {
    run_cases(pushes(), |&(limit_rad, period_us, joint, torque_nm)| {
        let limits = Limits {
            angle_rad: [limit_rad; JOINTS],
            ..Limits::default()
        };
        let arm = bench(&PlantConfig::default(), Firmware::Morpheus);
        with_rig(World::Bench, arm, |rig| {
            stand(rig, Firmware::Morpheus, period_us, limits);
            rig.cosim.bench.push(Push {
                joint,
                torque_nm,
                start_ns: rig.now_us() * 1_000,
                duration_ns: PUSHED_US * 1_000,
            });
            let beyond_rad = f64::from(limit_rad) + BEHIND_RAD;
            let latest_us = rig.now_us() + PUSHED_US;
            while rig.now_us() < latest_us && angle_rad(rig, joint).abs() < beyond_rad {
                rig.until_us(rig.now_us() + STEP_US);
            }
            let beyond_us = rig.now_us();
            rig.until_us(beyond_us + 2 * u64::from(period_us));
            let mode = rig.mode();
            let off = rig.stays_off(beyond_us + STOP_US, 1_000);
            let is_fault = mode == Some(Mode::Fault(Fault::AngleLimit));
            all([
                off,
                check(is_fault, || format!("two ticks later: {mode:?}")),
            ])
        })
    });
}

#[test]
fn a_driven_servo_that_gets_hot_ends_the_drive() {
    // Below the temperature at which a stock or X servo releases its shaft by itself.
    let limits = Limits {
        temperature_c: 60,
        ..Limits::default()
    };
    // At 1 kHz the bus has no time for the temperature of a stock servo, and every 3 s for that of an X servo;
    // both have an alarm for it.
    let arms = [
        (Firmware::Morpheus, 1_000),
        (Firmware::Morpheus, 10_000),
        (Firmware::Stock, 10_000),
        (Firmware::XSeries, 2_000),
        (Firmware::XSeries, 10_000),
    ];
    let cases = arms.map(|(firmware, period_us)| [0, 1].map(|joint| (firmware, period_us, joint)));
    run_cases(cases.concat(), |&(firmware, period_us, joint)| {
        let arm = bench(&PlantConfig::default(), firmware);
        with_rig(World::Bench, arm, |rig| {
            if firmware != Firmware::Morpheus {
                rig.prepare();
            }
            stand(rig, firmware, period_us, limits);
            rig.pass_ms(POLLED_MS);
            // Beyond the limit at once.
            let servo = rig.cosim.bench.servo_mut(joint);
            if let Some(stock) = servo.stock_mut() {
                stock.set_temperature(65.0);
            } else if let Some(x) = servo.x_series_mut() {
                x.set_temperature(65.0);
            } else {
                let counts_per_s = 1e3 * f64::from(limits.temperature_drift_counts);
                let fault = SensorFault::Hot { counts_per_s };
                rig.cosim.bench.fail_sensor(joint, fault);
            }
            rig.pass_ms(POLLED_MS);
            let mode = rig.mode();
            let is_fault = mode == Some(Mode::Fault(Fault::Temperature));
            check(is_fault, || format!("{POLLED_MS} ms later: {mode:?}"))
        })
    });
}

/// A servo out of reach has no temperature that could come down; the fault is cleared to search for it, and the
/// arm stays disarmed until a reading is within the limit.
#[test]
fn a_hot_servo_that_is_out_of_reach_can_be_searched_for_and_not_armed() {
    run_cases([0, 1], |&joint| {
        let arm = bench(&PlantConfig::default(), Firmware::XSeries);
        with_rig(World::Bench, arm, |rig| {
            rig.prepare();
            stand(rig, Firmware::XSeries, 2_000, Limits::default());
            let set_celsius = |rig: &mut Rig<'_>, celsius| {
                let servo = rig.cosim.bench.servo_mut(joint).x_series_mut();
                servo.expect("an X servo").set_temperature(celsius);
            };
            set_celsius(rig, 71.0);
            rig.until("a fault", 2_000_000, |rig| {
                rig.fault() == Some(Fault::Temperature)
            });
            rig.pass_ms(500);
            let is_hot = Err(Refusal::Hot { joint: joint as u8 });
            let in_reach = rig.command(Command::ClearFault);
            rig.cosim.bench.deafen(joint, true);
            rig.pass_ms(100);
            let out_of_reach = rig.command(Command::ClearFault);
            rig.cosim.bench.deafen(joint, false);
            rig.until("idle", 5_000_000, |rig| rig.mode() == Some(Mode::Idle));
            let session = rig.host().session();
            let still_hot = rig.command(Command::Arm { session });
            set_celsius(rig, 40.0);
            rig.pass_ms(POLLED_MS);
            rig.prepare();
            let cool = rig.command(Command::Arm { session });
            let answers = [in_reach, out_of_reach, still_hot, cool];
            check(answers == [is_hot, Ok(()), is_hot, Ok(())], || {
                format!("{answers:?}")
            })
        })
    });
}

/// At 1 kHz its temperature is read every 3 s: the alert in its replies is the guard.
#[test]
fn an_x_servo_that_is_hot_at_1_khz_ends_the_drive_by_its_own_alert() {
    run_cases([0, 1], |&joint| {
        let arm = bench(&PlantConfig::default(), Firmware::XSeries);
        with_rig(World::Bench, arm, |rig| {
            rig.prepare();
            stand(rig, Firmware::XSeries, 1_000, Limits::default());
            let servo = rig.cosim.bench.servo_mut(joint).x_series_mut();
            // Beyond the XL430's limit of 72 °C.
            servo.expect("an X servo").set_temperature(75.0);
            let hot_us = rig.now_us();
            let off = rig.stays_off(hot_us + STOP_US, POLLED_MS);
            let mode = rig.mode();
            let is_fault = mode == Some(Mode::Fault(Fault::ServoAlarm));
            all([off, check(is_fault, || format!("{mode:?}"))])
        })
    });
}
