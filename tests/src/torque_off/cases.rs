//! Tables of cases: all of them run, and the failures are reported together.

use std::fmt::Debug;

/// Most failures that are reported.
const REPORTED: usize = 12;

/// Runs each case.
///
/// # Panics
/// If one fails; the message has a line for each failure.
#[track_caller]
pub fn run_cases<C: Debug>(
    cases: impl IntoIterator<Item = C>,
    mut run: impl FnMut(&C) -> Result<(), String>,
) {
    let mut failures = Vec::new();
    let mut count = 0;
    for case in cases {
        count += 1;
        if let Err(why) = run(&case) {
            failures.push(format!("{case:?}: {why}"));
        }
    }
    assert!(
        failures.is_empty(),
        "{} of {count} cases fail; the first:\n{}",
        failures.len(),
        failures[..failures.len().min(REPORTED)].join("\n")
    );
}

/// The errors of all results in one message.
pub fn all<const N: usize>(results: [Result<(), String>; N]) -> Result<(), String> {
    let whys: Vec<String> = results.into_iter().filter_map(Result::err).collect();
    check(whys.is_empty(), || whys.join("; "))
}

/// An error with this message unless the condition holds.
pub fn check(holds: bool, why: impl FnOnce() -> String) -> Result<(), String> {
    if holds { Ok(()) } else { Err(why()) }
}
