//! Streams of bytes for the parsers, and scripts for the store.
//!
//! Half of them are random, 8 to 64 bytes; the other half are seeds of the fuzz
//! targets, one after another, with up to four damages. What must hold is the
//! fuzz targets' business: see `tests/fuzz/src`.

#[path = "../../fuzz/src/lib.rs"]
pub mod checks;
mod messages;
mod packets;
pub mod seeds;

use crate::random::Random;

const SHORTEST: usize = 8;
const LONGEST: usize = 64;

/// Feeds so many streams, and counts what came of the damaged ones.
pub fn feed(streams: usize, target: &str, seed: u64, check: fn(&[u8]) -> usize) -> usize {
    let seeds = seeds::read(target);
    let mut random = Random::new(seed);
    let mut stream = Vec::with_capacity(2 * LONGEST);
    let mut found = 0;
    for _ in 0..streams / 2 {
        stream.clear();
        let length = SHORTEST as u64 + random.below((LONGEST - SHORTEST + 1) as u64);
        stream.extend((0..length).map(|_| random.byte()));
        check(&stream);

        stream.clear();
        stream.extend(one_of(&mut random, &seeds));
        let longest = stream.len().max(LONGEST);
        while stream.len() < SHORTEST || random.once_in(2) {
            stream.extend(one_of(&mut random, &seeds));
        }
        stream.truncate(longest);
        for _ in 0..random.below(5) {
            random.damage(&mut stream);
        }
        found += check(&stream);
    }
    found
}

fn one_of<'a>(random: &mut Random, seeds: &'a [Vec<u8>]) -> &'a [u8] {
    &seeds[random.below(seeds.len() as u64) as usize]
}

/// One test for each parser and one for the store, each with so many streams; the
/// store's scripts take a thousand times as long as a stream, and are fewer.
#[macro_export]
macro_rules! stream_tests {
    ($streams:expr) => {
        use $crate::streams::{checks, feed};

        const STREAMS: usize = $streams;
        const SCRIPTS: usize = STREAMS / 100;

        #[test]
        fn transparent_port() {
            let found = feed(
                STREAMS,
                "transparent_port",
                0x5EED_0105,
                checks::transparent_port::check,
            );
            assert!(found > STREAMS / 2, "{found}");
        }

        #[test]
        fn protocol1() {
            // Four sizes of parser, and more than a packet a stream for most of them.
            let found = feed(STREAMS, "protocol1", 0x5EED_0101, checks::protocol1::check);
            assert!(found > STREAMS, "{found}");
        }

        #[test]
        fn protocol2() {
            let found = feed(STREAMS, "protocol2", 0x5EED_0107, checks::protocol2::check);
            assert!(found > STREAMS / 2, "{found}");
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
    };
}
