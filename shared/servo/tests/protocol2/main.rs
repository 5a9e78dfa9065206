//! Packets of Protocol 2.0 against those of two independent masters, the vendor's SDK and pypot:
//! see `vectors.txt`, and `tests/python/protocol2_vectors.py`, which made it.

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

#[test]
fn packets_are_those_of_the_sdk() {
    let lines = include_str!("vectors.txt").lines();
    let mut count = 0;
    for line in lines.filter(|line| !line.starts_with('#')) {
        let (words, packet) = line.split_once('|').expect("words and a packet");
        let words: Vec<&str> = words.split_whitespace().collect();
        let packet = bytes(&packet.split_whitespace().collect::<Vec<_>>());
        match words[..] {
            ["ping", id] => check_instruction(Instruction::Ping, number(id), &packet),
            ["reboot", id] => check_instruction(Instruction::Reboot, number(id), &packet),
            ["read", id, address, count] => {
                let (address, count) = (number(address), number(count));
                check_instruction(Instruction::Read { address, count }, number(id), &packet);
            }
            ["write", id, address, ref data @ ..] => {
                let (address, data) = (number(address), &bytes(data));
                check_instruction(Instruction::Write { address, data }, number(id), &packet);
            }
            [
                name @ ("sync_read" | "fast_sync_read"),
                address,
                count,
                ref ids @ ..,
            ] => {
                let (address, count, ids) = (number(address), number(count), &bytes(ids));
                let instruction = match name {
                    "sync_read" => Instruction::SyncRead {
                        address,
                        count,
                        ids,
                    },
                    _ => Instruction::FastSyncRead {
                        address,
                        count,
                        ids,
                    },
                };
                check_instruction(instruction, BROADCAST, &packet);
            }
            ["sync_write", address, count, ref blocks @ ..] => {
                let (address, count, blocks) = (number(address), number(count), &bytes(blocks));
                let instruction = Instruction::SyncWrite {
                    address,
                    count,
                    blocks,
                };
                check_instruction(instruction, BROADCAST, &packet);
            }
            ["bulk_read", ref items @ ..] => {
                check_instruction(Instruction::BulkRead(&bytes(items)), BROADCAST, &packet);
            }
            ["status", id, error, ref data @ ..] => {
                let (error, data): (u8, _) = (number(error), bytes(data));
                with_frame(&packet, |frame| {
                    let status = Status::decode(frame).expect("a status packet");
                    assert_eq!((status.id, status.parameters), (number(id), &data[..]));
                    assert_eq!(status.is_alert, error & 0x80 != 0);
                    assert_eq!(status.error.is_some(), error & 0x7F != 0);
                    assert_eq!(status.encode::<BYTES_MAX>().expect("room"), *packet);
                });
            }
            _ => panic!("unknown: {line}"),
        }
        count += 1;
    }
    assert_eq!(count, 42, "vectors");
}
