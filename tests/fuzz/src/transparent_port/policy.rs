//! Treatment of a packet while servos 1 and 2 are under control.

use armbridge_board::bridge::transparent_port::{
    BusQuery, PendingRequest, Progress, Verdict, decide,
};
use armbridge_board::sequencer::TimeBudget;
use armbridge_servo::morpheus::{self, MASTER, ServoId};
use armbridge_servo::protocol1::{self, BROADCAST, Frame, Instruction, Status, SyncBlocks};
use armbridge_servo::{ClientRequest, Firmware, protocol2};

const CONTROLLED: [u8; 2] = [1, 2];
/// Positions that the loop has read: none of the second servo.
const SAMPLES: [Option<u16>; 2] = [Some(643), None];
/// Time for the shortest requests, and for most of them.
const BUDGETS_US: [u32; 2] = [300, 760];
const BYTE_NS: u32 = 10_000;
const LATENCY_US: u32 = 100;
/// A whole table, in pieces of one byte.
const PIECES_MAX: usize = 150;
/// Bytes of an X servo's reply beside its data.
const X_OVERHEAD: usize = 11;
/// Where a stock servo's id is.
const ID: u16 = 3;
const LED: u16 = 25;
/// The same in both protocols, and in the same place of a packet.
const READ: u8 = 2;
/// First byte of a Morpheus servo's memory.
const MARKER: u8 = 0xAA;

/// Has a packet judged on a bus of either firmware.
///
/// # Panics
/// If something goes on the bus that moves, renames or deafens a servo under
/// control or that takes longer than there is time, or if the client gets a
/// reply that no servo would send.
pub(super) fn check(protocol: Firmware, packet: &[u8]) {
    let is_long = protocol == Firmware::Morpheus && packet[1] >= 128;
    let request = ClientRequest::parse(protocol, packet).expect("a whole packet");
    assert_eq!(request.wedges_servo(), is_long, "{packet:02x?}");
    may_drive(&request);
    let controlled = CONTROLLED.map(|id| ServoId::new(id).expect("an id"));
    for bus in Firmware::ALL {
        match decide(bus, controlled.into(), SAMPLES, &request) {
            Verdict::Query(pending) => {
                assert_eq!(bus, protocol, "{packet:02x?}");
                for budget_us in BUDGETS_US {
                    pursue(bus, packet, pending.clone(), budget_us);
                }
            }
            Verdict::Answer(bytes) | Verdict::Refuse(bytes) => {
                assert!(bytes.is_empty() || bus == protocol, "{packet:02x?}");
                answer(bus, packet, &bytes);
            }
        }
    }
}

/// Checks that only reading requests count as unable to drive, and their replies.
fn may_drive(request: &ClientRequest) {
    let packet = request.bytes;
    let (code, overhead) = match request.firmware {
        Firmware::Morpheus => (packet[4], morpheus::frame::OVERHEAD),
        Firmware::Stock => (packet[4], protocol1::frame::OVERHEAD),
        Firmware::XSeries => (packet[7], X_OVERHEAD),
    };
    let expected = request.expected_reply();
    if !request.may_drive() {
        let is_chain = request.firmware == Firmware::Morpheus && matches!(code, 6 | 7);
        let is_of_several = request.firmware == Firmware::XSeries && matches!(code, 0x82 | 0x8A);
        assert!(
            matches!(code, 1 | READ) || is_chain || is_of_several,
            "{packet:02x?}"
        );
        if code == READ && !request.is_broadcast() {
            let data = usize::from(expected.reply_bytes).saturating_sub(overhead);
            let requested = match request.firmware {
                Firmware::XSeries => usize::from(u16::from_le_bytes([packet[10], packet[11]]))
                    .min(usize::from(u16::MAX) - overhead),
                _ => usize::from(packet[6]).min(usize::from(u8::MAX) - overhead),
            };
            assert_eq!(data, requested, "{packet:02x?}");
        }
    }
    assert!(expected.reply_bytes == 0 || expected.id == request.destination);
}

