extern crate std;

use super::*;
use armbridge_servo::{morpheus, protocol1};
use proptest::prelude::*;
use std::vec;
use std::vec::Vec;

type Found = Vec<(FrameKind, Vec<u8>)>;

const BYTE_US: u64 = 10;

/// Pushes all, a byte every 10 µs from `now_us` on.
fn push_all(framer: &mut Framer, bytes: &[u8], now_us: &mut u64) -> Found {
    let mut found = Found::new();
    for byte in bytes {
        *now_us += BYTE_US;
        if let Some(kind) = framer.push(*byte, *now_us) {
            found.push((kind, framer.bytes().to_vec()));
        }
    }
    found
}

/// Lets time pass until nothing is waited for.
fn drain(framer: &mut Framer, now_us: &mut u64) -> Found {
    let mut found = Found::new();
    while let Some(wake_us) = framer.wake_at_us() {
        *now_us = wake_us.max(*now_us);
        found.extend(
            framer
                .expire(*now_us)
                .map(|kind| (kind, framer.bytes().to_vec())),
        );
    }
    found
}

/// A packet of either protocol, whole, now and then with a wrong checksum.
fn packet() -> impl Strategy<Value = (FrameKind, Vec<u8>)> {
    let data = || prop::collection::vec(any::<u8>(), 1..=125);
    let damage = || prop_oneof![4 => Just(0_u8), 1 => any::<u8>()];
    let stock =
        (0..=0xFE_u8, any::<u8>(), data(), damage()).prop_map(|(id, code, parameters, damage)| {
            let frame = protocol1::Frame {
                id,
                code,
                parameters: &parameters,
            };
            (Firmware::Stock, frame.encode::<259>().unwrap(), damage)
        });
    let morpheus = (any::<u8>(), any::<u8>(), data(), damage()).prop_map(
        |(destination, source, data, damage)| {
            let frame = morpheus::Frame {
                destination,
                source,
                data: &data,
            };
            (Firmware::Morpheus, frame.encode().unwrap(), damage)
        },
    );
    prop_oneof![stock, morpheus].prop_map(|(firmware, mut bytes, damage)| {
        *bytes.last_mut().unwrap() ^= damage;
        (FrameKind::Packet(firmware), bytes.to_vec())
    })
}

/// Whether these bytes have the length in their own header.
fn is_whole(kind: FrameKind, bytes: &[u8]) -> bool {
    match (kind, bytes) {
        (FrameKind::Packet(Firmware::Stock), [0xFF, 0xFF, id, length, ..]) => {
            *id != 0xFF && bytes.len() == usize::from(*length) + 4
        }
        (FrameKind::Packet(Firmware::Morpheus), [0xAA, length, ..]) => {
            bytes.len() == usize::from(*length) + 3
        }
        (FrameKind::Packet(Firmware::XSeries), [0xFF, 0xFF, 0xFD, 0, _, low, high, ..]) => {
            bytes.len() == usize::from(u16::from_le_bytes([*low, *high])) + 7
        }
        (FrameKind::Packet(_), _) => false,
        (FrameKind::Raw, _) => true,
    }
}

