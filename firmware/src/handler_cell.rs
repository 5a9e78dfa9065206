//! A cell for the state of an interrupt handler.
//!
//! A handler has no arguments, so its state is in a `static`: [`HandlerCell::put`] fills it
//! at boot, and [`HandlerCell::with`] lends it to one caller at a time. It is a lock without
//! waiting: a caller that finds it taken is refused. A handler that is the only caller
//! is never refused, since no interrupt preempts itself. Interrupts stay enabled
//! meanwhile, unlike in a critical section.

use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicU8, Ordering};

/// Nothing has been put in.
const EMPTY: u8 = 0;
/// Full, and not lent.
const FREE: u8 = 1;
/// Being filled or lent.
const TAKEN: u8 = 2;

/// See the [module](self).
pub struct HandlerCell<T> {
    state: AtomicU8,
    value: UnsafeCell<Option<T>>,
}

// SAFETY: the value is touched only by the context that has changed `state` to `TAKEN` from
// another value, in one atomic step; so by one at a time. It may be put in by one context and
// used by another, for which it must be `Send`.
unsafe impl<T: Send> Sync for HandlerCell<T> {}

impl<T> HandlerCell<T> {
    /// An empty cell.
    pub const fn new() -> Self {
        Self {
            state: AtomicU8::new(EMPTY),
            value: UnsafeCell::new(None),
        }
    }

    /// Fills the cell; `value` is dropped, and nothing else happens, if it is full.
    pub fn put(&self, value: T) {
        if self.take(EMPTY) {
            // SAFETY: `state` was changed to `TAKEN` here, so that no other context
            // touches the value before it is changed back.
            unsafe { *self.value.get() = Some(value) };
            self.state.store(FREE, Ordering::Release);
        }
    }

    /// Lends the value to `use_it`; `None` if the cell is empty or lent already.
    pub fn with<R>(&self, use_it: impl FnOnce(&mut T) -> R) -> Option<R> {
        if !self.take(FREE) {
            return None;
        }
        // SAFETY: as in `put`. The reference ends with `use_it`, before the cell is free. A
        // panic inside leaves the cell taken: refused for ever, which is sound.
        let result = unsafe { (*self.value.get()).as_mut() }.map(use_it);
        self.state.store(FREE, Ordering::Release);
        result
    }

    /// Changes the state from `from` to `TAKEN`; whether it was `from`.
    fn take(&self, from: u8) -> bool {
        // Acquire: what the last holder wrote is seen.
        let change = self
            .state
            .compare_exchange(from, TAKEN, Ordering::Acquire, Ordering::Relaxed);
        change.is_ok()
    }
}

impl<T> Default for HandlerCell<T> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;

    #[test]
    fn it_is_lent_once_at_a_time_and_filled_once() {
        let cell = HandlerCell::new();
        assert_eq!(cell.with(|value: &mut u32| *value), None);
        cell.put(1);
        cell.put(2);
        let inner = cell.with(|value| {
            *value += 10;
            cell.with(|value| *value)
        });
        assert_eq!(inner, Some(None));
        assert_eq!(cell.with(|value| *value), Some(11));
    }

    #[test]
    fn two_threads_never_have_it_both() {
        const COUNT: u32 = if cfg!(miri) { 200 } else { 20_000 };
        let cell = HandlerCell::new();
        cell.put(0);
        let add = || {
            for _ in 0..COUNT {
                while cell.with(|value: &mut u32| *value += 1).is_none() {
                    std::thread::yield_now();
                }
            }
        };
        std::thread::scope(|scope| {
            scope.spawn(add);
            scope.spawn(add);
        });
        assert_eq!(cell.with(|value| *value), Some(2 * COUNT));
    }
}
