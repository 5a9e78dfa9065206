//! Interprets what handles bytes, with Miri, which sees every access to memory
//! that the language does not allow.
//!
//! The code here forbids unsafe code, or has next to none; the libraries below it
//! (queues, vectors, messages, the log in flash) do not. An interpreter is
//! ten thousand times slower than a processor: so the seeds of the fuzz targets
//! are run and not the random tests, and loops between threads are shorter. Nor can
//! it do what takes a root: that is inline assembly in `libm`.
//!
//! Miri comes with nightly toolchains only, so one is installed beside the one in
//! use, if it is not there: the same on every machine.

use std::process::Command;

use crate::output::{Output, succeeds};

/// One of the days of which all components exist.
const TOOLCHAIN: &str = "nightly-2026-10-30";

/// What is interpreted.
const TESTS: [&str; 3] = [
    "--package armbridge-shared --test seeds",
    // Between threads.
    "--package armbridge-shared --lib queue::",
    "--package armbridge-firmware --lib -- ring:: port:: memory::",
];

/// Installs Miri where it is missing, and runs the tests.
pub(crate) fn run(out: &Output) -> Result<(), String> {
    if !succeeds(&format!("rustup run {TOOLCHAIN} cargo miri --version")) {
        out.words(&format!(
            "rustup toolchain install {TOOLCHAIN} --profile minimal --component miri,rust-src"
        ))?;
    }
    TESTS.iter().try_for_each(|tests| interpret(out, tests))
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
