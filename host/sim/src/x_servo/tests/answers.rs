//! Instructions to one servo, and their answers.

use armbridge_servo::protocol2::register as at;
use armbridge_servo::protocol2::{BROADCAST, Instruction, StatusError};

use super::{Rig, statuses};

fn bytes(hex: &str) -> Vec<u8> {
    let digits = hex.split_whitespace();
    digits
        .map(|byte| u8::from_str_radix(byte, 16).unwrap())
        .collect()
}

/// Two XM430-W210 as in the e-Manual's examples.
fn examples() -> Rig {
    let mut rig = Rig::new(&[(1030, 1), (1030, 2)]);
    for servo in 0..2 {
        rig.servo(servo).memory.set_byte(at::FIRMWARE_VERSION, 38);
    }
    rig.restart_at([166, 2_079, 0]);
    rig.servo(0).set_supply(119);
    rig.servo(1).set_temperature(36.0);
    rig.wait(30_000_000);
    rig
}

#[test]
fn packets_of_the_e_manual_are_answered_byte_for_byte() {
    const DONE: &str = "FF FF FD 00 01 04 00 55 00 A1 0C";

    for (request, answer) in [
        (
            "FF FF FD 00 01 03 00 01 19 4E",
            "FF FF FD 00 01 07 00 55 00 06 04 26 65 5D",
        ),
        (
            "FF FF FD 00 01 07 00 02 84 00 04 00 1D 15",
            "FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0",
        ),
        ("FF FF FD 00 01 09 00 03 74 00 00 02 00 00 CA 89", DONE),
        ("FF FF FD 00 01 09 00 04 68 00 C8 00 00 00 AE 8E", DONE),
        ("FF FF FD 00 01 04 00 06 01 A1 E6", DONE),
        ("FF FF FD 00 01 03 00 08 2F 4E", DONE),
        ("FF FF FD 00 01 08 00 10 01 44 58 4C 22 B1 DC", DONE),
        (
            "FF FF FD 00 FE 09 00 82 84 00 04 00 01 02 CE FA",
            "FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0 \
             FF FF FD 00 02 08 00 55 00 1F 08 00 00 BA BE",
        ),
        (
            "FF FF FD 00 FE 0D 00 92 01 90 00 02 00 02 92 00 01 00 1A 05",
            "FF FF FD 00 01 06 00 55 00 77 00 C3 69 \
             FF FF FD 00 02 05 00 55 00 24 8B A9",
        ),
        (
            "FF FF FD 00 FE 11 00 83 74 00 04 00 01 96 00 00 00 02 AA 00 00 00 82 87",
            "",
        ),
    ] {
        let mut rig = examples();
        assert_eq!(rig.exchange(&bytes(request)), bytes(answer), "{request}");
    }
    // And the registered write is carried out.
    let mut rig = examples();
    rig.exchange(&bytes("FF FF FD 00 01 09 00 04 68 00 C8 00 00 00 AE 8E"));
    assert_eq!(rig.register(0, at::REGISTERED_INSTRUCTION), 1);
    let action = bytes("FF FF FD 00 01 03 00 05 02 CE");
    assert_eq!(rig.exchange(&action), bytes(DONE));
    assert_eq!(rig.register(0, at::GOAL_VELOCITY), 200);
    assert_eq!(rig.register(0, at::REGISTERED_INSTRUCTION), 0);
    let again = statuses(&rig.exchange(&action));
    assert_eq!(again[0].error, Some(StatusError::Instruction));
}

#[test]
fn a_reply_begins_after_the_return_delay() {
    let mut rig = Rig::new(&[(1060, 1)]);
    for (units, delay_ns) in [(250, 500_000), (0, 0)] {
        rig.set(1, at::RETURN_DELAY, &[units]);
        rig.wait(1_000_000);
        let ping = Instruction::Ping.encode::<16>(1).unwrap();
        let end_ns = rig.now_ns + 10 * 10_000;
        rig.send(&ping);
        let first = rig.wait(2_000_000)[0];
        // Three quarters into its stop bit.
        let start_ns = first.end_ns - 9_750;
        let expected_ns = end_ns + super::super::PROCESSING_NS + delay_ns;
        assert!(start_ns.abs_diff(expected_ns) < 500, "{units}");
    }
}

#[test]
fn stuffing_is_removed_and_added() {
    let mut rig = Rig::new(&[(1060, 1)]);
    // Indirect data, which take any byte: FF FF FD in both directions.
    let marks = [0xFF, 0xFF, 0xFD, 0xFD];
    let data_at = 224;
    let request = Instruction::Write {
        address: data_at,
        data: &marks,
    };
    let sent = request.encode::<32>(1).unwrap();
    assert_eq!(sent.len(), 10 + 2 + marks.len() + 1);
    assert_eq!(statuses(&rig.exchange(&sent))[0].error, None);
    let read = Instruction::Read {
        address: data_at,
        count: 4,
    };
    let answer = rig.ask(1, read);
    assert_eq!(answer.len(), 11 + marks.len() + 1);
    assert_eq!(statuses(&answer)[0].parameters, marks);
}

