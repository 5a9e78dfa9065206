//! Reply times and rates, and times without replies.

use armbridge_servo::Firmware;
use armbridge_servo::protocol1::Instruction;

use super::{NOTHING, Rig};
use crate::Bench;
use crate::half_duplex_bus::{Mechanics, MotorDrive, ReceivedByte, Record, Wire};
use crate::morpheus_servo::Reading;
use crate::plant::{Plant, PlantConfig};
use crate::servo_kind::ServoKind;
use crate::stock_servo::{Ax12a, INTERRUPT_NS, at};

const BIT_NS: u64 = 1_000;
const BYTE_NS: u64 = 10 * BIT_NS;

/// From the end of an instruction to the answer, and the longest pause in it,
/// in ns: those of many exchanges, at all phases of the control step.
fn latencies(return_delay: u8, instruction: Instruction) -> Vec<(u64, u64)> {
    let mut rig = Rig::new();
    rig.set(1, at::RETURN_DELAY, &[return_delay]);
    rig.wait(20_000);
    let bytes = instruction.encode::<32>(1).unwrap();
    let one = |_| {
        rig.wait(3_137);
        let end_ns = rig.now_us * 1_000 + bytes.len() as u64 * BYTE_NS;
        rig.send(&bytes);
        let received = rig.wait(3_000);
        // Where a receiver has a byte: 9.75 bits and two cycles of 62.5 ns.
        let starts: Vec<u64> = received
            .iter()
            .map(|byte| byte.end_ns - 9_750 - 94)
            .collect();
        let pauses = starts.windows(2).map(|pair| pair[1] - pair[0] - BYTE_NS);
        (starts[0] - end_ns, pauses.max().unwrap())
    };
    (0..400).map(one).collect()
}

#[test]
fn answers_come_when_they_were_measured_to() {
    let read = Instruction::Read {
        address: 36,
        count: 8,
    };
    let write = Instruction::Write {
        address: at::GOAL_POSITION.into(),
        data: &[0, 2, 0, 1],
    };
    for (instruction, delay, after_ns) in [
        (Instruction::Ping, 0, 18_000),
        (read, 0, 22_000),
        (write, 0, 48_000),
        (Instruction::Ping, 250, 518_000),
    ] {
        let measured = latencies(delay, instruction);
        let soonest = measured.iter().map(|(latency, _)| *latency).min().unwrap();
        let latest = measured.iter().map(|(latency, _)| *latency).max().unwrap();
        let pause = measured.iter().map(|(_, pause)| *pause).max().unwrap();
        // The servo's own receiver takes two cycles.
        assert_eq!(soonest, after_ns + 94, "{instruction:?}");
        // The control step may come first, or between two bytes.
        let worst = after_ns + INTERRUPT_NS;
        assert!((worst - 10_000..=worst).contains(&latest), "{latest}");
        assert!(
            (INTERRUPT_NS - 20_000..=INTERRUPT_NS).contains(&pause),
            "{pause}"
        );
        let undisturbed = measured.iter().filter(|(_, pause)| *pause == 0).count();
        assert!(undisturbed > 200, "{undisturbed}");
    }
}

#[test]
fn a_new_id_and_rate_hold_after_the_answer() {
    let mut rig = Rig::with(&[(Firmware::Stock, 1)]);
    let ping = |id| Instruction::Ping.encode::<6>(id).unwrap();
    rig.set(1, at::ID, &[7]);
    rig.wait(20_000);
    assert_eq!(rig.exchange(&ping(1)), NOTHING);
    rig.set(7, at::BAUD_RATE, &[34]);
    rig.wait(20_000);
    assert_eq!(rig.exchange(&ping(7)), NOTHING);
    rig.bench.set_baud(57_600);
    rig.send(&ping(7));
    assert_eq!(rig.wait(10_000).len(), 6);
    // And after power-off.
    rig.bench.power_cycle(0);
    rig.wait(10_000);
    rig.send(&ping(7));
    assert_eq!(rig.wait(10_000).len(), 6);
    assert_eq!(rig.bench.framing_errors(), 0);
}

#[test]
fn an_eeprom_byte_deafens_for_6_ms() {
    let mut rig = Rig::new();
    let ping = Instruction::Ping.encode::<6>(1).unwrap();
    // Two of them, from the end of the answer on.
    rig.set_word(1, at::MAX_TORQUE, 1000);
    let reply_level = rig.now_us;
    while rig.exchange(&ping).is_empty() {}
    let deaf_us = rig.now_us - reply_level;
    assert!((10_000..=14_000).contains(&deaf_us), "{deaf_us} us");
    // The RAM takes no time.
    rig.set_word(1, at::MOVING_SPEED, 1000);
    assert!(!rig.exchange(&ping).is_empty());
}

