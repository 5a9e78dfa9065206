//! No input of a client puts a harmful packet on the bus.

extern crate std;

use super::{CLIENT, CONTROLLED, decide_for, queries};
use crate::bridge::transparent_port::Verdict;
use crate::bridge::transparent_port::packets::{morpheus, morpheus_frame, stock, stock_frame};
use armbridge_servo::Firmware;
use armbridge_servo::morpheus::{MASTER, ServoId};
use armbridge_servo::protocol1::{self, BROADCAST, Instruction, SyncBlocks};
use proptest::prelude::*;
use std::vec::Vec;

/// Bytes that a client might send: any, and packets that are nearly right.
fn packet() -> impl Strategy<Value = Vec<u8>> {
    let id = || {
        prop_oneof![
            Just(4_u8),
            Just(0x29),
            Just(5),
            Just(0),
            Just(0xFE),
            Just(0xFF),
            any::<u8>()
        ]
    };
    let parameters = || {
        let near = prop_oneof![4 => 0..10_u8, 1 => Just(25_u8), 1 => any::<u8>()];
        prop::collection::vec(near, 0..12)
    };
    let code = prop_oneof![6 => 1..8_u8, 2 => Just(0x83_u8), 1 => any::<u8>()];
    let command = prop_oneof![6 => 1..10_u8, 1 => Just(0x83_u8), 1 => any::<u8>()];
    let of_stock =
        (id(), code, parameters()).prop_map(|(id, code, parameters)| stock(id, code, &parameters));
    let of_morpheus = (
        id(),
        prop_oneof![3 => Just(CLIENT), 1 => id()],
        command,
        parameters(),
    )
        .prop_map(|(to, from, command, mut data)| {
            data.insert(0, command);
            morpheus(to, from, &data)
        });
    let blocks = prop::collection::vec((prop_oneof![8 => Just(5_u8), 1 => id()], id()), 1..5);
    let sync = (0..40_u8, blocks).prop_map(|(address, blocks)| {
        let blocks = blocks.into_iter().flat_map(|(id, data)| [id, data]);
        let parameters: Vec<u8> = [address, 1].into_iter().chain(blocks).collect();
        stock(BROADCAST, 0x83, &parameters)
    });
    let any = prop::collection::vec(any::<u8>(), 0..40);
    prop_oneof![4 => of_stock, 4 => of_morpheus, 2 => sync, 1 => any]
}

fn is_free(id: u8) -> bool {
    id < BROADCAST && !CONTROLLED.contains(&id)
}

/// Whether a stock servo under control is none the worse for these bytes.
fn stock_is_harmless(bytes: &[u8]) -> bool {
    let (id, code, parameters) = stock_frame(bytes);
    let frame = protocol1::Frame {
        id,
        code,
        parameters: &parameters,
    };
    let spares_ids = |address: u16, data: &[u8]| {
        (address..)
            .zip(data)
            .all(|(at, byte)| at != 3 || is_free(*byte))
    };
    match Instruction::decode(&frame).unwrap() {
        Instruction::Ping | Instruction::Read { .. } => id < BROADCAST,
        Instruction::Write { address: 25, data } if data.len() == 1 => id < BROADCAST,
        Instruction::Write { address, data } | Instruction::RegWrite { address, data } => {
            is_free(id) && spares_ids(address, data)
        }
        Instruction::SyncWrite {
            address,
            count,
            blocks,
        } => SyncBlocks::new(count, blocks)
            .all(|(id, data)| is_free(id) && spares_ids(address, data)),
        Instruction::SyncRead { .. }
        | Instruction::FastSyncRead { .. }
        | Instruction::Action
        | Instruction::FactoryReset
        | Instruction::Start
        | Instruction::Cycle => false,
    }
}

/// Whether these bytes are a PING or a READ whose answer cannot begin with
/// 0x83.
fn morpheus_is_harmless(bytes: &[u8]) -> bool {
    let (to, from, data) = morpheus_frame(bytes);
    let is_safe = match data[..] {
        [1] => true,
        [2, 0x00, count] => (1..=0x0B).contains(&count),
        [2, address @ (0x0C | 0x0F), count] => (1..=0x12 - address).contains(&count),
        _ => false,
    };
    is_safe && from == MASTER && ServoId::new(to).is_some()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4096))]

    /// Any input of a client, in pieces of any size.
    #[test]
    fn nothing_that_harms_reaches_the_bus(
        packet in packet(),
        is_stock: bool,
        samples in any::<[Option<u16>; 2]>(),
        budget_us in 200..800_u32,
    ) {
        let bus = if is_stock { Firmware::Stock } else { Firmware::Morpheus };
        let pending = match decide_for(bus, samples, &packet) {
            Verdict::Query(pending) => pending,
            Verdict::Answer(answer) | Verdict::Refuse(answer) => {
                // All that is sent is one packet of the bus's protocol, or a CYCLE's.
                let header = if is_stock { 0xFF } else { 0xAA };
                prop_assert!(answer.is_empty() || answer[0] == header);
                return Ok(());
            }
        };
        for query in queries(bus, pending, budget_us) {
            let is_harmless = if is_stock {
                stock_is_harmless(&query.packet)
            } else {
                morpheus_is_harmless(&query.packet)
            };
            prop_assert!(is_harmless, "{:x?} became {:x?}", packet, query);
        }
    }
}
