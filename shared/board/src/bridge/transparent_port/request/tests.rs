extern crate std;

use super::*;
use crate::bridge::transparent_port::packets::{morpheus_frame, stock_frame};
use armbridge_servo::morpheus::{self, MASTER};
use armbridge_servo::protocol1::{self, Instruction};
use armbridge_servo::{Firmware, protocol2};
use proptest::prelude::*;
use std::vec::Vec;

const SERVO: u8 = 7;
const CLIENT: u8 = 0x64;
const LATENCY_US: u32 = 60;
const BYTE_NS: u32 = 10_000;

fn slack(budget_us: u32) -> TimeBudget {
    TimeBudget {
        budget_us,
        byte_ns: BYTE_NS,
        latency_us: LATENCY_US,
    }
}

/// A servo's memory.
#[derive(Clone, Debug)]
struct Memory {
    bus: Firmware,
    bytes: Vec<u8>,
}

impl Memory {
    /// The servo's reply to a READ.
    fn answer(&self, query: &BusQuery) -> Vec<u8> {
        assert_eq!(query.id, SERVO);
        let (address, count, overhead) = match self.bus {
            Firmware::Stock => {
                let (id, code, parameters) = stock_frame(&query.packet);
                let frame = protocol1::Frame {
                    id,
                    code,
                    parameters: &parameters,
                };
                let Ok(Instruction::Read { address, count }) = Instruction::decode(&frame) else {
                    panic!("{frame:?}");
                };
                assert_eq!(id, SERVO);
                (address, count, 6)
            }
            Firmware::Morpheus => {
                let (to, from, data) = morpheus_frame(&query.packet);
                assert_eq!((to, from, data[0]), (SERVO, MASTER, 2));
                (data[1].into(), data[2].into(), 5)
            }
            Firmware::XSeries => {
                let (head, parameters) = query.packet.split_at(8);
                assert_eq!(head, [0xFF, 0xFF, 0xFD, 0, SERVO, 7, 0, 2]);
                let word = |at: usize| u16::from_le_bytes([parameters[at], parameters[at + 1]]);
                (word(0), word(2), 11)
            }
        };
        assert_eq!(query.reply_bytes, overhead + count);
        let answer = &self.bytes[usize::from(address)..][..usize::from(count)];
        if self.bus == Firmware::Morpheus {
            assert!(answer[0] != 0x83, "deafens the others");
            assert!(address >= 0x0B || address + count <= 0x0B, "no RAM there");
        }
        answer.to_vec()
    }

    fn position(&self) -> Option<u16> {
        (self.bus == Firmware::Morpheus)
            .then(|| u16::from_le_bytes([self.bytes[0x0B], self.bytes[0x0C]]))
    }

    fn request(&self, address: u16, count: u16) -> Option<PendingRequest> {
        let responder = Responder {
            firmware: self.bus,
            id: SERVO,
            client: CLIENT,
        };
        let read = RegisterRead::new(responder, self.position(), address, count)?;
        Some(PendingRequest::read(responder, read))
    }

    /// The reply that the client must get to a read of all this at once.
    fn whole(&self, address: u16, count: u16, alarms: u8) -> Vec<u8> {
        let data = &self.bytes[usize::from(address)..][..usize::from(count)];
        match self.bus {
            Firmware::Stock => protocol1::Frame {
                id: SERVO,
                code: alarms,
                parameters: data,
            }
            .encode::<60>()
            .unwrap()
            .to_vec(),
            Firmware::Morpheus => morpheus::Frame {
                destination: CLIENT,
                source: SERVO,
                data,
            }
            .encode::<60>()
            .unwrap()
            .to_vec(),
            Firmware::XSeries => {
                // Range alarms are a data range error, those of AX-12A alone none.
                let error = match alarms {
                    _ if alarms & 1 << 4 != 0 => 3,
                    _ if alarms & 1 << 3 != 0 => 4,
                    _ if alarms & 1 << 6 != 0 => 2,
                    _ => 0,
                };
                let frame = protocol2::Frame {
                    id: SERVO,
                    code: protocol2::frame::STATUS,
                    parameters: &[&[error], data].concat(),
                };
                frame.encode::<300>().unwrap().to_vec()
            }
        }
    }
}

fn memory() -> impl Strategy<Value = Memory> {
    let stock = prop::collection::vec(any::<u8>(), 50).prop_map(|bytes| Memory {
        bus: Firmware::Stock,
        bytes,
    });
    let morpheus = (
        prop::collection::vec(any::<u8>(), 18),
        // All that the firmware accepts.
        prop::sample::select(&[0, 1, 3, 16, 34, 207][..]),
        0..1024_u16,
        0..1024_u16,
    )
        .prop_map(|(mut bytes, baud, position, temperature)| {
            bytes[0x00] = 0xAA;
            bytes[0x0A] = baud;
            bytes[0x0B..0x0D].copy_from_slice(&position.to_le_bytes());
            bytes[0x0E..0x10].copy_from_slice(&temperature.to_le_bytes());
            bytes[0x11] = 0;
            Memory {
                bus: Firmware::Morpheus,
                bytes,
            }
        });
    let x_series = prop::collection::vec(any::<u8>(), 147).prop_map(|bytes| Memory {
        bus: Firmware::XSeries,
        bytes,
    });
    prop_oneof![stock, morpheus, x_series]
}

