//! Bus watchdog, hardware errors, shutdown and reboot: when the motor is off.

use armbridge_servo::protocol2::register as at;
use armbridge_servo::protocol2::{Instruction, StatusError};

use super::super::protect::error;
use super::Rig;

const MS: u64 = 1_000_000;

/// PWM mode, a duty, torque on.
fn driven(number: u16, duty: i16) -> Rig {
    let mut rig = Rig::new(&[(number, 1), (1060, 2)]);
    rig.set(1, at::OPERATING_MODE, &[16]);
    rig.set(1, at::GOAL_PWM, &duty.to_le_bytes());
    rig.set(1, at::TORQUE_ENABLE, &[1]);
    rig.wait(30 * MS);
    rig
}

#[test]
fn the_watchdog_stops_a_servo_after_its_time_of_silence() {
    let mut rig = driven(1060, 300);
    assert_eq!(rig.shafts.last(0).unwrap().1, 1339);
    rig.set(1, at::BUS_WATCHDOG, &[3]);
    // Packets to any servo feed it.
    for _ in 0..10 {
        rig.ask(2, Instruction::Ping);
        rig.wait(50 * MS);
    }
    assert_eq!(rig.shafts.last(0).unwrap().1, 1339);
    let end_ns = rig.now_ns + 10 * 10_000;
    rig.ask(2, Instruction::Ping);
    rig.wait(100 * MS);
    let (off_ns, pwm) = rig.shafts.last(0).unwrap();
    assert_eq!(pwm, 1000);
    let after_ns = off_ns - end_ns;
    assert!((60 * MS..62 * MS).contains(&after_ns), "{after_ns} ns");
    assert_eq!(rig.register(0, at::GOAL_PWM), 0);
    assert_eq!(rig.register(0, at::TORQUE_ENABLE), 1);
    assert_eq!(rig.servo(0).memory.byte(at::BUS_WATCHDOG), 0xFF);
    // Goals can only be read until it is cleared.
    let goal = 100_i16.to_le_bytes();
    let range = Err(Some(StatusError::DataRange));
    assert_eq!(rig.write(1, at::GOAL_PWM, &goal), range);
    assert_eq!(rig.write(1, at::BUS_WATCHDOG, &[5]), range);
    rig.set(1, at::BUS_WATCHDOG, &[0]);
    rig.wait(5 * MS);
    assert_eq!(rig.servo(0).pwm(), 1000);
    rig.set(1, at::GOAL_PWM, &goal);
    rig.wait(200 * MS);
    assert_eq!(rig.shafts.last(0).unwrap().1, 1113);
}

#[test]
fn the_watchdog_waits_while_torque_is_off() {
    let mut rig = driven(1060, 300);
    rig.set(1, at::TORQUE_ENABLE, &[0]);
    rig.set(1, at::BUS_WATCHDOG, &[1]);
    rig.wait(500 * MS);
    assert_eq!(rig.register(0, at::BUS_WATCHDOG), 1);
    // The time begins with the packet that enables torque.
    rig.set(1, at::TORQUE_ENABLE, &[1]);
    rig.wait(15 * MS);
    assert_eq!(rig.servo(0).pwm(), 1339);
    rig.wait(10 * MS);
    assert_eq!(rig.servo(0).pwm(), 1000);
}

#[test]
fn a_pwm_slope_is_kept_except_by_torque_off() {
    // The e-Manual's example: 18 ms from 0 to full.
    let mut rig = driven(1200, 0);
    let start_ns = rig.now_ns;
    rig.set(1, at::GOAL_PWM, &885_i16.to_le_bytes());
    rig.wait(30 * MS);
    let (at_ns, pwm) = rig.shafts.last(0).unwrap();
    assert_eq!(pwm, 2000);
    assert!((18 * MS..20 * MS).contains(&(at_ns - start_ns)));
    let off_ns = rig.now_ns;
    rig.set(1, at::TORQUE_ENABLE, &[0]);
    let (at_ns, pwm) = rig.shafts.last(0).unwrap();
    assert_eq!(pwm, 1000);
    assert!(at_ns - off_ns < 2 * MS);
}

#[test]
fn a_hardware_error_is_an_alert_and_shuts_down_until_a_reboot() {
    let mut rig = driven(1060, 300);
    rig.servo(0).set_temperature(73.0);
    rig.wait(2 * MS);
    assert_eq!(rig.servo(0).pwm(), 1000);
    let status = rig.status(1, Instruction::Ping);
    assert!(status.is_alert && status.error.is_none());
    assert_eq!(
        rig.register(0, at::HARDWARE_ERROR),
        i32::from(error::OVERHEATING)
    );
    assert_eq!(rig.register(0, at::TORQUE_ENABLE), 0);
    // Cooling down is not enough.
    rig.servo(0).cool();
    rig.wait(5 * MS);
    let refused = rig.write(1, at::TORQUE_ENABLE, &[1]);
    assert_eq!(refused, Err(Some(StatusError::Failed)));
    rig.ask(1, Instruction::Reboot);
    assert!(rig.ask(1, Instruction::Ping).is_empty());
    rig.wait(super::START_NS);
    assert!(!rig.status(1, Instruction::Ping).is_alert);
    rig.set(1, at::GOAL_PWM, &300_i16.to_le_bytes());
    rig.set(1, at::TORQUE_ENABLE, &[1]);
    assert_eq!(rig.servo(0).pwm(), 1339);
}

#[test]
fn a_reboot_switches_the_motor_off_at_once() {
    let mut rig = driven(1060, 300);
    let asked_ns = rig.now_ns;
    rig.ask(1, Instruction::Reboot);
    let (off_ns, pwm) = rig.shafts.last(0).unwrap();
    assert_eq!(pwm, 1000);
    assert!(off_ns - asked_ns < MS);
}

#[test]
fn a_stall_at_full_duty_is_an_overload() {
    let mut rig = driven(1060, 885);
    rig.wait(1_100 * MS);
    assert_eq!(
        rig.register(0, at::HARDWARE_ERROR),
        i32::from(error::OVERLOAD)
    );
    assert_eq!(rig.servo(0).pwm(), 1000);
    // Not while it turns.
    let mut rig = driven(1060, 885);
    rig.shafts.speeds[0] = 2;
    rig.wait(2_000 * MS);
    assert_eq!(rig.register(0, at::HARDWARE_ERROR), 0);
    // And not at a part of it.
    let mut rig = driven(1060, 800);
    rig.wait(2_000 * MS);
    assert_eq!(rig.register(0, at::HARDWARE_ERROR), 0);
}

#[test]
fn a_wrong_supply_without_a_shutdown_is_an_alert_while_it_lasts() {
    let mut rig = driven(1060, 300);
    rig.servo(0).set_supply(55);
    rig.wait(2 * MS);
    assert!(rig.status(1, Instruction::Ping).is_alert);
    assert_eq!(rig.servo(0).pwm(), 1339);
    rig.servo(0).set_supply(111);
    rig.wait(2 * MS);
    assert!(!rig.status(1, Instruction::Ping).is_alert);
}
