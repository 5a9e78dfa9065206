//! Replies, and written values.

use armbridge_client::servo_table::{AX12A, Access};
use armbridge_servo::protocol1::Instruction;
use armbridge_servo::{Alarms, Firmware};

use super::{NOTHING, Rig};
use crate::stock_servo::at;

const PING_1: [u8; 6] = [0xFF, 0xFF, 1, 2, 1, 0xFB];
const PONG_1: [u8; 6] = [0xFF, 0xFF, 1, 2, 0, 0xFC];

/// Exchanges printed in the AX-12 manual and the e-Manual, in an order in which
/// one servo can have them all.
#[test]
fn documented_exchanges() {
    let mut rig = Rig::with(&[(Firmware::Stock, 1)]);
    rig.bench
        .servo_mut(0)
        .stock_mut()
        .unwrap()
        .set_temperature(32.0);
    rig.wait(2_000);
    let fine = [0xFF, 0xFF, 0, 2, 0, 0xFD];
    let exchanges: [(&[u8], &[u8]); 16] = [
        (&PING_1, &PONG_1),
        // The temperature: 32 degrees.
        (
            &[0xFF, 0xFF, 1, 4, 2, 0x2B, 1, 0xCC],
            &[0xFF, 0xFF, 1, 3, 0, 0x20, 0xDB],
        ),
        // Id 1 becomes 0, and answers as 1.
        (&[0xFF, 0xFF, 1, 4, 3, 3, 0, 0xF4], &PONG_1),
        // 1 Mbaud; return delay 4 us; counter-clockwise limit 150 degrees.
        (&[0xFF, 0xFF, 0, 4, 3, 4, 1, 0xF3], &fine),
        (&[0xFF, 0xFF, 0, 4, 3, 5, 2, 0xF1], &fine),
        (&[0xFF, 0xFF, 0, 5, 3, 8, 0xFF, 1, 0xEF], &fine),
        // 80 degrees at most; half the torque; alarm and shutdown when hot.
        (&[0xFF, 0xFF, 0, 4, 3, 0x0B, 0x50, 0x9D], &fine),
        (&[0xFF, 0xFF, 0, 5, 3, 0x0E, 0xFF, 1, 0xE9], &fine),
        (&[0xFF, 0xFF, 0, 5, 3, 0x11, 4, 4, 0xDE], &fine),
        // Torque and LED on; compliance; a goal, at once and registered.
        (&[0xFF, 0xFF, 0, 5, 3, 0x18, 1, 1, 0xDD], &fine),
        (&[0xFF, 0xFF, 0, 7, 3, 0x1A, 1, 1, 0x40, 0x40, 0x59], &fine),
        (&[0xFF, 0xFF, 0, 5, 4, 0x1E, 0, 0, 0xD8], &fine),
        (&[0xFF, 0xFF, 0xFE, 2, 5, 0xFA], &[]),
        // Locked: a range error for the punch.
        (&[0xFF, 0xFF, 0, 4, 3, 0x2F, 1, 0xC8], &fine),
        (
            &[0xFF, 0xFF, 0, 5, 3, 0x30, 0x40, 0, 0x87],
            &[0xFF, 0xFF, 0, 2, 8, 0xF5],
        ),
        // As ex works; the answer is still that of 0.
        (&[0xFF, 0xFF, 0, 2, 6, 0xF7], &fine),
    ];
    for (instruction, answer) in exchanges {
        assert_eq!(rig.exchange(instruction), answer, "{instruction:02x?}");
        // An EEPROM byte takes its time.
        rig.wait(150_000);
    }
    assert_eq!(rig.exchange(&PING_1), PONG_1);
    assert_eq!(rig.register(0, "ccw_angle_limit"), 1023);
}

