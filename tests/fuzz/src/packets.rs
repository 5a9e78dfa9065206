//! Properties of every parser of packets.

/// Result of a byte.
pub(crate) enum Found {
    /// The last of an intact packet: these bytes, encoded again.
    Intact(Vec<u8>),
    /// The last of what was no packet after all.
    Damaged,
    /// One that no packet has there.
    Refused,
}

/// A parser of packets.
pub(crate) trait Packets {
    /// Takes a byte.
    fn push(&mut self, byte: u8) -> Option<Found>;
    /// Bytes of a packet that has begun.
    fn bytes_held(&self) -> usize;
    /// Bytes of the longest packet.
    fn longest(&self) -> usize;
    /// Length of the intact packet that these bytes begin with, if they do,
    /// superfluous headers before it included. Decided on the whole, not byte by
    /// byte.
    fn intact(&self, bytes: &[u8]) -> Option<usize>;
}

/// Feeds any bytes, and counts the packets in them; then as many of `neutral`, which begins
/// no packet, as the longest packet has; then `packet`, which must be found.
///
/// # Panics
/// If a packet is found in other bytes than its own, if one is overlooked that
/// begins where nothing was held or where another was broken off, if more is
/// held than a packet, or if the neutral bytes do not bring the parser back into
/// step.
pub(crate) fn feed<P: Packets>(mut parser: P, input: &[u8], neutral: u8, packet: &[u8]) -> usize {
    // Where the last packet ended, and the last byte of the one now due.
    let mut begin = 0;
    let mut due: Option<usize> = None;
    let mut packets = 0;
    for (at, byte) in input.iter().enumerate() {
        due = due.filter(|due| *due >= at);
        if due.is_none() && parser.bytes_held() == 0 {
            due = intact_from(&parser, input, at);
        }
        let found = parser.push(*byte);
        match due {
            Some(due) if due > at => assert!(found.is_none(), "at {at} of {input:02x?}"),
            Some(_) => assert!(
                matches!(found, Some(Found::Intact(_))),
                "at {at} of {input:02x?}"
            ),
            None => {}
        }
        match found {
            Some(Found::Intact(bytes)) => {
                assert!(input[begin..=at].ends_with(&bytes), "{bytes:02x?}");
                begin = at + 1;
                packets += 1;
            }
            Some(Found::Damaged) => begin = at + 1,
            // The refused byte may begin the next packet.
            Some(Found::Refused) => due = intact_from(&parser, input, at),
            None => {}
        }
        assert!(parser.bytes_held() < parser.longest());
    }
    for _ in 0..parser.longest() {
        let _ = parser.push(neutral);
    }
    assert_eq!(parser.bytes_held(), 0, "after {input:02x?}");
    let (last, before) = packet.split_last().expect("a packet has bytes");
    for byte in before {
        assert!(parser.push(*byte).is_none(), "after {input:02x?}");
    }
    let Some(Found::Intact(found)) = parser.push(*last) else {
        panic!("nothing found after {input:02x?}");
    };
    assert_eq!(found, packet);
    packets
}

/// The last byte of the intact packet that begins here, if one does.
fn intact_from<P: Packets>(parser: &P, input: &[u8], at: usize) -> Option<usize> {
    parser.intact(&input[at..]).map(|len| at + len - 1)
}
