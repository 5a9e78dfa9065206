//! Ten million streams of bytes into each parser, and scripts for the store.

use armbridge_tests::streams::{checks, feed};

const STREAMS: usize = 10_000_000;
/// Each takes a thousand times as long as a stream does.
const SCRIPTS: usize = STREAMS / 100;

#[test]
fn gateway() {
    let found = feed(STREAMS, "gateway", 0x5EED_0105, checks::gateway::check);
    assert!(found > STREAMS / 2, "{found}");
}

#[test]
fn protocol1() {
    // Four sizes of parser, and more than a packet a stream for most of them.
    let found = feed(STREAMS, "protocol1", 0x5EED_0101, checks::protocol1::check);
    assert!(found > STREAMS, "{found}");
}

#[test]
fn morpheus() {
    let found = feed(STREAMS, "morpheus", 0x5EED_0102, checks::morpheus::check);
    assert!(found > STREAMS, "{found}");
}

#[test]
fn link_to_board() {
    let found = feed(STREAMS, "link", 0x5EED_0103, checks::link::to_board);
    assert!(found > STREAMS / 20, "{found}");
}

#[test]
fn link_to_host() {
    let found = feed(STREAMS, "link", 0x5EED_0104, checks::link::to_host);
    assert!(found > STREAMS / 20, "{found}");
}

#[test]
fn store() {
    let found = feed(SCRIPTS, "store", 0x5EED_0106, checks::store::check);
    assert!(found > SCRIPTS / 2, "{found}");
}