/// Completes a request with servos all of whose registers are 0 but the marker.
fn pursue(bus: Firmware, packet: &[u8], mut pending: PendingRequest, budget_us: u32) {
    let slack = TimeBudget {
        budget_us,
        byte_ns: BYTE_NS,
        latency_us: LATENCY_US,
    };
    if !pending.can_complete(slack) {
        answer(bus, packet, &pending.refusal());
        return;
    }
    for _ in 0..PIECES_MAX {
        let query = pending.next(slack).expect("it can fit");
        harms_nobody(bus, &query);
        let bytes = query.packet.len() as u32 + u32::from(query.reply_bytes);
        assert!(
            LATENCY_US + bytes * BYTE_NS / 1_000 <= budget_us,
            "{query:?}"
        );
        let overhead = match bus {
            Firmware::Morpheus => morpheus::frame::OVERHEAD,
            Firmware::Stock => protocol1::frame::OVERHEAD,
            Firmware::XSeries => X_OVERHEAD,
        };
        let data = usize::from(query.reply_bytes).checked_sub(overhead);
        let mut data = data.map(|count| vec![0; count]);
        if let (Firmware::Morpheus, [_, _, _, _, READ, 0, ..], Some([first, ..])) =
            (bus, query.packet.as_slice(), data.as_deref_mut())
        {
            *first = MARKER;
        }
        match pending.take_reply(data.as_deref().map(|data| (0, data))) {
            Progress::More => {}
            Progress::Done(bytes) => {
                // All that was asked for, however many pieces it took.
                if let ([_, _, _, _, READ, _, count, _], Firmware::Morpheus | Firmware::Stock) =
                    (packet, bus)
                {
                    assert_eq!(bytes.len(), usize::from(*count) + overhead);
                }
                answer(bus, packet, &bytes);
                return;
            }
            Progress::Silent => panic!("{packet:02x?}: silence after {query:?}"),
        }
    }
    panic!("{packet:02x?} does not end");
}

/// Replies to the client: none, or packets in the name of the servo it addressed.
fn answer(bus: Firmware, packet: &[u8], bytes: &[u8]) {
    if bytes.is_empty() {
        return;
    }
    match bus {
        Firmware::Stock => {
            let frame = stock(bytes);
            let status = Status::decode(&frame).expect("a status packet");
            assert_eq!(status.id, packet[2], "{bytes:02x?}");
        }
        Firmware::XSeries => {
            let mut parser = protocol2::Parser::<300>::new();
            let (last, before) = bytes.split_last().expect("it is not empty");
            assert!(before.iter().all(|byte| parser.push(*byte).is_none()));
            let frame = parser
                .push(*last)
                .expect("its end")
                .expect("an intact packet");
            let status = protocol2::Status::decode(&frame).expect("a status packet");
            assert_eq!(status.id, packet[4], "{bytes:02x?}");
        }
        Firmware::Morpheus => {
            let mut parser = morpheus::frame::Parser::<130>::new();
            for byte in bytes {
                let frame = parser
                    .push(*byte)
                    .map(|found| found.expect("an intact packet"));
                if let Some(frame) = frame {
                    assert_eq!(frame.destination, packet[3], "{bytes:02x?}");
                    let is_cycle = packet[2] == morpheus::BROADCAST;
                    let is_addressed = frame.source == packet[2];
                    assert!(is_addressed || is_cycle && CONTROLLED.contains(&frame.source));
                }
            }
            assert_eq!(parser.bytes_held(), 0, "{bytes:02x?}");
        }
    }
}

/// Packets that the board sends for it.
fn harms_nobody(bus: Firmware, query: &BusQuery) {
    let is_harmless = match bus {
        Firmware::Stock => stock_is_harmless(&query.packet),
        Firmware::Morpheus => morpheus_is_harmless(&query.packet),
        Firmware::XSeries => x_is_harmless(&query.packet),
    };
    assert!(is_harmless, "{query:02x?}");
}