#[test]
fn every_rate_is_spoken() {
    for baud in [
        9_600, 19_200, 57_600, 115_200, 200_000, 250_000, 400_000, 500_000, 1_000_000,
    ] {
        let kind = ServoKind::new(Firmware::Stock, 1, baud).unwrap();
        let mut rig = Rig {
            bench: Bench::with_servos(Plant::new(PlantConfig::default(), 1), &[kind]),
            now_us: 0,
        };
        rig.bench.set_baud(baud);
        rig.wait(5_000);
        let read = Instruction::Read {
            address: 0,
            count: 3,
        }
        .encode::<8>(1)
        .unwrap();
        rig.send(&read);
        let received: Vec<u8> = rig.wait(40_000).iter().map(|byte| byte.byte).collect();
        assert_eq!(received, [0xFF, 0xFF, 1, 5, 0, 12, 0, 24, 0xD5], "{baud}");
        assert_eq!(rig.bench.framing_errors(), 0, "{baud}");
    }
}

#[test]
fn another_rate_is_not_understood_and_shows() {
    let mut rig = Rig::new();
    let ping = Instruction::Ping.encode::<6>(1).unwrap();
    rig.bench.set_baud(57_600);
    rig.send(&ping);
    assert!(rig.wait(10_000).is_empty());
    // A reply that is received at another rate than that of its request.
    rig.bench.set_baud(1_000_000);
    rig.send(&ping);
    rig.wait(100);
    rig.bench.set_baud(2_000_000);
    let received = rig.wait(2_000);
    assert!(received.iter().any(|byte| byte.framing_error));
    let errors = received.iter().filter(|byte| byte.framing_error).count();
    assert_eq!(rig.bench.framing_errors(), errors as u64);
}

#[test]
fn two_of_one_id_answer_at_once_but_not_for_ever() {
    let mut rig = Rig::with(&[(Firmware::Stock, 1), (Firmware::Stock, 1)]);
    let ping = Instruction::Ping.encode::<6>(1).unwrap();
    rig.send(&ping);
    assert!(!rig.wait(5_000).is_empty());
    assert!(rig.wait(100_000).is_empty());
}

#[derive(Debug, Default, PartialEq)]
struct Moving {
    drives: Vec<(usize, u64, u16)>,
}

impl Mechanics for Moving {
    fn convert(&mut self, _servo: usize, at_ns: u64) -> Reading {
        Reading {
            position: 300 + (at_ns / 100_000 % 400) as u16,
            temperature: 0,
        }
    }

    fn drive(&mut self, servo: usize, at_ns: u64, drive: MotorDrive) {
        let pwm = drive.pwm;
        self.drives.push((servo, at_ns, pwm));
    }
}

fn run(step_ns: u64) -> (Moving, Vec<ReceivedByte>, Vec<Record>) {
    const END_NS: u64 = 40_000_000;
    let mut wire = Wire::new(vec![Ax12a::new(1, 1), Ax12a::new(2, 1)]);
    wire.record();
    let mut moving = Moving::default();
    let goal = Instruction::Write {
        address: at::GOAL_POSITION.into(),
        data: &[0, 2],
    };
    let read = Instruction::Read {
        address: 0,
        count: 50,
    };
    for (ms, id, instruction) in [
        (3, 1, goal),
        (6, 2, goal),
        (9, 1, read),
        (20, 0xFE, Instruction::Ping),
    ] {
        let bytes = instruction.encode::<32>(id).unwrap();
        for (i, byte) in bytes.iter().enumerate() {
            wire.send(ms * 1_000_000 + i as u64 * BYTE_NS, *byte, 1_000_000);
        }
    }
    while wire.now_ns() < END_NS {
        wire.advance((wire.now_ns() + step_ns).min(END_NS), &mut moving);
    }
    let received = std::iter::from_fn(|| wire.take_received()).collect();
    (moving, received, wire.take_records())
}

#[test]
fn steps_do_not_matter() {
    let complete = run(u64::MAX / 2);
    assert!(complete.0.drives.len() > 10, "position control acts");
    assert!(complete.1.len() > 60, "answers are received");
    for step_ns in [333, 10_000, 1_234_567] {
        assert_eq!(run(step_ns), complete, "steps of {step_ns} ns");
    }
}
