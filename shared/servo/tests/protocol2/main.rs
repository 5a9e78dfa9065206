//! Packets of Protocol 2.0 against those of four independent masters: the vendor's SDK and pypot, see
//! `vectors.txt`, and `tests/python/protocol2_vectors.py`, which made it; rustypot and dynamixel2, see
//! `masters.txt`, and `tests/masters`, which made it.

use armbridge_servo::protocol2::{BROADCAST, Frame, Instruction, Parser, Status};

const BYTES_MAX: usize = 128;

fn bytes(hex: &[&str]) -> Vec<u8> {
    let bytes = hex.iter().map(|byte| u8::from_str_radix(byte, 16));
    bytes.collect::<Result<_, _>>().expect("hexadecimal bytes")
}

fn number<T: std::str::FromStr>(text: &str) -> T {
    text.parse()
        .unwrap_or_else(|_| panic!("{text} is no number"))
}

/// Parses the packet, passes its frame on, and requires that it ends with its last byte.
fn with_frame(packet: &[u8], check: impl FnOnce(&Frame<'_>)) {
    let mut parser = Parser::<BYTES_MAX>::new();
    let (last, before) = packet.split_last().expect("a packet");
    for byte in before {
        assert_eq!(parser.push(*byte), None);
    }
    let frame = parser.push(*last).expect("its end").expect("its CRC");
    check(&frame);
}

fn check_instruction(instruction: Instruction<'_>, id: u8, packet: &[u8]) {
    let encoded = instruction.encode::<BYTES_MAX>(id).expect("room");
    assert_eq!(encoded, *packet, "{instruction:?}");
    with_frame(packet, |frame| {
        assert_eq!(frame.id, id);
        assert_eq!(Instruction::decode(frame), Ok(instruction));
    });
}

/// An instruction to several servos, by its words.
fn check_group(name: &str, address: &str, count: &str, bytes: &[u8], packet: &[u8]) {
    let (address, count) = (number(address), number(count));
    let instruction = match name {
        "sync_read" => Instruction::SyncRead {
            address,
            count,
            ids: bytes,
        },
        "fast_sync_read" => Instruction::FastSyncRead {
            address,
            count,
            ids: bytes,
        },
        _ => Instruction::SyncWrite {
            address,
            count,
            blocks: bytes,
        },
    };
    check_instruction(instruction, BROADCAST, packet);
}

fn check_status(id: u8, error: u8, data: &[u8], packet: &[u8]) {
    with_frame(packet, |frame| {
        let status = Status::decode(frame).expect("a status packet");
        assert_eq!((status.id, status.parameters), (id, data));
        assert_eq!(status.is_alert, error & 0x80 != 0);
        assert_eq!(status.error.is_some(), error & 0x7F != 0);
        assert_eq!(status.encode::<BYTES_MAX>().expect("room"), *packet);
    });
}

/// Checks a line: words and a packet.
fn check(line: &str) {
    let (words, packet) = line.split_once('|').expect("words and a packet");
    let words: Vec<&str> = words.split_whitespace().collect();
    let packet = bytes(&packet.split_whitespace().collect::<Vec<_>>());
    let data;
    let (instruction, id) = match words[..] {
        ["ping", id] => (Instruction::Ping, id),
        ["reboot", id] => (Instruction::Reboot, id),
        ["action", id] => (Instruction::Action, id),
        ["clear_turns", id] => (Instruction::ClearTurns, id),
        ["factory_reset", id, what] => (Instruction::FactoryReset(number(what)), id),
        ["read", id, address, count] => {
            let (address, count) = (number(address), number(count));
            (Instruction::Read { address, count }, id)
        }
        [name @ ("write" | "reg_write"), id, address, ref rest @ ..] => {
            data = bytes(rest);
            let (address, data) = (number(address), &data[..]);
            let instruction = match name {
                "write" => Instruction::Write { address, data },
                _ => Instruction::RegWrite { address, data },
            };
            (instruction, id)
        }
        [name @ ("bulk_read" | "bulk_write"), ref rest @ ..] => {
            data = bytes(rest);
            let instruction = match name {
                "bulk_read" => Instruction::BulkRead(&data),
                _ => Instruction::BulkWrite(&data),
            };
            return check_instruction(instruction, BROADCAST, &packet);
        }
        [
            name @ ("sync_read" | "fast_sync_read" | "sync_write"),
            address,
            count,
            ref rest @ ..,
        ] => return check_group(name, address, count, &bytes(rest), &packet),
        ["status", id, error, ref rest @ ..] => {
            return check_status(number(id), number(error), &bytes(rest), &packet);
        }
        _ => panic!("unknown: {line}"),
    };
    check_instruction(instruction, number(id), &packet);
}

/// Checks the lines that are no comments, and returns how many they are.
fn check_all(text: &str) -> usize {
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    lines.map(check).count()
}

#[test]
fn packets_are_those_of_the_sdk() {
    assert_eq!(check_all(include_str!("vectors.txt")), 42, "vectors");
}

#[test]
fn packets_are_those_of_rustypot_and_dynamixel2() {
    assert_eq!(check_all(include_str!("masters.txt")), 55, "vectors");
}