#[test]
fn every_register_is_read_and_gaps_are_nothing() {
    let mut rig = Rig::new();
    let complete = rig.ask(
        1,
        Instruction::Read {
            address: 0,
            count: 50,
        },
    );
    let table = &complete[5..55];
    for register in AX12A.registers {
        let value = register.value_in(table, 0).unwrap();
        assert!(register.range.contains(&value), "{}", register.name);
        if register.access == Access::ReadWrite {
            assert_eq!(value, rig.register(0, register.name), "{}", register.name);
        }
        if let Some(initial) = register.initial {
            assert_eq!(value, initial, "{}", register.name);
        }
    }
    assert_eq!(table[19..24], [0; 5]);
    assert_eq!(rig.register(0, "torque_limit"), 1023);
    // Where it is, upright, but for the noise.
    assert!(rig.register(0, "goal_position").abs_diff(512) <= 4);
    assert_eq!(rig.register(0, "present_voltage"), 111);
}

#[test]
fn each_error_has_its_alarm_and_writes_nothing() {
    let mut rig = Rig::new();
    rig.set(1, at::CW_ANGLE_LIMIT, &[100, 0]);
    rig.wait(20_000);
    let cases: [(&[u8], Alarms); 9] = [
        // A wrong checksum.
        (&[1, 4, 3, at::CW_SLOPE, 9, 0], Alarms::CHECKSUM),
        // No such instruction; one of the MX series; parameters missing.
        (&[1, 2, 0x42], Alarms::INSTRUCTION),
        (&[1, 6, 0x92, 0, 2, 1, 36], Alarms::INSTRUCTION),
        (&[1, 3, 2, 36], Alarms::INSTRUCTION),
        // ACTION without anything registered.
        (&[1, 2, 5], Alarms::INSTRUCTION),
        // Punch below its range, a register that is only read, no register.
        (&[1, 5, 3, at::PUNCH, 31, 0], Alarms::RANGE),
        (&[1, 4, 3, at::PRESENT_VOLTAGE, 9], Alarms::RANGE),
        (&[1, 4, 2, 49, 2], Alarms::RANGE),
        // A goal clockwise of the limit, with a speed that is fine.
        (
            &[1, 7, 3, at::GOAL_POSITION, 99, 0, 1, 1],
            Alarms::ANGLE_LIMIT,
        ),
    ];
    let registers = |rig: &Rig| {
        let writable = AX12A
            .registers
            .iter()
            .filter(|r| r.access == Access::ReadWrite);
        writable
            .map(|r| rig.register(0, r.name))
            .collect::<Vec<_>>()
    };
    let before = registers(&rig);
    for (body, alarms) in cases {
        let is_damaged = alarms == Alarms::CHECKSUM;
        let sum = body.iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte));
        let sum = if is_damaged { sum } else { !sum };
        let packet = [&[0xFF, 0xFF], body, &[sum]].concat();
        let error = alarms.bits();
        let answer = [0xFF, 0xFF, 1, 2, error, !(3 + error)];
        assert_eq!(rig.exchange(&packet), answer, "{body:02x?}");
    }
    assert_eq!(registers(&rig), before);
    // None of them lasts, and none is in the shutdown mask of a servo ex works.
    assert_eq!(rig.alarms(1), Alarms::NONE);
}

#[test]
fn to_all_only_pings_are_answered() {
    let mut rig = Rig::with(&[(Firmware::Stock, 1)]);
    let speed = |low| Instruction::Write {
        address: at::MOVING_SPEED.into(),
        data: low,
    };
    assert_eq!(rig.broadcast(speed(&[7, 0])), NOTHING);
    assert_eq!(rig.register(0, "moving_speed"), 7);
    assert_eq!(
        rig.broadcast(Instruction::Read {
            address: 36,
            count: 2
        }),
        NOTHING
    );
    let bulk_read = [0xFF, 0xFF, 0xFE, 6, 0x92, 0, 2, 1, 36, 0x41];
    assert_eq!(rig.exchange(&bulk_read), NOTHING);
    let registered = Instruction::RegWrite {
        address: at::MOVING_SPEED.into(),
        data: &[9, 0],
    };
    assert_eq!(rig.broadcast(registered), NOTHING);
    assert_eq!(rig.register(0, "registered"), 1);
    assert_eq!(rig.broadcast(Instruction::Action), NOTHING);
    assert_eq!(rig.register(0, "moving_speed"), 9);
    assert_eq!(rig.register(0, "registered"), 0);
    assert_eq!(rig.broadcast(Instruction::Ping), PONG_1);
}