proptest! {
    /// However packets are cut up, and however often the clock is looked at,
    /// exactly they come out.
    #[test]
    fn packets_come_out_whole(
        packets in prop::collection::vec(packet(), 1..8),
        gaps_us in prop::collection::vec(
            prop_oneof![20 => 0..50_u64, 1 => 0..HALF_PACKET_US],
            1..50,
        ),
    ) {
        let mut framer = Framer::new();
        let mut now_us = 0;
        let mut gaps_us = gaps_us.iter().cycle();
        let mut found = Found::new();
        for byte in packets.iter().flat_map(|(_, bytes)| bytes) {
            now_us += gaps_us.next().unwrap();
            prop_assert_eq!(framer.expire(now_us), None);
            if let Some(kind) = framer.push(*byte, now_us) {
                found.push((kind, framer.bytes().to_vec()));
            }
        }
        prop_assert_eq!(found, packets);
        prop_assert_eq!(framer.truncated(), 0);
        prop_assert_eq!(framer.wake_at_us(), None);
    }

    /// Whatever comes, every byte is handed out once and in order, or dropped
    /// at a time-out with the half packet it belongs to.
    #[test]
    fn nothing_is_lost_or_made_up(
        chunks in prop::collection::vec(
            prop::collection::vec(
                prop_oneof![
                    3 => Just(0xFF_u8), 1 => Just(0xAA), 1 => Just(0xFD), 3 => 0..8_u8, 1 => any::<u8>()
                ],
                0..400,
            ),
            1..4,
        ),
    ) {
        let mut framer = Framer::new();
        let mut now_us = 0;
        for chunk in chunks {
            let halves = framer.truncated();
            let mut found = push_all(&mut framer, &chunk, &mut now_us);
            found.extend(drain(&mut framer, &mut now_us));
            for (kind, bytes) in &found {
                prop_assert!(is_whole(*kind, bytes), "{kind:?} {bytes:x?}");
            }
            let out: Vec<u8> = found.into_iter().flat_map(|(_, bytes)| bytes).collect();
            let dropped = chunk.strip_prefix(out.as_slice()).unwrap();
            prop_assert_eq!(framer.truncated() - halves, u32::from(!dropped.is_empty()));
            prop_assert!(dropped.is_empty() || matches!(dropped[0], 0xAA | 0xFF));
        }
    }

    /// Half a packet is dropped and costs none of those that follow.
    #[test]
    fn half_a_packet_goes_nowhere(
        (_, half) in packet(),
        cut: prop::sample::Index,
        whole in packet(),
        is_looked_at: bool,
    ) {
        let cut = 1 + cut.index(half.len() - 1);
        let mut framer = Framer::new();
        let mut now_us = 0;
        prop_assert_eq!(push_all(&mut framer, &half[..cut], &mut now_us), vec![]);
        now_us += HALF_PACKET_US;
        if is_looked_at {
            prop_assert_eq!(framer.expire(now_us), None);
        }
        prop_assert_eq!(push_all(&mut framer, &whole.1, &mut now_us), vec![whole]);
        prop_assert_eq!(framer.truncated(), 1);
    }

    /// Garbage swallows no more than a longest packet's worth of packets.
    #[test]
    fn packets_are_found_again_after_garbage(
        garbage in prop::collection::vec(any::<u8>(), 0..300),
    ) {
        let ping = [0xFF, 0xFF, 1, 2, 1, 0xFB];
        let mut framer = Framer::new();
        let mut now_us = 0;
        push_all(&mut framer, &garbage, &mut now_us);
        let stream = ping.repeat(CAPACITY / ping.len() + 2);
        let found = push_all(&mut framer, &stream, &mut now_us);
        let (kind, bytes) = found.last().unwrap();
        prop_assert_eq!((*kind, bytes.as_slice()), (FrameKind::Packet(Firmware::Stock), &ping[..]));
    }
}

#[test]
fn a_flush_is_raw_and_in_one_piece() {
    let stop = [0xAA, 6, 0xFF, 0xFE, 3, 0x10, 0xE8, 3, 0xF8];
    let flush = [0xFF; 210];
    let mut framer = Framer::new();
    let mut now_us = 0;
    let mut found = push_all(&mut framer, &flush, &mut now_us);
    assert_eq!(found, []);
    // What follows ends it, or a time-out does.
    found = push_all(&mut framer, &stop, &mut now_us);
    let morpheus = FrameKind::Packet(Firmware::Morpheus);
    assert_eq!(
        found,
        [(FrameKind::Raw, flush.to_vec()), (morpheus, stop.to_vec())]
    );
    assert_eq!(push_all(&mut framer, &flush, &mut now_us), []);
    assert_eq!(
        drain(&mut framer, &mut now_us),
        [(FrameKind::Raw, flush.to_vec())]
    );
    assert_eq!(framer.truncated(), 0);
    // Bytes of a half packet that look like a flush are none.
    let half = [0xFF, 0xFF, 1, 9, 3, 30, 0xFF, 0xFF, 0xFF];
    assert_eq!(push_all(&mut framer, &half, &mut now_us), []);
    assert_eq!(drain(&mut framer, &mut now_us), []);
    assert_eq!(framer.truncated(), 1);
}

#[test]
fn packets_of_protocol_2_are_found_and_text_is_raw() {
    // PING, from its documentation.
    let ping2 = [0xFF, 0xFF, 0xFD, 0, 1, 3, 0, 1, 0x19, 0x4E];
    let mut framer = Framer::new();
    let mut now_us = 0;
    let found = push_all(&mut framer, &ping2, &mut now_us);
    let ping = (FrameKind::Packet(Firmware::XSeries), ping2.to_vec());
    assert_eq!(found, [ping]);
    // Text is handed out when it pauses.
    assert_eq!(push_all(&mut framer, b"AT+GMR\r\n", &mut now_us), []);
    assert_eq!(framer.expire(now_us + RAW_QUIET_US - 1), None);
    let found = drain(&mut framer, &mut now_us);
    assert_eq!(found, [(FrameKind::Raw, b"AT+GMR\r\n".to_vec())]);
}

#[test]
fn packets_that_deafen_are_kept_whole_to_be_refused() {
    let mut deadly = vec![0xAA, 200, 1, 0xFE];
    deadly.resize(203, 0);
    let mut framer = Framer::new();
    let found = push_all(&mut framer, &deadly, &mut 0);
    assert_eq!(found, [(FrameKind::Packet(Firmware::Morpheus), deadly)]);
}
