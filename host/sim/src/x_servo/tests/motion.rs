//! Operating modes: on a shaft by hand, and on an arm.

use armbridge_servo::protocol2::register as at;
use armbridge_servo::protocol2::{Instruction, model};

use super::super::XServo;
use super::{CODE_1M, Rig, START_NS};
use crate::Bench;
use crate::plant::{Plant, PlantConfig, PlantFile};

const MS: u64 = 1_000_000;

/// One servo with this operating mode and these values of two bytes, torque on.
fn rig(number: u16, mode: u8, values: &[(u16, i16)]) -> Rig {
    let mut rig = Rig::new(&[(number, 1)]);
    rig.restart_at([2_000, 0, 0]);
    rig.set(1, at::OPERATING_MODE, &[mode]);
    for (address, value) in values {
        rig.set(1, *address, &value.to_le_bytes());
    }
    rig.set(1, at::TORQUE_ENABLE, &[1]);
    rig.wait(20 * MS);
    rig
}

fn pwm(rig: &mut Rig) -> i32 {
    rig.wait(100 * MS);
    rig.register(0, at::PRESENT_PWM)
}

#[test]
fn the_goal_pwm_is_the_duty_within_its_limit() {
    let mut rig = rig(1060, 16, &[(at::GOAL_PWM, -250)]);
    assert_eq!(pwm(&mut rig), -250);
    assert_eq!(rig.servo(0).pwm(), 718);
    assert_eq!(rig.register(0, at::PRESENT_CURRENT), -282);
    rig.set(1, at::TORQUE_ENABLE, &[0]);
    assert_eq!(rig.servo(0).pwm(), 1000);
}

#[test]
fn an_operating_mode_resets_gains_and_goals() {
    let mut rig = Rig::new(&[(1200, 1)]);
    rig.set(1, at::POSITION_P_GAIN, &[1, 0]);
    rig.set(1, at::PROFILE_VELOCITY, &[1, 0, 0, 0]);
    rig.set(1, at::GOAL_PWM, &[0, 0]);
    rig.set(1, at::OPERATING_MODE, &[16]);
    let addresses = [
        at::POSITION_P_GAIN,
        at::PROFILE_VELOCITY,
        at::GOAL_PWM,
        at::GOAL_CURRENT,
    ];
    let found = addresses.map(|address| rig.register(0, address));
    assert_eq!(found, [400, 0, 885, 1_750]);
}

#[test]
fn a_position_error_times_the_gain_is_the_duty() {
    // P/128 by the e-Manual, P/256 for the smaller frame.
    for (number, gain, duty) in [(1060, 640, 500), (1200, 400, 156)] {
        let mut rig = rig(number, 3, &[(at::POSITION_P_GAIN, gain)]);
        // Enabling torque does not move it.
        assert_eq!(pwm(&mut rig), 0);
        rig.set(1, at::GOAL_POSITION, &2_100_i32.to_le_bytes());
        assert_eq!(pwm(&mut rig), duty, "{number}");
        // The goal PWM is a limit.
        rig.set(1, at::GOAL_PWM, &[50, 0]);
        assert_eq!(pwm(&mut rig), 50);
    }
}

#[test]
fn a_speed_is_controlled_with_an_integral() {
    let mut rig = rig(1060, 1, &[]);
    rig.set(1, at::GOAL_VELOCITY, &100_i32.to_le_bytes());
    // 100/128 of 100, and 1000/65536 of 100 each millisecond.
    let before = pwm(&mut rig);
    let after = pwm(&mut rig);
    assert!((225..240).contains(&before), "{before}");
    assert!((150..155).contains(&(after - before)), "{after}");
}

#[test]
fn turns_are_counted_until_they_are_cleared() {
    let mut rig = rig(1060, 4, &[(at::GOAL_PWM, 0)]);
    rig.shafts.speeds[0] = 10;
    rig.wait(1_000 * MS);
    let position = rig.register(0, at::PRESENT_POSITION);
    assert!((11_900..12_300).contains(&position), "{position}");
    // 10 counts a ms are 146.3 rpm, in 0.229 rpm.
    let speed = rig.register(0, at::PRESENT_VELOCITY);
    assert!((637..642).contains(&speed), "{speed}");
    assert_eq!(rig.register(0, at::MOVING), 1);
    let failed = rig.status(1, Instruction::ClearTurns);
    assert!(failed.error.is_some());
    rig.shafts.speeds[0] = 0;
    rig.wait(50 * MS);
    assert_eq!(rig.status(1, Instruction::ClearTurns).error, None);
    rig.wait(5 * MS);
    let count = i32::from(rig.shafts.counts[0]);
    assert_eq!(rig.register(0, at::PRESENT_POSITION), count);
}

