//! Input of the transparent port: requests, commands that must not reach the servos, and
//! noise.

use armbridge_servo::morpheus::Frame;
use armbridge_tests::random::Random;

/// Its address on a Morpheus bus.
pub(super) const ADDRESS: u8 = 0x21;

/// Something, or mostly nothing.
pub(super) fn says(random: &mut Random) -> Option<Vec<u8>> {
    let request = |destination, data: &[u8]| {
        let frame = Frame {
            destination,
            source: ADDRESS,
            data,
        };
        frame.encode::<64>().unwrap().to_vec()
    };
    let bytes = match random.below(20) {
        0 => request(1, &[1]),
        1 => request(2, &[2, random.byte() % 18, 1 + random.byte() % 4]),
        2 => request(0xFF, &[7]),
        3 => request(1, &[3, 0x10, 0, 0]),
        4 => request(0xFF, &[0x83, 0x10, 2, 1, 0, 0]),
        5 => vec![0xFF, 0xFF, 1, 2, 1, 0xFB],
        6 => random.bytes(40, &[0xAA, 0xFF, 3, 1, 2]),
        _ => return None,
    };
    Some(bytes)
}
