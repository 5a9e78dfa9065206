//! Single-producer single-consumer queues with a length that is part of the type.
//!
//! The ends of heapless store the length of their queue, so that each use
//! divides by it, with a possible panic for a length of zero. Here the length is
//! a constant at each use: for a power of two the division
//! becomes a mask, and no panic is reachable.
//!
//! Each end counts its operations, so that a third party can detect
//! new elements without holding an end ([`Count`]).

use core::sync::atomic::{AtomicU32, Ordering};
use heapless::spsc::{Consumer, Producer, Queue};

/// A queue of up to `N - 1` items.
pub(super) struct Channel<T, const N: usize> {
    queue: Queue<T, N>,
    sent: Count,
    received: Count,
}

/// Number of items that have passed one end, modulo 2³². That end alone writes it, so that
/// counting is a load and a store.
#[derive(Default)]
pub(super) struct Count(AtomicU32);

/// The queue is full.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Full;

/// The sending end.
pub(super) struct Sender<'a, T, const N: usize> {
    queue: Producer<'a, T>,
    sent: &'a Count,
}

/// The receiving end.
pub(super) struct Receiver<'a, T, const N: usize> {
    queue: Consumer<'a, T>,
    received: &'a Count,
}

impl Count {
    pub(super) fn get(&self) -> u32 {
        self.0.load(Ordering::Relaxed)
    }

    fn add_one(&self) {
        self.0.store(self.get().wrapping_add(1), Ordering::Relaxed);
    }
}

impl<T, const N: usize> Default for Channel<T, N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T, const N: usize> Channel<T, N> {
    /// An empty queue.
    pub(super) const fn new() -> Self {
        Self {
            queue: Queue::new(),
            sent: Count(AtomicU32::new(0)),
            received: Count(AtomicU32::new(0)),
        }
    }

    /// Both ends.
    pub(super) fn split(&mut self) -> (Sender<'_, T, N>, Receiver<'_, T, N>) {
        let Self {
            queue,
            sent,
            received,
        } = self;
        let (producer, consumer) = queue.split();
        let sender = Sender {
            queue: producer,
            sent,
        };
        let receiver = Receiver {
            queue: consumer,
            received,
        };
        (sender, receiver)
    }
}

impl<'a, T, const N: usize> Sender<'a, T, N> {
    /// Appends `item`.
    ///
    /// # Errors
    /// [`Full`] if there is no room. `item` is dropped then: to return it, the compiler
    /// copies it to the stack and back.
    pub(super) fn enqueue(&mut self, item: T) -> Result<(), Full> {
        if self.room() == 0 {
            return Err(Full);
        }
        // There is room.
        let _ = self.queue.enqueue(item);
        self.sent.add_one();
        Ok(())
    }

    /// Count of items that this end has appended.
    pub(super) fn sent(&self) -> &'a Count {
        self.sent
    }

    /// Number of items that fit.
    pub(super) fn room(&self) -> usize {
        if self.is_known() {
            self.queue.capacity() - self.queue.len()
        } else {
            0
        }
    }

    /// Always true; tells the compiler the length of the queue.
    fn is_known(&self) -> bool {
        self.queue.capacity() + 1 == N
    }
}

impl<'a, T, const N: usize> Receiver<'a, T, N> {
    /// Takes the oldest item.
    pub(super) fn dequeue(&mut self) -> Option<T> {
        // As for `Sender::is_known`.
        if self.queue.capacity() + 1 != N {
            return None;
        }
        let item = self.queue.dequeue()?;
        self.received.add_one();
        Some(item)
    }

    /// Whether there is no item.
    pub(super) fn is_empty(&self) -> bool {
        !self.queue.ready()
    }

    /// Takes the oldest item, which `read` gets in place.
    pub(super) fn take<R>(&mut self, read: impl FnOnce(&T) -> R) -> Option<R> {
        if self.queue.capacity() + 1 != N {
            return None;
        }
        let result = read(self.queue.peek()?);
        self.queue.dequeue();
        self.received.add_one();
        Some(result)
    }

    /// Count of items that this end has taken.
    pub(super) fn received(&self) -> &'a Count {
        self.received
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_queue_refuses_and_order_is_kept() {
        let mut channel = Channel::<_, 4>::new();
        let (mut sender, mut receiver) = channel.split();
        // Three at a time through four cells: every alignment is met.
        for round in 0..10 {
            assert_eq!(sender.room(), 3);
            for i in 0..3 {
                assert_eq!(sender.enqueue(round + i), Ok(()));
            }
            assert_eq!((sender.room(), sender.enqueue(99)), (0, Err(Full)));
            let taken = [(); 4].map(|()| receiver.dequeue());
            let expected = [Some(round), Some(round + 1), Some(round + 2), None];
            assert_eq!(taken, expected);
        }
        // What was refused, or was not there, does not count.
        assert_eq!((sender.sent().get(), receiver.received().get()), (30, 30));
    }

    #[test]
    fn two_threads_lose_nothing() {
        extern crate std;
        // Miri, which looks at every access, is slow.
        const COUNT: u32 = if cfg!(miri) { 1_000 } else { 100_000 };
        let mut channel = Channel::<_, 8>::new();
        let (mut sender, mut receiver) = channel.split();
        std::thread::scope(|scope| {
            scope.spawn(move || {
                for i in 0..COUNT {
                    while sender.enqueue([i, !i]).is_err() {
                        std::thread::yield_now();
                    }
                }
            });
            for i in 0..COUNT {
                let item = loop {
                    match receiver.dequeue() {
                        Some(item) => break item,
                        None => std::thread::yield_now(),
                    }
                };
                assert_eq!(item, [i, !i]);
            }
        });
    }
}
