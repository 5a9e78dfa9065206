//! Every seed of the fuzz targets: all that parses, queues or stores bytes, on one
//! of everything that it may be fed.
//!
//! The fuzz targets assert what must hold, see `tests/fuzz/src`. The seeds are here for Miri,
//! which interprets a program and finds accesses to memory that a library must not make.

#[path = "../../../tests/fuzz/src/lib.rs"]
#[expect(unreachable_pub, reason = "public to the fuzz targets")]
mod checks;

use std::path::Path;

/// Feeds all seeds of a target, and says of how many something came.
fn feed(target: &str, check: fn(&[u8]) -> usize) -> usize {
    let seeds = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fuzz/seeds");
    let seeds = std::fs::read_dir(seeds.join(target)).expect("the target has seeds");
    seeds
        .map(|seed| std::fs::read(seed.expect("a seed").path()).expect("its bytes"))
        .filter(|bytes| check(bytes) > 0)
        .count()
}

#[test]
fn transparent_port() {
    assert!(feed("transparent_port", checks::transparent_port::check) >= 20);
}

#[test]
fn link() {
    assert!(feed("link", checks::link::check) >= 20);
}

#[test]
fn master() {
    assert!(feed("master", checks::master::check) >= 6);
}

#[test]
fn morpheus() {
    assert!(feed("morpheus", checks::morpheus::check) >= 10);
}

#[test]
fn protocol1() {
    assert!(feed("protocol1", checks::protocol1::check) >= 10);
}

#[test]
fn protocol2() {
    assert!(feed("protocol2", checks::protocol2::check) >= 14);
}

#[test]
fn store() {
    // Miri takes seconds for each save.
    const LONGEST: usize = if cfg!(miri) { 11 } else { 4_096 };
    let check = |script: &[u8]| {
        if script.len() <= LONGEST {
            checks::store::check(script)
        } else {
            0
        }
    };
    assert!(feed("store", check) >= 3);
}
