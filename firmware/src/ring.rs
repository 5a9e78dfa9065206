//! A byte queue from one context to another, without locks or `unsafe`.
//!
//! Lamport's ring: one side only pushes, the other only pops, each advances a
//! counter that the other only reads. A violation of that rule loses or repeats
//! bytes, without undefined behaviour: every cell is atomic.
//!
//! The counters run freely, modulo 2³²; `N` must be a power of two for them to wrap
//! in step.

use core::sync::atomic::{AtomicU8, AtomicU32, Ordering};

/// A queue of up to `N` bytes.
#[derive(Debug)]
pub struct ByteRing<const N: usize> {
    bytes: [AtomicU8; N],
    pushed: AtomicU32,
    popped: AtomicU32,
}

impl<const N: usize> ByteRing<N> {
    /// An empty queue.
    pub const fn new() -> Self {
        const { assert!(N.is_power_of_two() && N <= 1 << 16) };
        Self {
            bytes: [const { AtomicU8::new(0) }; N],
            pushed: AtomicU32::new(0),
            popped: AtomicU32::new(0),
        }
    }

    /// Adds a byte; `false`, and no byte added, if the queue is full.
    pub fn push(&self, byte: u8) -> bool {
        let pushed = self.pushed.load(Ordering::Relaxed);
        // Acquire: the cell to be overwritten has been read.
        if pushed.wrapping_sub(self.popped.load(Ordering::Acquire)) as usize >= N {
            return false;
        }
        if let Some(cell) = self.bytes.get(pushed as usize % N) {
            cell.store(byte, Ordering::Relaxed);
        }
        // Release: a reader that sees the count sees the byte.
        self.pushed.store(pushed.wrapping_add(1), Ordering::Release);
        true
    }

    /// Takes the oldest byte.
    pub fn pop(&self) -> Option<u8> {
        let popped = self.popped.load(Ordering::Relaxed);
        if self.pushed.load(Ordering::Acquire) == popped {
            return None;
        }
        let byte = self.bytes.get(popped as usize % N)?.load(Ordering::Relaxed);
        self.popped.store(popped.wrapping_add(1), Ordering::Release);
        Some(byte)
    }

    /// Number of bytes to pop. Exact on either side; for a third party both counters may
    /// change between the two readings.
    pub fn len(&self) -> usize {
        let popped = self.popped.load(Ordering::Acquire);
        self.pushed.load(Ordering::Acquire).wrapping_sub(popped) as usize
    }

    /// Whether there is nothing to pop.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether the next push would fail.
    pub fn is_full(&self) -> bool {
        self.len() >= N
    }
}

impl<const N: usize> Default for ByteRing<N> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_is_kept_and_a_full_ring_refuses() {
        let ring = ByteRing::<4>::new();
        assert_eq!(ring.pop(), None);
        // Three at a time through four cells: every alignment is met.
        for round in 0u8..50 {
            for i in 0..3 {
                assert!(ring.push(round.wrapping_mul(3).wrapping_add(i)));
            }
            for i in 0..3 {
                assert_eq!(ring.pop(), Some(round.wrapping_mul(3).wrapping_add(i)));
            }
        }
        assert!(ring.is_empty());
        assert!((0..4).all(|byte| ring.push(byte)));
        assert!(ring.is_full() && ring.len() == 4 && !ring.push(9));
        assert_eq!(
            [0; 5].map(|_| ring.pop()),
            [Some(0), Some(1), Some(2), Some(3), None]
        );
    }

    #[test]
    fn two_threads_lose_nothing() {
        extern crate std;
        // Miri, which looks at every access, is slow.
        const COUNT: u32 = if cfg!(miri) { 1_000 } else { 100_000 };
        let ring = ByteRing::<8>::new();
        std::thread::scope(|scope| {
            scope.spawn(|| {
                for i in 0..COUNT {
                    while !ring.push(i as u8) {
                        std::thread::yield_now();
                    }
                }
            });
            for i in 0..COUNT {
                let byte = loop {
                    match ring.pop() {
                        Some(byte) => break byte,
                        None => std::thread::yield_now(),
                    }
                };
                assert_eq!(byte, i as u8);
            }
        });
    }
}