fn is_free(id: u8) -> bool {
    id < BROADCAST && !CONTROLLED.contains(&id)
}

fn stock_is_harmless(packet: &[u8]) -> bool {
    let frame = stock(packet);
    let keeps_ids = |address: u16, data: &[u8]| {
        (address..)
            .zip(data)
            .all(|(at, byte)| at != ID || is_free(*byte))
    };
    match Instruction::decode(&frame).expect("an instruction") {
        Instruction::Ping
        | Instruction::Read { .. }
        | Instruction::Write {
            address: LED,
            data: [_],
        } => frame.id < BROADCAST,
        Instruction::Write { address, data } | Instruction::RegWrite { address, data } => {
            is_free(frame.id) && keeps_ids(address, data)
        }
        Instruction::SyncWrite {
            address,
            count,
            blocks,
        } => {
            SyncBlocks::new(count, blocks).all(|(id, data)| is_free(id) && keeps_ids(address, data))
        }
        Instruction::SyncRead { .. }
        | Instruction::FastSyncRead { .. }
        | Instruction::Action
        | Instruction::FactoryReset
        | Instruction::Start
        | Instruction::Cycle => false,
    }
}

fn x_is_harmless(packet: &[u8]) -> bool {
    use protocol2::Instruction;
    let mut parser = protocol2::Parser::<300>::new();
    let (last, before) = packet.split_last().expect("a packet has bytes");
    assert!(before.iter().all(|byte| parser.push(*byte).is_none()));
    let Some(Ok(frame)) = parser.push(*last) else {
        return false;
    };
    // Id and secondary id.
    let keeps_ids = |address: u16, data: &[u8]| {
        (address..)
            .zip(data)
            .all(|(at, byte)| !matches!(at, 7 | 12) || is_free(*byte))
    };
    match Instruction::decode(&frame).expect("an instruction") {
        Instruction::Ping
        | Instruction::Read { .. }
        | Instruction::Write {
            address: 65,
            data: [_],
        } => frame.id < BROADCAST,
        Instruction::Write { address, data } | Instruction::RegWrite { address, data } => {
            is_free(frame.id) && keeps_ids(address, data)
        }
        Instruction::SyncWrite {
            address,
            count,
            blocks,
        } => {
            SyncBlocks::new(count, blocks).all(|(id, data)| is_free(id) && keeps_ids(address, data))
        }
        _ => false,
    }
}

/// A PING, or a READ whose answer cannot begin with 0x83, which deafens.
fn morpheus_is_harmless(packet: &[u8]) -> bool {
    let mut parser = morpheus::frame::Parser::<130>::new();
    let (last, before) = packet.split_last().expect("a packet has bytes");
    assert!(before.iter().all(|byte| parser.push(*byte).is_none()));
    let Some(Ok(frame)) = parser.push(*last) else {
        return false;
    };
    let is_safe = match *frame.data {
        // A PING, or the baud rate: of the few that there are none is 0x83.
        [1] | [2, 0x0A, 1] => true,
        [2, 0x00, count] => (1..=0x0B).contains(&count),
        [2, address @ (0x0C | 0x0F), count] => (1..=0x12 - address).contains(&count),
        _ => false,
    };
    is_safe && frame.source == MASTER && ServoId::new(frame.destination).is_some()
}

/// One intact packet.
fn stock(packet: &[u8]) -> Frame<'_> {
    let [0xFF, 0xFF, body @ .., sum] = packet else {
        panic!("{packet:02x?}");
    };
    assert_eq!(protocol1::frame::checksum(body), *sum, "{packet:02x?}");
    let [id, length, code, parameters @ ..] = body else {
        panic!("{packet:02x?}");
    };
    assert_eq!(usize::from(*length), parameters.len() + 2, "{packet:02x?}");
    Frame {
        id: *id,
        code: *code,
        parameters,
    }
}
