//! Packets of the e-Manual, and round trips.

extern crate std;

use super::super::{BROADCAST, Parser, register};
use super::*;
use proptest::prelude::*;
use std::vec::Vec as Bytes;

fn bytes(hex: &str) -> Bytes<u8> {
    let digits = hex.split_whitespace();
    digits
        .map(|byte| u8::from_str_radix(byte, 16).unwrap())
        .collect()
}

/// Voltage of servo 1 and temperature of servo 2.
const ITEMS: [u8; 10] = [1, 144, 0, 2, 0, 2, 146, 0, 1, 0];

/// The examples of the e-Manual's chapters, of two XM430.
const EXAMPLES: [(Instruction<'static>, u8, &str); 12] = [
    (Instruction::Ping, 1, "FF FF FD 00 01 03 00 01 19 4E"),
    (
        Instruction::Ping,
        BROADCAST,
        "FF FF FD 00 FE 03 00 01 31 42",
    ),
    (
        Instruction::Read {
            address: register::PRESENT_POSITION,
            count: 4,
        },
        1,
        "FF FF FD 00 01 07 00 02 84 00 04 00 1D 15",
    ),
    (
        Instruction::Write {
            address: register::GOAL_POSITION,
            data: &[0x00, 0x02, 0x00, 0x00],
        },
        1,
        "FF FF FD 00 01 09 00 03 74 00 00 02 00 00 CA 89",
    ),
    (
        Instruction::RegWrite {
            address: register::GOAL_VELOCITY,
            data: &[0xC8, 0x00, 0x00, 0x00],
        },
        1,
        "FF FF FD 00 01 09 00 04 68 00 C8 00 00 00 AE 8E",
    ),
    (Instruction::Action, 1, "FF FF FD 00 01 03 00 05 02 CE"),
    (
        Instruction::FactoryReset(1),
        1,
        "FF FF FD 00 01 04 00 06 01 A1 E6",
    ),
    (Instruction::Reboot, 1, "FF FF FD 00 01 03 00 08 2F 4E"),
    (
        Instruction::ClearTurns,
        1,
        "FF FF FD 00 01 08 00 10 01 44 58 4C 22 B1 DC",
    ),
    (
        Instruction::SyncRead {
            address: register::PRESENT_POSITION,
            count: 4,
            ids: &[1, 2],
        },
        BROADCAST,
        "FF FF FD 00 FE 09 00 82 84 00 04 00 01 02 CE FA",
    ),
    (
        Instruction::SyncWrite {
            address: register::GOAL_POSITION,
            count: 4,
            blocks: &[1, 0x96, 0, 0, 0, 2, 0xAA, 0, 0, 0],
        },
        BROADCAST,
        "FF FF FD 00 FE 11 00 83 74 00 04 00 01 96 00 00 00 02 AA 00 00 00 82 87",
    ),
    (
        Instruction::BulkRead(&ITEMS),
        BROADCAST,
        "FF FF FD 00 FE 0D 00 92 01 90 00 02 00 02 92 00 01 00 1A 05",
    ),
];

#[test]
fn packets_are_those_of_the_e_manual() {
    for (instruction, id, hex) in EXAMPLES {
        let packet = instruction.encode::<64>(id).unwrap();
        assert_eq!(packet, *bytes(hex), "{instruction:?}");
        let mut parser = Parser::<64>::new();
        let (last, before) = packet.split_last().unwrap();
        for byte in before {
            assert_eq!(parser.push(*byte), None);
        }
        let frame = parser.push(*last).unwrap().unwrap();
        assert_eq!(frame.id, id);
        assert_eq!(Instruction::decode(&frame), Ok(instruction));
    }
    let decoded: Bytes<_> = BulkItem::decode_all(&ITEMS).collect();
    assert_eq!(decoded.len(), 2);
    assert_eq!(decoded[0].encode(), ITEMS[..5]);
    assert_eq!(
        decoded[1],
        BulkItem {
            id: 2,
            address: 146,
            count: 1
        }
    );
}

proptest! {
    #[test]
    fn every_frame_is_decoded_or_refused(code in any::<u8>(), parameters in proptest::collection::vec(any::<u8>(), 0..30)) {
        let frame = Frame { id: 1, code, parameters: &parameters };
        if let Ok(instruction) = Instruction::decode(&frame) {
            let id = if code >= 0x80 { BROADCAST } else { 1 };
            let again = Frame { id, ..frame }.encode::<80>();
            prop_assert_eq!(instruction.encode::<80>(1), again);
        }
    }
}

#[test]
fn what_does_not_fit_is_refused() {
    let decode = |code, parameters: &'static [u8]| {
        Instruction::decode(&Frame {
            id: 1,
            code,
            parameters,
        })
    };
    assert_eq!(decode(0x77, &[]), Err(InstructionError::Unknown(0x77)));
    for (code, parameters) in [
        (code::PING, &[1][..]),
        (code::READ, &[1, 2, 3]),
        (code::WRITE, &[1, 2]),
        (code::CLEAR, &[1, 2]),
        (code::SYNC_WRITE, &[1, 0, 2, 0, 9]),
        (code::BULK_READ, &[1, 2, 3, 4]),
    ] {
        assert_eq!(decode(code, parameters), Err(InstructionError::Length));
    }
}
