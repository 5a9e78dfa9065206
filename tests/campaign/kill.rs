//! A hundred recorders killed at random moments.

use armbridge_tests::kill::{kill, read_alike, record_until_killed};

/// Not a test unless the one below starts it.
#[test]
fn records_until_it_is_killed() {
    record_until_killed();
}

#[test]
#[ignore = "needs the Python packages: run `cargo verify --campaign`"]
fn the_mcap_package_reads_as_much_of_a_hundred_that_were_killed() {
    let folder = crate::folder("killed-100");
    let missing_ms = read_alike(&kill(100, &folder, "kill::records_until_it_is_killed"));
    let (median, worst) = (missing_ms[50], missing_ms[99]);
    println!("100 killed: {median} ms are missing in the median, {worst} ms at most");
}
