//! Single-producer single-consumer queues whose ends know how long they are.
//!
//! heapless's ends keep the length of their queue as a number, so that each use
//! divides by it, with a panic in wait for a length of zero. Here the length is
//! part of the type and told again at each use: of a power of two the division
//! becomes a mask, and no panic is left to be reached.

use heapless::spsc::{Consumer, Producer, Queue};

/// The end that things are put into.
pub(super) struct Sender<'a, T, const N: usize>(Producer<'a, T>);

/// The end that things are taken from.
pub(super) struct Receiver<'a, T, const N: usize>(Consumer<'a, T>);

/// Both ends of a queue, which holds up to `N - 1`.
pub(super) fn split<T, const N: usize>(
    queue: &mut Queue<T, N>,
) -> (Sender<'_, T, N>, Receiver<'_, T, N>) {
    let (producer, consumer) = queue.split();
    (Sender(producer), Receiver(consumer))
}

impl<T, const N: usize> Sender<'_, T, N> {
    /// Appends `item`, or gives it back if there is no room.
    pub(super) fn enqueue(&mut self, item: T) -> Result<(), T> {
        if self.is_known() {
            self.0.enqueue(item)
        } else {
            Err(item)
        }
    }

    /// How many more there is room for.
    pub(super) fn room(&self) -> usize {
        if self.is_known() {
            self.0.capacity() - self.0.len()
        } else {
            0
        }
    }

    /// Always; the compiler knows the length of the queue from here on.
    fn is_known(&self) -> bool {
        self.0.capacity() + 1 == N
    }
}

impl<T, const N: usize> Receiver<'_, T, N> {
    /// Takes the oldest.
    pub(super) fn dequeue(&mut self) -> Option<T> {
        // As for `Sender::is_known`.
        if self.0.capacity() + 1 == N {
            self.0.dequeue()
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_queue_refuses_and_order_is_kept() {
        let mut queue = Queue::<_, 4>::new();
        let (mut sender, mut receiver) = split(&mut queue);
        // Three at a time through four cells: every alignment is met.
        for round in 0..10 {
            assert_eq!(sender.room(), 3);
            for i in 0..3 {
                assert_eq!(sender.enqueue(round + i), Ok(()));
            }
            assert_eq!((sender.room(), sender.enqueue(99)), (0, Err(99)));
            let taken = [(); 4].map(|()| receiver.dequeue());
            let expected = [Some(round), Some(round + 1), Some(round + 2), None];
            assert_eq!(taken, expected);
        }
    }

    #[test]
    fn two_threads_lose_nothing() {
        extern crate std;
        // Miri, which looks at every access, is slow.
        const COUNT: u32 = if cfg!(miri) { 1_000 } else { 100_000 };
        let mut queue = Queue::<_, 8>::new();
        let (mut sender, mut receiver) = split(&mut queue);
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
