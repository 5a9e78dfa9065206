//! Runs in parallel, on one thread per processor, which ctrl-C ends early.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;

use armbridge_client::ctrl_c;

/// Results of the items that were finished, in the order of the items.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Batch<T, E> {
    /// Results.
    pub finished: Vec<T>,
    /// The first error in the order of the items, which ended the batch.
    pub error: Option<E>,
}

/// Calls `run` for every item, on one thread per processor, and `done` on the calling
/// thread after each, with the number of finished runs. After ctrl-c or an error no run
/// begins.
pub fn for_each<I: Sync, T: Send, E: Send>(
    items: &[I],
    run: impl Fn(&I) -> Result<T, E> + Sync,
    mut done: impl FnMut(usize),
) -> Batch<T, E> {
    let threads = thread::available_parallelism().map_or(1, usize::from);
    let next = AtomicUsize::new(0);
    let has_failed = AtomicBool::new(false);
    let (sender, receiver) = mpsc::channel();
    let mut results: Vec<(usize, Result<T, E>)> = Vec::new();
    thread::scope(|scope| {
        for _ in 0..threads.min(items.len()) {
            let (next, run, sender) = (&next, &run, sender.clone());
            let has_failed = &has_failed;
            scope.spawn(move || {
                while !ctrl_c::is_raised()
                    && !has_failed.load(Ordering::Relaxed)
                    && let Some((index, item)) = {
                        let index = next.fetch_add(1, Ordering::Relaxed);
                        items.get(index).map(|item| (index, item))
                    }
                {
                    let result = run(item);
                    has_failed.fetch_or(result.is_err(), Ordering::Relaxed);
                    // The receiver outlives this thread.
                    let _ = sender.send((index, result));
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
    let mut batch = Batch {
        finished: Vec::with_capacity(results.len()),
        error: None,
    };
    for (_, result) in results {
        match result {
            Ok(result) => batch.finished.push(result),
            Err(error) => batch.error = batch.error.or(Some(error)),
        }
    }
    batch
}

/// The same for every seed, all of them or those before ctrl-c.
///
/// # Errors
///
/// The first error in the order of the seeds.
pub fn for_seeds<T: Send, E: Send>(
    seeds: &[u64],
    run: impl Fn(u64) -> Result<T, E> + Sync,
    done: impl FnMut(usize),
) -> Result<Vec<T>, E> {
    let Batch { finished, error } = for_each(seeds, |seed| run(*seed), done);
    error.map_or(Ok(finished), Err)
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
        // After an error no other item begins.
        let begun = AtomicUsize::new(0);
        let first = |seed| {
            begun.fetch_add(1, Ordering::Relaxed);
            thread::sleep(std::time::Duration::from_millis(1));
            if seed == 50 { Err(seed) } else { Ok(()) }
        };
        let many: Vec<u64> = (50..1_050).collect();
        assert_eq!(for_seeds(&many, first, |_| ()), Err(50));
        assert!(begun.load(Ordering::Relaxed) < 500, "{begun:?}");
        let odd = |seed| if seed % 2 == 1 { Err(seed) } else { Ok(()) };
        assert_eq!(for_seeds(&seeds, odd, |_| ()), Err(49));
    }
}