#[test]
fn homing_and_direction_change_the_position() {
    let mut rig = Rig::new(&[(1060, 1)]);
    rig.shafts.counts[0] = 1_000;
    rig.set(1, at::HOMING_OFFSET, &(-200_i32).to_le_bytes());
    rig.wait(30 * MS);
    assert_eq!(rig.register(0, at::PRESENT_POSITION), 800);
    // Too much for position control, not for several turns.
    rig.set(1, at::HOMING_OFFSET, &8_192_i32.to_le_bytes());
    rig.wait(5 * MS);
    assert_eq!(rig.register(0, at::PRESENT_POSITION), 1_000);
    rig.set(1, at::OPERATING_MODE, &[16]);
    rig.wait(5 * MS);
    assert_eq!(rig.register(0, at::PRESENT_POSITION), 9_192);
    rig.set(1, at::HOMING_OFFSET, &[0; 4]);
    rig.set(1, at::DRIVE_MODE, &[1]);
    rig.set(1, at::GOAL_PWM, &100_i16.to_le_bytes());
    rig.set(1, at::TORQUE_ENABLE, &[1]);
    rig.wait(5 * MS);
    assert_eq!(rig.register(0, at::PRESENT_POSITION), 3_095);
    assert_eq!(rig.register(0, at::PRESENT_PWM), 100);
    assert_eq!(rig.servo(0).pwm(), 887);
}

#[test]
fn current_is_stall_current_times_duty_less_back_emf() {
    // An XM430-W350: 2.3 A at standstill, 2.69 mA a count.
    let mut rig = rig(1020, 0, &[(at::GOAL_CURRENT, 400)]);
    // 1.076 A of 2.3 A.
    assert_eq!(pwm(&mut rig), 414);
    assert!((399..=401).contains(&rig.register(0, at::PRESENT_CURRENT)));
    // The same at half the no-load speed of 46 rpm: nearly a count and a half a ms.
    rig.shafts.speeds[0] = 1;
    let found = pwm(&mut rig);
    assert!((650..720).contains(&found), "{found}");
}

/// Two servos of a model on the arm that ships for them.
fn bench(number: u16, arm: &str) -> Bench {
    let model = model::find(number).unwrap();
    let config = PlantFile::arm(Some(arm), Some([0.2, -0.2])).unwrap();
    let config = PlantConfig {
        held: false,
        ..config
    };
    let servos = [1, 2].map(|id| XServo::new(model, id, CODE_1M).into());
    Bench::with_devices(Plant::new(config, 1), servos.into())
}

#[test]
fn an_arm_is_brought_to_its_goal_positions() {
    let rad_per_count = std::f64::consts::TAU / 4_096.0;
    let goals_rad = [-0.2, 0.3];
    // Proportional control leaves an error under the arm's weight and friction.
    for (number, arm, error_max_rad) in [(1060, "xl430", 0.04), (1200, "xl330", 0.12)] {
        let mut bench = bench(number, arm);
        let mut received = Vec::new();
        let mut now_us = START_NS / 1_000;
        for (id, goal_rad) in (1..).zip(goals_rad) {
            let count = 2_048 + (goal_rad / rad_per_count) as i32;
            for (address, data) in [
                (at::TORQUE_ENABLE, vec![1]),
                (at::GOAL_POSITION, count.to_le_bytes().to_vec()),
            ] {
                let data = &data;
                let write = Instruction::Write { address, data };
                bench.advance(now_us, None, &mut received);
                bench.send(now_us, &write.encode::<32>(id).unwrap());
                now_us += 3_000;
            }
        }
        now_us += 3_000_000;
        bench.advance(now_us, None, &mut received);
        let state = bench.state_at(now_us);
        for (joint, goal_rad) in goals_rad.into_iter().enumerate() {
            let error_rad = state.q[joint] - goal_rad;
            assert!(
                error_rad.abs() < error_max_rad,
                "{arm} {joint}: {error_rad}"
            );
            let servo = bench.servos()[joint].x_series().unwrap();
            let count = servo.register(at::PRESENT_POSITION).unwrap();
            let read_rad = f64::from(count - 2_048) * rad_per_count;
            assert!((read_rad - state.q[joint]).abs() < 0.005, "{read_rad}");
        }
    }
}
