//! High-water mark of the stack.
//!
//! `paint` fills the free part with a pattern at boot; words that still have it have
//! never been used. A call that leaves a large buffer unwritten at its deepest
//! point hides that part, so this is the observed use, not the largest possible.

use armbridge_link::message::Stack;

/// Pattern that is unlikely in memory: no small number, no address of this program.
pub const PAINT: u32 = 0xC5C5_A3A3;

/// Interval of [`Watch`] in µs: it reads the whole free part, 6 of the 18 kB.
const INTERVAL_US: u64 = 1_000_000;

/// Bytes of a stack, given from its end upwards, that are no longer painted.
pub fn used(words: impl ExactSizeIterator<Item = u32>) -> Stack {
    let size = words.len();
    let free = words.take_while(|word| *word == PAINT).count();
    Stack {
        used: 4 * (size - free) as u32,
        size: 4 * size as u32,
    }
}

/// Periodic measurement of the stack.
#[derive(Debug, Default)]
pub struct Watch {
    next_us: u64,
    used: u32,
}

impl Watch {
    /// Measures the use of the stack; `Some` if it exceeds the last report.
    pub fn sample(&mut self, now_us: u64, measure: impl FnOnce() -> Stack) -> Option<Stack> {
        if now_us < self.next_us {
            return None;
        }
        self.next_us = now_us + INTERVAL_US;
        let stack = measure();
        let has_grown = stack.used > self.used;
        self.used = self.used.max(stack.used);
        has_grown.then_some(stack)
    }
}

#[cfg(feature = "board")]
pub use on_board::{bounds, measure, paint};

#[cfg(feature = "board")]
mod on_board {
    use super::{PAINT, Stack, used};
    use core::ops::Range;
    use core::ptr;

    unsafe extern "C" {
        /// End of the stack, which grows downwards.
        static _stack_end: u32;
        /// Beginning of the stack: the first word above it.
        static _stack_start: u32;
    }

    /// Bytes below the stack pointer that [`paint`] does not overwrite: more than its
    /// own variables need.
    const MARGIN: usize = 256;

    /// Address range of the stack.
    pub fn bounds() -> Range<u32> {
        (&raw const _stack_end) as u32..(&raw const _stack_start) as u32
    }

    /// Paints the free part: 3 ms at 16 MHz. Call before any interrupt is
    /// unmasked.
    #[inline(never)]
    pub fn paint() {
        let mut word = (&raw const _stack_end).cast_mut();
        let end = cortex_m::register::msp::read() as usize - MARGIN;
        while (word as usize) < end {
            // SAFETY: from the stack's end to `MARGIN` below its pointer nothing
            // is in use: no caller has its variables there, this function's fit
            // into the margin, and no interrupt comes.
            unsafe { ptr::write_volatile(word, PAINT) };
            word = word.wrapping_add(1);
        }
    }

    /// Measures the high-water mark.
    pub fn measure() -> Stack {
        let begin = &raw const _stack_end;
        let words = bounds().len() / 4;
        used((0..words).map(|index| {
            // SAFETY: this is within the stack's memory, aligned, and volatile:
            // the value is only compared with the pattern.
            unsafe { ptr::read_volatile(begin.wrapping_add(index)) }
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_longer_painted_was_used() {
        let mut words = [PAINT; 64];
        words[60..].fill(0);
        assert_eq!(
            used(words.into_iter()),
            Stack {
                used: 16,
                size: 256
            }
        );
        // Below the deepest word all is painted, above it anything may be.
        words[20] = 1;
        assert_eq!(used(words.into_iter()).used, 176);
        assert_eq!(used([0; 2].into_iter()), Stack { used: 8, size: 8 });
    }

    #[test]
    fn only_growth_is_told_and_rarely() {
        let mut watch = Watch::default();
        let stack = |used| Stack { used, size: 256 };
        assert_eq!(watch.sample(5, || stack(80)), Some(stack(80)));
        assert_eq!(watch.sample(900_000, || stack(120)), None);
        assert_eq!(watch.sample(1_100_000, || stack(120)), Some(stack(120)));
        assert_eq!(watch.sample(9_000_000, || stack(120)), None);
    }
}