#[test]
fn return_level_selects_the_instructions_with_a_reply() {
    for (level, reply_level) in [
        (0, [true, false, false]),
        (1, [true, true, false]),
        (2, [true; 3]),
    ] {
        let mut rig = Rig::new();
        // Answered by the level that was.
        rig.set(1, at::STATUS_RETURN_LEVEL, &[level]);
        rig.wait(20_000);
        let instructions = [
            Instruction::Ping,
            Instruction::Read {
                address: 36,
                count: 2,
            },
            Instruction::Write {
                address: at::GOAL_POSITION.into(),
                data: &[0, 2],
            },
        ];
        let is_replied = instructions.map(|instruction| !rig.ask(1, instruction).is_empty());
        assert_eq!(is_replied, reply_level, "level {level}");
        assert_eq!(rig.register(0, "goal_position"), 512, "obeyed all the same");
        assert_eq!(
            rig.exchange(&[0xFF, 0xFF, 1, 2, 9, 0]).is_empty(),
            level < 2
        );
    }
}

#[test]
fn each_takes_its_own_of_a_sync_write() {
    let mut rig = Rig::with(&[
        (Firmware::Stock, 1),
        (Firmware::Stock, 2),
        (Firmware::Stock, 3),
    ]);
    // Half of full duty either way, from the documents.
    let bytes = [
        0xFF, 0xFF, 0xFE, 0x0A, 0x83, 0x20, 2, 1, 0, 2, 2, 0, 6, 0x47,
    ];
    assert_eq!(rig.exchange(&bytes), NOTHING);
    let speeds = [0, 1, 2].map(|servo| rig.register(servo, "moving_speed"));
    assert_eq!(speeds, [512, 1024 + 512, 0]);
}

#[test]
fn power_off_forgets_all_but_the_eeprom() {
    let mut rig = Rig::new();
    rig.set(1, at::CCW_ANGLE_LIMIT, &[0xFF, 2]);
    rig.wait(20_000);
    rig.set(1, at::TORQUE_ENABLE, &[1]);
    rig.ask(
        1,
        Instruction::RegWrite {
            address: at::MOVING_SPEED.into(),
            data: &[9, 0],
        },
    );
    rig.set(1, at::LOCK, &[1]);
    assert_eq!(rig.write(1, at::LOCK, &[0]), Some(Alarms::RANGE));
    rig.bench.power_cycle(0);
    rig.wait(5_000);
    let names = ["ccw_angle_limit", "torque_enable", "registered", "lock"];
    let values = names.map(|name| rig.register(0, name));
    assert_eq!(values, [0x2FF, 0, 0, 0]);
    let action = rig.ask(1, Instruction::Action);
    assert_eq!(Alarms::from_bits(action[4]), Alarms::INSTRUCTION);
}

#[test]
fn beside_morpheus_each_speaks_its_own() {
    let mut rig = Rig::with(&[(Firmware::Morpheus, 1), (Firmware::Stock, 1)]);
    assert_eq!(rig.exchange(&PING_1), PONG_1);
    let morpheus = [0xAA, 3, 1, 0xFE, 1, 0xF9];
    assert_eq!(rig.exchange(&morpheus), [0xAA, 3, 0xFE, 1, 1, 0xF9]);
    assert_eq!(rig.exchange(&PING_1), PONG_1);
}