#[test]
fn the_status_return_level_decides_what_is_answered() {
    let mut rig = Rig::new(&[(1060, 1)]);
    let read = Instruction::Read {
        address: at::LED,
        count: 1,
    };
    for (level, answers) in [(0, [1, 0, 0]), (1, [1, 1, 0]), (2, [1, 1, 1])] {
        let _ = rig.write(1, at::STATUS_RETURN_LEVEL, &[level]);
        let write = Instruction::Write {
            address: at::LED,
            data: &[level & 1],
        };
        let found = [Instruction::Ping, read, write].map(|instruction| {
            let answer = rig.ask(1, instruction);
            statuses(&answer).len()
        });
        assert_eq!(found, answers, "{level}");
        assert_eq!(rig.register(0, at::LED), i32::from(level & 1));
    }
    // To all: carried out, not answered.
    let write = Instruction::Write {
        address: at::LED,
        data: &[1],
    };
    assert!(rig.ask(BROADCAST, write).is_empty());
    assert_eq!(rig.register(0, at::LED), 1);
    assert!(rig.ask(BROADCAST, read).is_empty());
}

#[test]
fn wrong_packets_are_answered_with_their_errors() {
    let mut rig = Rig::new(&[(1060, 1)]);
    let mut damaged = Instruction::Ping.encode::<16>(1).unwrap();
    damaged[9] ^= 1;
    assert_eq!(
        statuses(&rig.exchange(&damaged))[0].error,
        Some(StatusError::Crc)
    );
    damaged[4] = 2;
    assert!(rig.exchange(&damaged).is_empty());
    let unknown = bytes("FF FF FD 00 01 03 00 77");
    let crc = armbridge_servo::protocol2::crc::checksum(&unknown).to_le_bytes();
    let answer = rig.exchange(&[&unknown[..], &crc].concat());
    assert_eq!(statuses(&answer)[0].error, Some(StatusError::Instruction));
    let error = |rig: &mut Rig, address, data: &[u8]| rig.write(1, address, data).unwrap_err();
    let access = Some(StatusError::Access);
    assert_eq!(error(&mut rig, at::PRESENT_PWM, &[0, 0]), access);
    rig.set(1, at::TORQUE_ENABLE, &[1]);
    assert_eq!(error(&mut rig, at::ID, &[2]), access);
    assert_eq!(rig.servo(0).id(), 1);
    let length = Some(StatusError::DataLength);
    assert_eq!(error(&mut rig, at::GOAL_POSITION, &[0, 0]), length);
}

#[test]
fn ids_and_rates_hold_from_after_the_status_packet() {
    let mut rig = Rig::new(&[(1060, 1), (1200, 2)]);
    let answer = rig.ask(
        1,
        Instruction::Write {
            address: at::ID,
            data: &[9],
        },
    );
    assert_eq!(statuses(&answer)[0].id, 1);
    assert_eq!(rig.status(9, Instruction::Ping).id, 9);
    for (code, baud) in [
        (0, 9_600),
        (1, 57_600),
        (2, 115_200),
        (4, 2_000_000),
        (5, 3_000_000),
        (6, 4_000_000),
        (7, 4_500_000),
    ] {
        rig.set(9, at::BAUD_RATE, &[code]);
        assert!(rig.ask(9, Instruction::Ping).is_empty());
        rig.baud = baud;
        rig.wait(200_000_000);
        let ping = Instruction::Ping.encode::<16>(9).unwrap();
        let answer = rig.exchange_for(&ping, 40_000_000);
        assert_eq!(statuses(&answer).len(), 1, "{baud}");
        let write = Instruction::Write {
            address: at::BAUD_RATE,
            data: &[3],
        };
        let write = write.encode::<16>(9).unwrap();
        rig.exchange_for(&write, 60_000_000);
        rig.baud = 1_000_000;
    }
    // The XL330 has no 4.5 Mbaud.
    let refused = rig.write(2, at::BAUD_RATE, &[7]);
    assert_eq!(refused, Err(Some(StatusError::DataRange)));
}

#[test]
fn a_group_obeys_its_secondary_id_in_silence() {
    let mut rig = Rig::new(&[(1060, 1), (1060, 2)]);
    for id in [1, 2] {
        rig.set(id, at::SHADOW_ID, &[5]);
    }
    assert_eq!(rig.write(5, at::LED, &[1]), Err(None));
    assert_eq!([0, 1].map(|servo| rig.register(servo, at::LED)), [1, 1]);
    assert_eq!(rig.write(5, at::RETURN_DELAY, &[0]), Err(None));
    assert_eq!(rig.register(0, at::RETURN_DELAY), 250);
    // Its own id comes first.
    rig.set(2, at::SHADOW_ID, &[1]);
    rig.set(1, at::LED, &[0]);
    assert_eq!([0, 1].map(|servo| rig.register(servo, at::LED)), [0, 0]);
}

#[test]
fn resets_keep_what_their_option_says() {
    for (option, id, code) in [(0xFF, 1, 1), (1, 7, 1), (2, 7, 3)] {
        let mut rig = Rig::new(&[(1060, 7)]);
        rig.set(7, at::PWM_LIMIT, &[100, 0]);
        assert!(
            rig.status(7, Instruction::FactoryReset(option))
                .error
                .is_none()
        );
        rig.wait(super::START_NS);
        let found = [at::ID, at::BAUD_RATE, at::PWM_LIMIT].map(|at| rig.register(0, at));
        assert_eq!(found, [id, code, 885], "{option}");
    }
    let mut rig = Rig::new(&[(1060, 7)]);
    assert!(
        rig.ask(BROADCAST, Instruction::FactoryReset(0xFF))
            .is_empty()
    );
    assert_eq!(rig.servo(0).id(), 7);
}
