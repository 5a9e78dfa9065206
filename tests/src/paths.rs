//! Where the set-up puts things, for those that use them.

use std::path::{Path, PathBuf};
use std::process::Command;

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

/// The firmware image of this name.
pub fn firmware(name: &str) -> PathBuf {
    target().join("thumbv7em-none-eabihf/firmware").join(name)
}

/// The interpreter of the virtual environment that `cargo verify` makes for the Python
/// clients.
pub fn python() -> PathBuf {
    target().join("python/bin/python")
}

/// A run of a script in `tests/python`.
///
/// # Panics
/// If there is no virtual environment.
pub fn script(name: &str) -> Command {
    let python = python();
    assert!(
        python.exists(),
        "no {}: cargo verify --only python",
        python.display()
    );
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("python");
    let mut command = Command::new(python);
    command.arg(folder.join(name));
    command
}

/// The program of `tests/masters`, which drives servos by masters that others have written.
///
/// # Panics
/// If it has not been built.
pub fn masters() -> Command {
    let program = target().join("masters/debug/masters");
    assert!(
        program.exists(),
        "no {}: cargo verify --only masters",
        program.display()
    );
    Command::new(program)
}

/// The run folder that `armbridge run` has printed: that of the log.
///
/// # Panics
/// If none is there.
pub fn run_folder(printed: &str) -> &str {
    let line = printed
        .lines()
        .find_map(|line| line.strip_prefix(" log      "));
    let log = line.and_then(|line| line.split_once("/run.mcap"));
    log.unwrap_or_else(|| panic!("no log in {printed}")).0
}
