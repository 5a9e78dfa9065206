//! Frames written independently of the encoder under test, whatever is inside.

/// An intact frame of `body`, with its terminator.
pub fn frame(version: u8, direction: u8, sequence: u16, body: &[u8]) -> Vec<u8> {
    let mut plain = vec![version, direction];
    plain.extend(sequence.to_le_bytes());
    plain.extend(body);
    plain.extend(crc32(&plain).to_le_bytes());
    let mut coded = cobs(&plain);
    coded.push(0);
    coded
}

/// CRC-32 of IEEE 802.3, bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
            (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg())
        })
    })
}

/// Runs without a zero, each behind the distance to the next.
fn cobs(plain: &[u8]) -> Vec<u8> {
    let mut coded = Vec::new();
    let runs: Vec<&[u8]> = plain.split(|byte| *byte == 0).collect();
    for run in runs {
        let mut pieces = run.chunks(254).peekable();
        if run.is_empty() {
            coded.push(1);
        }
        while let Some(piece) = pieces.next() {
            coded.push(piece.len() as u8 + 1);
            coded.extend(piece);
            // A full piece stands for no zero; a run that ends with it needs
            // one more of length 0.
            if piece.len() == 254 && pieces.peek().is_none() {
                coded.push(1);
            }
        }
    }
    coded
}

#[test]
fn the_check_value_of_the_crc() {
    assert_eq!(crc32(b"123456789"), 0xCBF4_3926);
}
