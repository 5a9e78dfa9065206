//! What was heard on the link, through the board's code again.

mod broken;
#[cfg(unix)]
mod emulator;
mod orders;
mod random;
mod torture;

use armbridge_log::replay::{Report, Verdict};

/// Everything that was compared is the same.
#[track_caller]
fn assert_equal(report: &Report) {
    assert_eq!(report.verdict, Verdict::Equal, "{}", report.text());
}

/// Everything is the same, and nothing was left out.
#[track_caller]
fn assert_all_equal(report: &Report) {
    assert_equal(report);
    assert_eq!(report.compared, report.records, "{}", report.text());
}
