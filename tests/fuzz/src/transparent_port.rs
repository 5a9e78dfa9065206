//! The transparent port: a client's bytes into packets, and what becomes of
//! them while a control loop runs.

mod policy;

use armbridge_board::bridge::transparent_port::{FrameKind, Framer};
use armbridge_servo::morpheus::HEADER as MORPHEUS;
use armbridge_servo::protocol1::frame::HEADER as STOCK;
use armbridge_servo::{Firmware, morpheus, protocol1};

/// One byte at 1 Mbaud.
const BYTE_US: u64 = 10;
/// Longer than bytes wait that are no packet's, shorter than half a packet.
const QUIET_US: u64 = 3_000;
/// Bytes between two such pauses.
const QUIET_EVERY: usize = 5;
/// PING of servo 1 in either protocol.
const PINGS: [(Firmware, [u8; 6]); 2] = [
    (Firmware::Stock, [0xFF, 0xFF, 1, 2, 1, 0xFB]),
    (Firmware::Morpheus, [0xAA, 3, 1, 0xFE, 1, 0xF9]),
];

/// Feeds the framer, without and with pauses, has all packets judged, and counts
/// them.
///
/// # Panics
/// If bytes are lost, made up or cut where a packet is, if the framer is not
/// back in step after silence, or if the judge lets something pass that harms.
pub fn check(input: &[u8]) -> usize {
    let packets = Stream::new(input).run(None);
    Stream::new(input).run(Some(QUIET_EVERY));
    for (firmware, packet) in packets.iter().chain(&framed(input)) {
        policy::check(*firmware, packet);
    }
    packets.len()
}

/// Packets of either protocol of these bytes, so that no checksum has to be hit.
fn framed(input: &[u8]) -> Packets {
    let [first, second, data @ ..] = input else {
        return Vec::new();
    };
    let stock = protocol1::Frame {
        id: *first,
        code: *second,
        parameters: data,
    };
    let morpheus = morpheus::Frame {
        destination: *first,
        source: *second,
        data,
    };
    let packets = [
        (
            Firmware::Stock,
            stock
                .encode::<{ protocol1::frame::FRAME_MAX }>()
                .map(|b| b.to_vec()),
        ),
        (
            Firmware::Morpheus,
            morpheus
                .encode::<{ morpheus::frame::FRAME_MAX }>()
                .map(|b| b.to_vec()),
        ),
    ];
    packets
        .into_iter()
        .filter_map(|(firmware, bytes)| Some((firmware, bytes?)))
        .collect()
}

type Packets = Vec<(Firmware, Vec<u8>)>;

struct Stream<'a> {
    framer: Framer,
    now_us: u64,
    /// Bytes that the framer has not returned yet.
    rest: &'a [u8],
    input: &'a [u8],
    packets: Packets,
}

impl<'a> Stream<'a> {
    fn new(input: &'a [u8]) -> Self {
        Self {
            framer: Framer::new(),
            now_us: 0,
            rest: input,
            input,
            packets: Vec::new(),
        }
    }

    /// Pushes all, with a pause after every so many bytes; then silence, after
    /// which all has been handed out but half a packet.
    fn run(mut self, quiet_every: Option<usize>) -> Packets {
        let mut due: Option<(usize, Firmware)> = None;
        let mut half = None;
        for (at, byte) in self.input.iter().enumerate() {
            if quiet_every.is_some_and(|every| at % every == 0) {
                self.now_us += QUIET_US;
                let kind = self.framer.expire(self.now_us);
                self.take(kind);
            }
            // Nothing is held: a packet that begins here ends by its length field.
            due = due.filter(|(last, _)| *last >= at);
            if due.is_none() && self.framer.wake_at_us().is_none() {
                let (begun, len) = (&self.input[at..], header(&self.input[at..]));
                due = whole(begun).map(|(len, firmware)| (at + len - 1, firmware));
                half = len.filter(|(len, _)| *len > begun.len()).map(|_| begun);
            }
            self.now_us += BYTE_US;
            let kind = self.framer.push(*byte, self.now_us);
            if let Some((last, firmware)) = due {
                let expected = (at == last).then_some(FrameKind::Packet(firmware));
                assert_eq!(kind, expected, "at {at} of {:02x?}", self.input);
            }
            self.take(kind);
        }
        self.settle();
        assert!(
            half.is_none_or(|half| half == self.rest),
            "{:02x?}",
            self.input
        );
        let is_half = !self.rest.is_empty();
        assert_eq!(
            self.framer.truncated(),
            u32::from(is_half),
            "{:02x?}",
            self.input
        );
        self.is_in_step();
        self.packets
    }

    /// Takes what was handed out: the next bytes of the input, whole.
    fn take(&mut self, kind: Option<FrameKind>) {
        let Some(kind) = kind else { return };
        let bytes = self.framer.bytes();
        let rest = self.rest.strip_prefix(bytes);
        self.rest = rest.unwrap_or_else(|| panic!("{bytes:02x?} of {:02x?}", self.rest));
        assert!(!bytes.is_empty());
        if let FrameKind::Packet(firmware) = kind {
            assert_eq!(whole(bytes), Some((bytes.len(), firmware)), "{bytes:02x?}");
            self.packets.push((firmware, bytes.to_vec()));
        }
    }

    /// Silence, until nothing is waited for.
    fn settle(&mut self) {
        // Raw bytes, then half a packet.
        for _ in 0..3 {
            let Some(wake_us) = self.framer.wake_at_us() else {
                return;
            };
            self.now_us = self.now_us.max(wake_us);
            let kind = self.framer.expire(self.now_us);
            self.take(kind);
        }
        assert_eq!(self.framer.wake_at_us(), None);
    }

    /// The next packets are found at once.
    fn is_in_step(&mut self) {
        for (firmware, ping) in PINGS {
            for (left, byte) in (0..ping.len()).rev().zip(ping) {
                self.now_us += BYTE_US;
                let kind = self.framer.push(byte, self.now_us);
                let expected = (left == 0).then_some(FrameKind::Packet(firmware));
                assert_eq!(kind, expected, "after {:02x?}", self.input);
            }
            assert_eq!(self.framer.bytes(), ping);
        }
    }
}

/// Length of the packet that these bytes begin with, if all of it is there.
fn whole(bytes: &[u8]) -> Option<(usize, Firmware)> {
    header(bytes).filter(|(len, _)| bytes.len() >= *len)
}

/// Length of the packet that these bytes begin with, by its header.
fn header(bytes: &[u8]) -> Option<(usize, Firmware)> {
    Some(match *bytes {
        [MORPHEUS, length @ 3..=200, ..] => (usize::from(length) + 3, Firmware::Morpheus),
        [STOCK, STOCK, 0..=0xFE, length @ 2..=255, ..] => {
            (usize::from(length) + 4, Firmware::Stock)
        }
        [STOCK, STOCK, 0xFD, 0, _, low, high, ..] => {
            let length = usize::from(u16::from_le_bytes([low, high]));
            let is_kept = (3..=253).contains(&length);
            return is_kept.then_some((length + 7, Firmware::XSeries));
        }
        _ => return None,
    })
}
