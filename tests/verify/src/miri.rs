//! Interprets tests with Miri, which detects every access to memory that the language
//! does not allow.
//!
//! `shared` forbids unsafe code and `firmware` has little; the libraries below them
//! (queues, vectors, messages, the log in flash) have more. Miri is ten thousand times
//! slower than a processor: loops between threads are shorter in it, random tests are
//! left out, and the seeds of the fuzz targets, which take minutes, belong to the
//! campaign. It cannot take a square root: that is inline assembly in `libm`.
//!
//! Miri comes with nightly toolchains only; one of a fixed date is installed beside the
//! toolchain in use where it is missing.

use std::process::Command;

use crate::output::{Output, succeeds};

/// A date for which all components exist.
const TOOLCHAIN: &str = "nightly-2026-10-30";

/// Tests of the gate: code that is shared between threads or interrupts.
const THREADS: &[&str] = &[
    "--package armbridge-board --lib queue::",
    "--package armbridge-firmware --lib -- ring:: port:: memory::",
];
/// Tests of the campaign: the seeds of every fuzz target.
const SEEDS: &[&str] = &["--package armbridge-board --test fuzz_seeds"];

/// Installs Miri where it is missing, and interprets the queues between threads.
pub(crate) fn threads(out: &Output) -> Result<(), String> {
    run(out, THREADS)
}

/// Installs Miri where it is missing, and interprets the seeds.
pub(crate) fn seeds(out: &Output) -> Result<(), String> {
    run(out, SEEDS)
}

fn run(out: &Output, tests: &[&str]) -> Result<(), String> {
    if !succeeds(&format!("rustup run {TOOLCHAIN} cargo miri --version")) {
        out.command(&format!(
            "rustup toolchain install {TOOLCHAIN} --profile minimal --component miri,rust-src"
        ))?;
    }
    tests.iter().try_for_each(|tests| interpret(out, tests))
}

fn interpret(out: &Output, tests: &str) -> Result<(), String> {
    let mut miri = Command::new("rustup");
    miri.args(["run", TOOLCHAIN, "cargo", "miri", "test", "--quiet"])
        .args(tests.split(' '))
        // The seeds are files.
        .env("MIRIFLAGS", "-Zmiri-disable-isolation")
        // It warns that it does not optimise.
        .env("CARGO_PROFILE_DEV_OPT_LEVEL", "0")
        // They are meant for the other toolchain.
        .env_remove("CARGO")
        .env_remove("RUSTFLAGS")
        .env_remove("CARGO_ENCODED_RUSTFLAGS");
    out.run(&mut miri)
}
