//! Long computations that a signal of Python interrupts.

use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use pyo3::prelude::*;

/// Period at which signals are looked for.
const LOOK: Duration = Duration::from_millis(50);

thread_local! {
    /// Flag of the computation on this thread.
    static FLAG: RefCell<Option<Arc<AtomicBool>>> = const { RefCell::new(None) };
}

/// Whether the computation on this thread is interrupted.
pub(crate) fn is_interrupted() -> bool {
    FLAG.with_borrow(|flag| flag.as_ref().is_some_and(|it| it.load(Ordering::Relaxed)))
}

/// Runs a computation on a thread of its own, without the interpreter's lock; it asks
/// [`is_interrupted`]. The exception of a signal comes before its result.
pub(crate) fn run<T: Send>(py: Python<'_>, compute: impl FnOnce() -> T + Send) -> PyResult<T> {
    let flag = Arc::new(AtomicBool::new(false));
    let theirs = Arc::clone(&flag);
    #[expect(
        clippy::redundant_closure_for_method_calls,
        reason = "its lifetime is not general"
    )]
    let check = || Python::attach(|py| py.check_signals());
    py.detach(|| {
        std::thread::scope(|scope| {
            let worker = scope.spawn(move || {
                FLAG.set(Some(theirs));
                compute()
            });
            let mut raised = None;
            while !worker.is_finished() {
                std::thread::park_timeout(LOOK);
                if let Err(error) = check() {
                    flag.store(true, Ordering::Relaxed);
                    raised = Some(error);
                }
            }
            match (worker.join(), raised) {
                (_, Some(error)) => Err(error),
                (Ok(result), None) => Ok(result),
                (Err(panic), None) => std::panic::resume_unwind(panic),
            }
        })
    })
}
