//! A recorder that is killed leaves all but the last second.

use armbridge_tests::kill::{kill, read_alike, read_recovered, record_until_killed};

use super::folder;

const CHILD_TEST: &str = "log::kill::records_until_it_is_killed";

/// Not a test unless one of those below starts it.
#[test]
fn records_until_it_is_killed() {
    record_until_killed();
}

#[test]
fn a_kill_takes_the_last_second_at_most() {
    let killed = kill(20, &folder("killed"), CHILD_TEST);
    let recovered = killed
        .iter()
        .map(|(path, at_ns)| read_recovered(path, *at_ns).ticks);
    assert!(recovered.filter(|ticks| *ticks > 500).count() > 10);
}

/// A hundred are in the campaign.
#[test]
#[ignore = "needs the Python packages: run `cargo verify`"]
fn the_mcap_package_reads_as_much_of_eight_that_were_killed() {
    let missing_ms = read_alike(&kill(8, &folder("killed_8"), CHILD_TEST));
    assert_eq!(missing_ms.len(), 8);
}
