//! Mutated logs are read, or refused, in little memory and time.

use armbridge_tests::mutated_logs::{read_all, read_mutated};

use super::folder;

/// Not a test unless the one below starts it.
#[test]
fn reads_mutated_logs() {
    read_mutated();
}

/// A thousand are in the campaign.
#[test]
fn mutated_logs_take_little_memory_and_time() {
    let largest = read_all(0..8, &folder("mutated"), "log::mutated::reads_mutated_logs");
    assert!(largest.memory_bytes < 512_000_000, "{largest:?}");
}
