//! Effects of the servos on the arm, and their protection.

use armbridge_servo::protocol1::Instruction;
use armbridge_servo::{Alarms, Firmware};

use super::Rig;
use crate::stock_servo::{at, pwm};

const SECOND_US: u64 = 1_000_000;
const CLOCKWISE: u16 = 1 << 10;

impl Rig {
    fn angles(&mut self) -> [f64; 2] {
        self.bench.state_at(self.now_us).q.into()
    }

    /// Full duty against the stop of joint 2, until it is reached.
    fn push_against_the_stop(&mut self) {
        self.wheel(2);
        self.set_word(2, at::MOVING_SPEED, 1023);
        self.wait(SECOND_US);
    }
}

#[test]
fn wheel_mode_is_a_duty_on_the_joint() {
    for (speed, sign, counts) in [(300, 1.0, 1293), (CLOCKWISE + 300, -1.0, 707)] {
        let mut rig = Rig::new();
        rig.wheel(2);
        assert_eq!(rig.bench.applied_pwm(1), 1000);
        rig.set_word(2, at::MOVING_SPEED, speed);
        let before = rig.register(1, "present_position");
        rig.wait(200_000);
        assert_eq!(rig.bench.applied_pwm(1), counts);
        assert_eq!(rig.register(1, "present_load"), u32::from(speed));
        let [_, angle] = rig.angles();
        assert!(angle * sign > 0.1, "{angle} rad");
        let moved = f64::from(rig.register(1, "present_position")) - f64::from(before);
        assert!(moved * sign > 20.0, "{moved} counts");
        let shown = rig.register(1, "present_speed");
        assert_eq!(shown & u32::from(CLOCKWISE) != 0, sign < 0.0, "{shown}");
        // Stopped by 0 of either direction, and by torque off.
        rig.set_word(2, at::MOVING_SPEED, speed & CLOCKWISE);
        rig.wait(2_000);
        assert_eq!(rig.bench.applied_pwm(1), 1000);
        rig.set_word(2, at::MOVING_SPEED, speed);
        rig.set(2, at::TORQUE_ENABLE, &[0]);
        rig.wait(2_000);
        assert_eq!(rig.bench.applied_pwm(1), 1000);
    }
    assert_eq!([-1023, 0, 1023].map(pwm), [0, 1000, 2000]);
}

#[test]
fn joint_mode_holds_a_position_against_gravity() {
    let mut rig = Rig::new();
    // 512 is upright; 60 counts are 0.31 rad.
    rig.set_word(1, at::MOVING_SPEED, 50);
    rig.set_word(2, at::MOVING_SPEED, 50);
    rig.set_word(1, at::GOAL_POSITION, 572);
    rig.set_word(2, at::GOAL_POSITION, 462);
    assert_eq!(rig.register(0, "torque_enable"), 1);
    assert_eq!(rig.register(0, "moving"), 1);
    rig.wait(3 * SECOND_US);
    let earlier = rig.angles();
    rig.wait(SECOND_US);
    let now = rig.angles();
    for (joint, goal_rad) in [(0, 0.307), (1, -0.256)] {
        // Compliance gives way by a few degrees, and friction holds it there.
        assert!((now[joint] - goal_rad).abs() < 0.06, "{now:?}");
        assert!(
            (now[joint] - earlier[joint]).abs() < 0.02,
            "{earlier:?} {now:?}"
        );
        assert_eq!(rig.register(joint, "moving"), 0);
    }
    assert_eq!(rig.alarms(1), Alarms::NONE);
}

#[test]
fn the_torque_limit_cuts_the_duty() {
    let mut rig = Rig::new();
    rig.wheel(2);
    rig.set_word(2, at::TORQUE_LIMIT, 200);
    rig.set_word(2, at::MOVING_SPEED, 900);
    rig.wait(2_000);
    assert_eq!(rig.bench.applied_pwm(1), pwm(200));
}

