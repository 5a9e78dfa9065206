extern crate std;

mod harm;

use super::*;
use crate::bridge::transparent_port::packets::{morpheus, morpheus_frame, stock};
use crate::bridge::transparent_port::{BusQuery, PendingRequest, Progress};
use crate::sequencer::TimeBudget;
use armbridge_servo::morpheus::MASTER;
use std::vec::Vec;

/// In the order of the joints, which is not that of the ids. One would do for a
/// client's address.
const CONTROLLED: [u8; 2] = [0x29, 4];
const SAMPLES: [Option<u16>; 2] = [Some(643), Some(0x1F4)];
const CLIENT: u8 = 0x64;

fn decide_for(bus: Firmware, samples: [Option<u16>; 2], packet: &[u8]) -> Verdict {
    let controlled =
        ServoIds::from(CONTROLLED.map(|id| armbridge_servo::ServoId::new(id).unwrap()));
    // As the framer knows packets: by their header.
    let protocol = if packet.first() == Some(&0xAA) {
        Firmware::Morpheus
    } else {
        Firmware::Stock
    };
    match ClientRequest::parse(protocol, packet) {
        Some(request) => decide(bus, controlled, samples, &request),
        None => Verdict::Refuse(Bytes::new()),
    }
}

/// Everything that a request puts on the bus, its reads answered with zeros (and
/// what a Morpheus servo has in the places that must not be 0x83).
fn queries(bus: Firmware, mut pending: PendingRequest, budget_us: u32) -> Vec<BusQuery> {
    let slack = TimeBudget {
        budget_us,
        byte_ns: 10_000,
        latency_us: 60,
    };
    let mut queries = Vec::new();
    while let Some(query) = pending.next(slack) {
        let overhead = if bus == Firmware::Stock { 6 } else { 5 };
        let mut reply = std::vec![0; usize::from(query.reply_bytes.saturating_sub(overhead))];
        if bus == Firmware::Morpheus && query.packet.get(5) == Some(&0) {
            reply[0] = 0xAA;
        }
        let is_answered = query.reply_bytes > 0;
        queries.push(query);
        if pending.take_reply(is_answered.then_some((0, &reply))) != Progress::More {
            break;
        }
    }
    queries
}

#[test]
fn a_stock_client_is_told_in_its_servos_words() {
    let asked = |id, code, parameters: &[u8]| {
        let packet = stock(id, code, parameters);
        match decide_for(Firmware::Stock, SAMPLES, &packet) {
            Verdict::Query(pending) => {
                let queries = queries(Firmware::Stock, pending, 2_000);
                assert_eq!(queries.len(), 1);
                assert_eq!(queries[0].packet.as_slice(), packet);
                Some(queries[0].reply_bytes)
            }
            Verdict::Answer(_) | Verdict::Refuse(_) => None,
        }
    };
    let verdict = |packet: &[u8]| match decide_for(Firmware::Stock, SAMPLES, packet) {
        Verdict::Query(pending) => panic!("{pending:?}"),
        Verdict::Answer(bytes) => ("answer", bytes.to_vec()),
        Verdict::Refuse(bytes) => ("refuse", bytes.to_vec()),
    };
    let answer = |alarms| ("answer", stock(4, alarms, &[]));
    let refusal = |id| ("refuse", stock(id, 0b100_0000, &[]));
    let silence = ("refuse", Vec::new());

    assert_eq!(asked(4, 1, &[]), Some(6));
    assert_eq!(asked(4, 2, &[0, 50]), Some(56));
    assert_eq!(asked(4, 3, &[25, 1]), Some(6));
    assert_eq!(asked(5, 3, &[30, 0, 2]), Some(6));
    assert_eq!(asked(5, 4, &[3, 6]), Some(6));
    assert_eq!(asked(0xFE, 0x83, &[30, 2, 5, 0, 2, 6, 0, 2]), Some(0));

    // Beyond the table, of no bytes, damaged.
    assert_eq!(verdict(&stock(4, 2, &[49, 2])), answer(0b1000));
    assert_eq!(verdict(&stock(4, 2, &[36, 0])), answer(0b1000));
    assert_eq!(verdict(&[0xFF, 0xFF, 4, 2, 1, 0]), answer(0b1_0000));
    assert_eq!(
        verdict(&[0xFF, 0xFF, 0xFE, 2, 1, 0]),
        ("answer", Vec::new())
    );
    // Would move it, rename it, or take its id.
    assert_eq!(verdict(&stock(0x29, 3, &[30, 0, 2])), refusal(0x29));
    assert_eq!(verdict(&stock(0x29, 3, &[24, 0, 1])), refusal(0x29));
    assert_eq!(verdict(&stock(0x29, 4, &[25, 1])), refusal(0x29));
    assert_eq!(verdict(&stock(5, 3, &[2, 0, 0x29])), refusal(5));
    assert_eq!(verdict(&stock(5, 6, &[])), refusal(5));
    assert_eq!(verdict(&stock(5, 5, &[])), refusal(5));
    assert_eq!(verdict(&stock(4, 0x92, &[0, 2, 4, 36])), refusal(4));
    for to_all in [
        stock(0xFE, 1, &[]),
        stock(0xFE, 2, &[36, 2]),
        stock(0xFE, 3, &[25, 1]),
        stock(0xFE, 5, &[]),
        stock(0xFE, 6, &[]),
        stock(0xFE, 0x83, &[30, 2, 5, 0, 2, 0x29, 0, 2]),
    ] {
        assert_eq!(verdict(&to_all), silence);
    }
    // Longer than any tick has time for.
    assert_eq!(asked(5, 3, &[0x18; 50]), Some(6));
    assert_eq!(verdict(&stock(5, 3, &[0x18; 59])), refusal(5));
    // The other protocol, and what is no whole packet.
    assert_eq!(verdict(&morpheus(4, CLIENT, &[1])), silence);
    assert_eq!(verdict(&[0xFF, 0xFF, 4, 3, 1, 0xF7]), silence);
    assert_eq!(verdict(&[]), silence);
}

