//! A thousand mutated logs, read in every way.

use armbridge_tests::mutated_logs::{read_all, read_mutated};

/// Not a test unless the one below starts it.
#[test]
fn reads_mutated_logs() {
    read_mutated();
}

#[test]
fn a_thousand_mutated_logs_take_little_memory_and_time() {
    let folder = crate::folder("mutated-1000");
    let largest = read_all(0..1_000, &folder, "mutated_logs::reads_mutated_logs");
    println!("1000 mutated logs: {largest:?}");
    assert!(largest.memory_bytes < 512_000_000, "{largest:?}");
}
