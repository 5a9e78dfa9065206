//! Runs in parallel, on one thread per processor, which ctrl-C ends early.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;

use armbridge_client::ctrl_c;

/// Calls `run` for every item, on one thread per processor, and `done` on the calling
/// thread after each, with the number of finished runs. Results are in the order of the
/// items. After ctrl-C no run begins, and results are those of the finished ones.
///
/// # Errors
///
/// The first error in the order of the items.
pub fn for_each<I: Sync, T: Send, E: Send>(
    items: &[I],
    run: impl Fn(&I) -> Result<T, E> + Sync,
    mut done: impl FnMut(usize),
) -> Result<Vec<T>, E> {
    let threads = thread::available_parallelism().map_or(1, usize::from);
    let next = AtomicUsize::new(0);
    let (sender, receiver) = mpsc::channel();
    let mut results: Vec<(usize, Result<T, E>)> = Vec::new();
    thread::scope(|scope| {
        for _ in 0..threads.min(items.len()) {
            let (next, run, sender) = (&next, &run, sender.clone());
            scope.spawn(move || {
                while !ctrl_c::is_raised()
                    && let Some((index, item)) = {
                        let index = next.fetch_add(1, Ordering::Relaxed);
                        items.get(index).map(|item| (index, item))
                    }
                {
                    // The receiver outlives this thread.
                    let _ = sender.send((index, run(item)));
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

/// The same for every seed.
///
/// # Errors
///
/// The first error in the order of the seeds.
pub fn for_seeds<T: Send, E: Send>(
    seeds: &[u64],
    run: impl Fn(u64) -> Result<T, E> + Sync,
    done: impl FnMut(usize),
) -> Result<Vec<T>, E> {
    for_each(seeds, |seed| run(*seed), done)
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