proptest! {
    /// However little time there is each time, the pieces make the whole, and
    /// none of them takes longer than there is time for.
    #[test]
    fn pieces_make_the_whole(
        memory in memory(),
        from: prop::sample::Index,
        to: prop::sample::Index,
        budgets_us in prop::collection::vec((0..500_u32, 0..0x80_u8), 1..20),
    ) {
        let size = memory.bytes.len();
        let address = from.index(size);
        // No more than a reply may have.
        let count = (1 + to.index(size - address)).min(if size > 50 { 40 } else { 50 });
        let (address, count) = (address as u16, count as u16);
        let mut pending = memory.request(address, count).unwrap();
        let mut alarms = 0;
        let mut answer = None;
        if let Queries::Read(read) = &pending.queries && read.is_complete() {
            prop_assert_eq!((memory.bus, address >= 0x0B), (Firmware::Morpheus, true));
            prop_assert!(address + count <= 0x0D);
            return Ok(());
        }
        for (budget_us, alarm) in budgets_us.iter().chain(core::iter::repeat_n(&(1_000, 0), 100)) {
            let Some(query) = pending.next(slack(*budget_us)) else {
                // A whole EEPROM or a register from its run-up is 24 bytes; a register of four
                // bytes of an X servo 29.
                let most_us = if memory.bus == Firmware::XSeries { 350 } else { 300 };
                prop_assert!(*budget_us < most_us);
                continue;
            };
            let bytes = query.packet.len() + usize::from(query.reply_bytes);
            prop_assert!(bytes as u32 * 10 + LATENCY_US <= *budget_us);
            let (before, reply) = (pending.clone(), memory.answer(&query));
            alarms |= alarm;
            match pending.take_reply(Some((*alarm, &reply))) {
                Progress::More => {
                    let Queries::Read(read) = &pending.queries else { unreachable!() };
                    let cut = address + read.data().len() as u16;
                    let start = memory.bus.register_start(cut);
                    prop_assert!(start == cut, "{cut} {before:?}");
                }
                Progress::Done(bytes) => {
                    answer = Some(bytes);
                    break;
                }
                Progress::Silent => prop_assert!(false, "{before:?} {reply:x?}"),
            }
        }
        prop_assert_eq!(answer.unwrap().to_vec(), memory.whole(address, count, alarms));
    }

    /// It is known from the start whether a tick's slack will ever do.
    #[test]
    fn a_request_ends_if_it_ever_fits(
        memory in memory(),
        from: prop::sample::Index,
        to: prop::sample::Index,
        budget_us in 150..400_u32,
    ) {
        let size = memory.bytes.len();
        let address = from.index(size);
        // No more than a reply may have.
        let count = (1 + to.index(size - address)).min(if size > 50 { 40 } else { 50 });
        let mut pending = memory.request(address as u16, count as u16).unwrap();
        let fits = pending.can_complete(slack(budget_us));
        let mut ended = matches!(&pending.queries, Queries::Read(read) if read.is_complete());
        while !ended && let Some(query) = pending.next(slack(budget_us)) {
            let reply = memory.answer(&query);
            ended = matches!(pending.take_reply(Some((0, &reply))), Progress::Done(_));
        }
        prop_assert_eq!(fits, ended, "{:?}", pending);
    }
}

fn stock_read() -> PendingRequest {
    let responder = Responder {
        firmware: Firmware::Stock,
        id: SERVO,
        client: CLIENT,
    };
    let read = RegisterRead::new(responder, None, 36, 8).unwrap();
    PendingRequest::read(responder, read)
}

#[test]
fn silence_and_nonsense_are_silence() {
    for reply in [None, Some((0, &[1, 2, 3][..]))] {
        let mut pending = stock_read();
        let query = pending.next(slack(1_000)).unwrap();
        assert_eq!(query.reply_bytes, 14);
        assert_eq!(pending.take_reply(reply), Progress::Silent);
    }
}

#[test]
fn a_servos_refusal_ends_the_request_and_is_passed_on() {
    let mut pending = stock_read();
    pending.next(slack(220)).unwrap();
    assert_eq!(
        pending.take_reply(Some((0b10_0000, &[1, 2]))),
        Progress::More
    );
    pending.next(slack(220)).unwrap();
    let Progress::Done(answer) = pending.take_reply(Some((0b100_0000, &[]))) else {
        panic!("{pending:?}");
    };
    assert_eq!(stock_frame(&answer), (SERVO, 0b110_0000, Vec::new()));
}

#[test]
fn what_nobody_answers_is_over_when_it_is_sent() {
    let query = BusQuery {
        packet: Instruction::Action.encode(0xFE).unwrap(),
        id: 0xFE,
        reply_bytes: 0,
    };
    let responder = Responder {
        firmware: Firmware::Stock,
        id: 0xFE,
        client: CLIENT,
    };
    let mut pending = PendingRequest::single(responder, query.clone());
    assert_eq!(pending.next(slack(119)), None);
    assert_eq!(pending.next(slack(120)), Some(query));
    assert_eq!(pending.take_reply(None), Progress::Done(Bytes::new()));
}
