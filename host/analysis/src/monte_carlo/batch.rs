//! Parallel runs over seeds.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;

/// Calls `run` for every seed, on one thread per processor, and `done` on the calling
/// thread after each, with the number of finished runs. Results are in the order of the
/// seeds.
///
/// # Errors
///
/// The first error in the order of the seeds.
pub fn for_seeds<T: Send, E: Send>(
    seeds: &[u64],
    run: impl Fn(u64) -> Result<T, E> + Sync,
    mut done: impl FnMut(usize),
) -> Result<Vec<T>, E> {
    let threads = thread::available_parallelism().map_or(1, usize::from);
    let next = AtomicUsize::new(0);
    let (sender, receiver) = mpsc::channel();
    let mut results: Vec<(usize, Result<T, E>)> = Vec::new();
    thread::scope(|scope| {
        for _ in 0..threads.min(seeds.len()) {
            let (next, run, sender) = (&next, &run, sender.clone());
            scope.spawn(move || {
                while let Some((index, seed)) = {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    seeds.get(index).map(|seed| (index, *seed))
                } {
                    // The receiver outlives this thread.
                    let _ = sender.send((index, run(seed)));
                }
            });
        }
        drop(sender);
        for result in receiver {
            results.push(result);
            done(results.len());
        }
    });
    results.sort_by_key(|(index, _)| *index);
    results.into_iter().map(|(_, result)| result).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_seed_once_and_in_order() {
        let seeds: Vec<u64> = (1..=50).rev().collect();
        let mut last = 0;
        let squares = for_seeds(&seeds, |seed| Ok::<_, u64>(seed * seed), |n| last = n).unwrap();
        assert!(
            squares
                .iter()
                .zip(&seeds)
                .all(|(s, seed)| *s == seed * seed)
        );
        assert_eq!((squares.len(), last), (50, 50));
        let odd = |seed| if seed % 2 == 1 { Err(seed) } else { Ok(()) };
        assert_eq!(for_seeds(&seeds, odd, |_| ()), Err(49));
    }
}
