//! Where the set-up puts things, for those that use them.

use std::path::{Path, PathBuf};

/// Cargo's folder of what it builds, and of what the set-up installs.
pub fn target() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../target"),
        PathBuf::from,
    )
}

/// The program `armbridge`, built in the profile of the test that asks.
///
/// # Panics
/// If it has not been built.
pub fn armbridge() -> PathBuf {
    let test = std::env::current_exe().expect("a test has a file");
    let profile = test.ancestors().nth(2).expect("tests are in PROFILE/deps");
    let program = profile.join("armbridge");
    assert!(
        program.exists(),
        "no {}: cargo build --features full",
        program.display()
    );
    program
}

/// The virtual environment of the Python clients: `cargo verify` makes it.
pub fn python_environment() -> PathBuf {
    target().join("python")
}

/// Its interpreter.
pub fn python() -> PathBuf {
    python_environment().join("bin/python")
}