#[test]
fn a_morpheus_client_is_told_in_its_servos_words() {
    let verdict = |packet: &[u8]| match decide_for(Firmware::Morpheus, SAMPLES, packet) {
        Verdict::Query(pending) => panic!("{pending:?}"),
        Verdict::Answer(bytes) => ("answer", bytes.to_vec()),
        Verdict::Refuse(bytes) => ("refuse", bytes.to_vec()),
    };
    let refusal = |id, to| ("refuse", morpheus(to, id, &[8]));
    let silence = ("refuse", Vec::new());

    // Positions: 643 is 0x0283, whose low byte deafens if a servo sends it first.
    let cycle = [
        morpheus(CLIENT, 4, &[0x01, 0xF4]),
        morpheus(CLIENT, 0x29, &[0x02, 0x83]),
    ]
    .concat();
    assert_eq!(verdict(&morpheus(0xFF, CLIENT, &[7])), ("answer", cycle));
    let position = morpheus(CLIENT, 0x29, &[0x83, 0x02]);
    assert_eq!(
        verdict(&morpheus(0x29, CLIENT, &[2, 0x0B, 2])),
        ("answer", position)
    );
    assert_eq!(
        verdict(&morpheus(5, CLIENT, &[2, 0x0B, 2])),
        refusal(5, CLIENT)
    );
    // Nothing, and beyond the table.
    assert_eq!(
        verdict(&morpheus(0x29, CLIENT, &[2, 0, 0])),
        refusal(0x29, CLIENT)
    );
    assert_eq!(
        verdict(&morpheus(0x29, CLIENT, &[2, 0x11, 2])),
        refusal(0x29, CLIENT)
    );
    // WRITE, RESET, MUTE, SYNC_WR; to all of them.
    assert_eq!(
        verdict(&morpheus(0x29, CLIENT, &[3, 0x10, 0, 0])),
        refusal(0x29, CLIENT)
    );
    assert_eq!(verdict(&morpheus(5, CLIENT, &[9])), refusal(5, CLIENT));
    assert_eq!(
        verdict(&morpheus(0x29, CLIENT, &[5])),
        refusal(0x29, CLIENT)
    );
    assert_eq!(
        verdict(&morpheus(0x29, CLIENT, &[0x83, 0x10, 2, 0x29, 0, 0])),
        refusal(0x29, CLIENT)
    );
    for data in [&[1][..], &[3, 0x10, 0, 0], &[6], &[9]] {
        assert_eq!(verdict(&morpheus(0xFF, CLIENT, data)), silence);
    }
    // Addresses that would make servos talk to each other, and the packet that
    // ends their hearing.
    for address in [0x1F, 0x29, 0xFF] {
        assert_eq!(
            verdict(&morpheus(0x29, address, &[1])),
            refusal(0x29, address)
        );
    }
    let deafening = morpheus(0x29, CLIENT, &[0; 126]);
    assert_eq!(verdict(&deafening), refusal(0x29, CLIENT));
    let wedges = |packet: &[u8]| {
        let request = ClientRequest::parse(Firmware::Morpheus, packet).unwrap();
        request.wedges_servo()
    };
    assert!(wedges(&deafening));
    assert!(!wedges(&morpheus(0x29, CLIENT, &[0; 125])));
    // Damaged, to no servo, and of the other protocol.
    assert_eq!(
        verdict(&[0xAA, 3, 0x29, 0xFE, 1, 0]),
        ("answer", Vec::new())
    );
    assert_eq!(verdict(&morpheus(0xFE, CLIENT, &[1])), silence);
    assert_eq!(verdict(&stock(0x29, 1, &[])), silence);
}

/// A read across everything: EEPROM, the loop's sample, and the rest.
#[test]
fn all_of_morpheus_is_read_in_two_safe_requests() {
    let packet = morpheus(0x29, CLIENT, &[2, 0, 18]);
    let Verdict::Query(mut pending) = decide_for(Firmware::Morpheus, SAMPLES, &packet) else {
        panic!("refused");
    };
    let slack = TimeBudget {
        budget_us: 400,
        byte_ns: 10_000,
        latency_us: 100,
    };
    let first = pending.next(slack).unwrap();
    assert_eq!(
        morpheus_frame(&first.packet),
        (0x29, MASTER, std::vec![2, 0, 11])
    );
    let rom = [0xAA, 9, 2, 2, 40, 1, 10, 40, 10, 0, 1];
    assert_eq!(pending.take_reply(Some((0, &rom))), Progress::More);
    let second = pending.next(slack).unwrap();
    assert_eq!(
        morpheus_frame(&second.packet),
        (0x29, MASTER, std::vec![2, 0x0C, 6])
    );
    let Progress::Done(answer) = pending.take_reply(Some((0, &[0x03, 7, 0x2C, 1, 0xDC, 0]))) else {
        panic!("{pending:?}");
    };
    let mut expected = rom.to_vec();
    // Both bytes of the position are of one sample.
    expected.extend([0x83, 0x02, 7, 0x2C, 1, 0xDC, 0]);
    assert_eq!(morpheus_frame(&answer), (CLIENT, 0x29, expected));
    // Without a sample there is no such read.
    let blind = decide_for(Firmware::Morpheus, [None, Some(500)], &packet);
    assert!(
        matches!(blind, Verdict::Refuse(bytes) if bytes == morpheus(CLIENT, 0x29, &[8]).as_slice())
    );
}
