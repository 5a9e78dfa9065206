//! COBS in place: a frame without zeros.

/// Longest frame, code and terminator included: a longer one may need more codes than it has
/// zeros, since a distance of 255 would stand for 254 bytes without a zero after them.
pub(super) const LONGEST: usize = 255;

/// Encodes: replaces each zero by the distance to the next one, and the last by
/// the distance to the end; returns the distance from the byte before `plain` to the
/// first. One pass from the end backwards, in which each distance is known when its
/// place is reached.
#[inline]
pub(super) fn stuff(plain: &mut [u8]) -> u8 {
    let mut distance = 1;
    // Four at a time: most have no zero.
    let (begin, words) = plain.as_rchunks_mut::<4>();
    for word in words.iter_mut().rev() {
        if has_zero(u32::from_le_bytes(*word)) {
            distance = stuff_bytes(word, distance);
        } else {
            distance += 4;
        }
    }
    stuff_bytes(begin, distance)
}

/// Whether one of the four bytes is zero: only below a zero byte, or in it, a subtraction
/// of 1 from each borrows into a highest bit that was not set.
const fn has_zero(word: u32) -> bool {
    word.wrapping_sub(0x0101_0101) & !word & 0x8080_8080 != 0
}

/// [`stuff`] of a part, with the distance from behind it; returns that from before it.
fn stuff_bytes(part: &mut [u8], mut distance: u8) -> u8 {
    for byte in part.iter_mut().rev() {
        if *byte == 0 {
            *byte = distance;
            distance = 1;
        } else {
            distance += 1;
        }
    }
    distance
}

/// The reverse of [`stuff`], whose first code is the first byte of `frame`; no byte of
/// it is zero. `None` if the last code does not lead to the end.
pub(super) fn unstuff(frame: &mut [u8]) -> Option<&[u8]> {
    let mut at = 0;
    while at < frame.len() {
        // The first code is no byte of the message.
        at += usize::from(core::mem::take(frame.get_mut(at)?));
    }
    frame.get(1..).filter(|_| at == frame.len())
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use proptest::collection::vec as vec_of;
    use proptest::prelude::*;
    use std::vec;
    use std::vec::Vec;

    proptest! {
        /// Both ways agree with the implementation that others use.
        #[test]
        fn cobs_is_what_it_is_elsewhere(plain in vec_of(prop_oneof![Just(0), any::<u8>()], 1..LONGEST - 1)) {
            let mut frame = vec![0; plain.len() + 1];
            frame[1..].copy_from_slice(&plain);
            frame[0] = stuff(&mut frame[1..]);
            let mut theirs = [0; LONGEST];
            let len = cobs::encode(&plain, &mut theirs);
            prop_assert_eq!(&frame, &theirs[..len]);
            prop_assert_eq!(unstuff(&mut frame), Some(plain.as_slice()));
        }

        /// Bytes that are no COBS, of any length, are damaged for both.
        #[test]
        fn garbage_is_garbage_elsewhere(mut frame in vec_of(1..=u8::MAX, 1..LONGEST)) {
            let mut theirs = cobs::DecoderState::default();
            frame.push(0);
            let results: Vec<_> = frame.iter().map(|byte| theirs.feed(*byte)).collect();
            frame.pop();
            let plain = unstuff(&mut frame).map(<[u8]>::to_vec);
            let ends = matches!(results.last(), Some(Ok(cobs::DecodeResult::DataComplete)));
            prop_assert_eq!(plain.is_some(), ends);
        }
    }
}
