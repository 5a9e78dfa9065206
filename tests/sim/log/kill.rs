//! A recorder that is killed leaves all but the last second.

use armbridge_tests::kill::{kill, look, read_alike, record_until_killed};

use super::folder;

const VICTIM: &str = "log::kill::records_until_it_is_killed";

/// Not a test unless one of those below starts it.
#[test]
fn records_until_it_is_killed() {
    record_until_killed();
}

#[test]
fn a_kill_takes_the_last_second_at_most() {
    let killed = kill(20, &folder("killed"), VICTIM);
    let looked = killed.iter().map(|(path, at_ns)| look(path, *at_ns).ticks);
    assert!(looked.filter(|ticks| *ticks > 500).count() > 10);
}

/// A hundred are in the campaign.
#[test]
#[ignore = "needs the Python packages: run `cargo verify`"]
fn the_mcap_package_reads_as_much_of_eight_that_were_killed() {
    let missing_ms = read_alike(&kill(8, &folder("killed_8"), VICTIM));
    assert_eq!(missing_ms.len(), 8);
}