#[test]
fn overload_takes_the_torque_until_it_is_given_again() {
    let mut rig = Rig::new();
    rig.push_against_the_stop();
    assert_eq!(rig.bench.applied_pwm(1), 2000);
    assert_eq!(rig.alarms(2), Alarms::NONE);
    rig.wait(SECOND_US);
    assert_eq!(rig.bench.applied_pwm(1), 1000);
    assert_eq!(rig.register(1, "torque_enable"), 0);
    assert_eq!(rig.register(1, "torque_limit"), 0);
    // Each reply has it, any time later.
    rig.wait(5 * SECOND_US);
    let read = Instruction::Read {
        address: 36,
        count: 2,
    };
    assert_eq!(rig.ask(2, read)[4], Alarms::OVERLOAD.bits());
    // Torque alone does not bring it back: there is none to be had.
    assert_eq!(
        rig.write(2, at::TORQUE_ENABLE, &[1]),
        Some(Alarms::OVERLOAD)
    );
    rig.wait(5_000);
    assert_eq!(rig.alarms(2), Alarms::OVERLOAD);
    assert_eq!(rig.bench.applied_pwm(1), 1000);
    rig.write(2, at::TORQUE_LIMIT, &[0xFF, 3]);
    rig.wait(5_000);
    assert_eq!(rig.alarms(2), Alarms::NONE);
    assert_eq!(rig.bench.applied_pwm(1), 2000);
    rig.wait(2 * SECOND_US);
    assert_eq!(rig.alarms(2), Alarms::OVERLOAD);
}

#[test]
fn an_alarm_outside_the_shutdown_mask_is_only_reported() {
    let mut rig = Rig::new();
    rig.set(2, at::SHUTDOWN, &[Alarms::INPUT_VOLTAGE.bits()]);
    rig.wait(20_000);
    rig.push_against_the_stop();
    rig.wait(SECOND_US);
    assert_eq!(rig.alarms(2), Alarms::OVERLOAD);
    assert_eq!(rig.bench.applied_pwm(1), 2000);
    // It lasts as long as the load.
    rig.set_speed_whatever_it_says(500);
    assert_eq!(rig.alarms(2), Alarms::NONE);
    // Too little supply is in this mask.
    rig.bench.servo_mut(1).stock_mut().unwrap().set_supply(55);
    rig.wait(5_000);
    assert_eq!(rig.alarms(2), Alarms::INPUT_VOLTAGE);
    assert_eq!(rig.bench.applied_pwm(1), 1000);
    // And gone when that is, but the torque is not back.
    rig.bench.servo_mut(1).stock_mut().unwrap().set_supply(120);
    rig.wait(5_000);
    assert_eq!(rig.alarms(2), Alarms::NONE);
    assert_eq!(rig.register(1, "present_voltage"), 120);
    assert_eq!(rig.bench.applied_pwm(1), 1000);
}

impl Rig {
    fn set_speed_whatever_it_says(&mut self, speed: u16) {
        assert!(
            self.write(2, at::MOVING_SPEED, &speed.to_le_bytes())
                .is_some()
        );
        self.wait(5_000);
    }
}

#[test]
fn a_hot_servo_gives_up_until_it_is_cool() {
    let mut rig = Rig::new();
    rig.wheel(2);
    rig.set_word(2, at::MOVING_SPEED, 200);
    rig.bench
        .servo_mut(1)
        .stock_mut()
        .unwrap()
        .set_temperature(71.0);
    rig.wait(5_000);
    assert_eq!(rig.alarms(2), Alarms::OVERHEATING);
    assert_eq!(rig.bench.applied_pwm(1), 1000);
    // Too early.
    rig.write(2, at::TORQUE_LIMIT, &[0xFF, 3]);
    rig.write(2, at::TORQUE_ENABLE, &[1]);
    rig.wait(5_000);
    assert_eq!(rig.register(1, "torque_enable"), 0);
    rig.bench
        .servo_mut(1)
        .stock_mut()
        .unwrap()
        .set_temperature(60.0);
    rig.wait(5_000);
    rig.set_word(2, at::TORQUE_LIMIT, 1023);
    rig.set(2, at::TORQUE_ENABLE, &[1]);
    rig.wait(5_000);
    assert_eq!(rig.bench.applied_pwm(1), pwm(200));
}

#[test]
fn a_third_servo_turns_freely_and_the_arm_does_not_notice() {
    let mut rig = Rig::with(&[
        (Firmware::Morpheus, 1),
        (Firmware::Morpheus, 2),
        (Firmware::Stock, 3),
    ]);
    rig.set_word(3, at::MOVING_SPEED, 200);
    rig.set_word(3, at::GOAL_POSITION, 800);
    rig.wait(SECOND_US);
    // 22 rpm: 633 counts a second at most, here 288 in less than 0.7 s.
    assert!(rig.register(2, "present_position").abs_diff(800) <= 1);
    assert_eq!(rig.register(2, "moving"), 0);
    assert!(rig.angles().iter().all(|angle| angle.abs() < 1e-9));
}
