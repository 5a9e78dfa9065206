//! One instruction to several servos: the order of their replies.

use armbridge_servo::protocol2::register as at;
use armbridge_servo::protocol2::{BROADCAST, BulkItem, FastStatus, Instruction, Parser};

use super::{Rig, statuses};

/// Three models, at 100, 200 and 300 counts.
fn three() -> Rig {
    let mut rig = Rig::new(&[(1060, 1), (1200, 2), (1020, 3)]);
    rig.restart_at([100, 200, 300]);
    rig
}

fn positions(ids: &[u8]) -> Instruction<'_> {
    Instruction::SyncRead {
        address: at::PRESENT_POSITION,
        count: 4,
        ids,
    }
}

#[test]
fn a_sync_read_is_answered_in_the_order_of_the_list() {
    let mut rig = three();
    let request = positions(&[3, 1, 2]).encode::<32>(BROADCAST).unwrap();
    let answer = rig.exchange_for(&request, 5_000_000);
    let found: Vec<_> = statuses(&answer)
        .into_iter()
        .map(|status| (status.id, status.parameters[0]))
        .collect();
    assert_eq!(found, [(3, 44), (1, 100), (2, 200)]);
    // Those behind a silent one wait, and the next instruction ends it.
    rig.wire.connect(0, false);
    let answer = rig.exchange_for(&request, 50_000_000);
    assert_eq!(statuses(&answer).len(), 1);
    assert_eq!(rig.status(2, Instruction::Ping).id, 2);
    // Not to read at all.
    rig.wire.connect(0, true);
    for id in 1..=3 {
        let _ = rig.write(id, at::STATUS_RETURN_LEVEL, &[0]);
    }
    assert!(rig.exchange_for(&request, 5_000_000).is_empty());
}

#[test]
fn replies_do_not_overlap() {
    let mut rig = three();
    let request = positions(&[1, 2, 3]).encode::<32>(BROADCAST).unwrap();
    rig.send(&request);
    let received = rig.wait(5_000_000);
    assert_eq!(received.len(), 45);
    assert!(received.iter().all(|byte| !byte.framing_error));
    let ends: Vec<u64> = received.iter().map(|byte| byte.end_ns).collect();
    let gaps = [ends[15] - ends[14], ends[30] - ends[29]];
    // Return delay, processing, and a byte.
    for gap in gaps {
        assert!((530_000..532_000).contains(&gap), "{gap}");
    }
}

#[test]
fn a_fast_sync_read_is_one_packet_with_a_part_of_each() {
    let mut rig = three();
    let ids = [2, 3, 1];
    let request = Instruction::FastSyncRead {
        address: at::PRESENT_POSITION,
        count: 4,
        ids: &ids,
    };
    let request = request.encode::<32>(BROADCAST).unwrap();
    for _ in 0..3 {
        rig.send(&request);
        let received = rig.wait(5_000_000);
        assert!(received.iter().all(|byte| !byte.framing_error));
        let bytes: Vec<u8> = received.iter().map(|byte| byte.byte).collect();
        assert_eq!(bytes.len(), FastStatus::packet_bytes(3, 4));
        let parts: Vec<_> = FastStatus::new(&bytes, 4)
            .unwrap()
            .map(|part| part.map(|part| (part.id, part.data[0], part.error)))
            .collect();
        assert_eq!(
            parts,
            [Ok((2, 200, None)), Ok((3, 44, None)), Ok((1, 100, None))]
        );
        // It ends as every packet does.
        let mut parser = Parser::<128>::new();
        let ends = bytes.iter().filter(|byte| parser.push(**byte).is_some());
        assert_eq!(ends.count(), 1);
    }
    // A silent servo ends it; the servos before it have been heard.
    rig.wire.connect(2, false);
    let answer = rig.exchange_for(&request, 150_000_000);
    assert_eq!(answer.len(), FastStatus::packet_bytes(1, 4));
    assert_eq!(FastStatus::new(&answer, 4).unwrap().count(), 1);
    assert_eq!(rig.status(1, Instruction::Ping).id, 1);
}

#[test]
fn an_instruction_before_the_first_part_takes_its_place() {
    let mut rig = three();
    let request = Instruction::FastSyncRead {
        address: at::PRESENT_POSITION,
        count: 4,
        ids: &[1, 2],
    };
    let request = request.encode::<32>(BROADCAST).unwrap();
    rig.send(&request);
    // 16 bytes, and a part of the return delay.
    assert!(rig.wait(300_000).is_empty());
    assert_eq!(rig.status(1, Instruction::Ping).parameters.len(), 3);
    let answer = rig.exchange(&request);
    assert_eq!(FastStatus::new(&answer, 4).unwrap().count(), 2);
}

#[test]
fn bulk_reads_and_writes_are_each_ones_own() {
    let mut rig = three();
    let items: Vec<u8> = [(2, at::MODEL_NUMBER, 2), (1, at::PRESENT_POSITION, 4)]
        .into_iter()
        .flat_map(|(id, address, count)| BulkItem { id, address, count }.encode())
        .collect();
    let answer = rig.ask(BROADCAST, Instruction::BulkRead(&items));
    let found: Vec<_> = statuses(&answer)
        .into_iter()
        .map(|status| (status.id, status.parameters))
        .collect();
    assert_eq!(found, [(2, vec![0xB0, 4]), (1, vec![100, 0, 0, 0])]);
    let fast = rig.ask(BROADCAST, Instruction::FastBulkRead(&items));
    assert_eq!(fast.len(), 8 + 6 + 8);
    // Error, id, data and CRC of each.
    assert_eq!(fast[8..12], [0, 2, 0xB0, 4]);
    assert_eq!(fast[14..20], [0, 1, 100, 0, 0, 0]);
    let mut parser = Parser::<64>::new();
    let last = fast
        .iter()
        .find_map(|byte| parser.push(*byte).map(|end| end.is_ok()));
    assert_eq!(last, Some(true));
    let blocks = [
        3, 65, 0, 1, 0, 1, //
        1, 80, 0, 2, 0, 7, 0,
    ];
    assert!(
        rig.ask(BROADCAST, Instruction::BulkWrite(&blocks))
            .is_empty()
    );
    assert_eq!(rig.register(2, at::LED), 1);
    assert_eq!(rig.register(0, at::POSITION_D_GAIN), 7);
}

#[test]
fn a_broadcast_ping_is_answered_by_all() {
    let mut rig = three();
    let ping = Instruction::Ping.encode::<16>(BROADCAST).unwrap();
    let answer = rig.exchange_for(&ping, 20_000_000);
    let found: Vec<_> = statuses(&answer)
        .into_iter()
        .map(|status| {
            let model = u16::from_le_bytes([status.parameters[0], status.parameters[1]]);
            (status.id, model)
        })
        .collect();
    assert_eq!(found, [(1, 1060), (2, 1200), (3, 1020)]);
}
