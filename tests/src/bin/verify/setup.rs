//! What must be on the machine beside Rust itself, and how it gets there.
//!
//! What is there already is never touched. What is missing is installed where
//! that needs no question answered; otherwise the error says which command to
//! run.

use super::packages::Program;
use super::run::{loudly, output, succeeded, succeeds};
use armbridge_tests::place;
use std::path::Path;
use std::process::Command;

/// Target of both firmware images.
const TARGET: &str = "thumbv7em-none-eabihf";

/// How to do what [`rust`] does.
pub(crate) const RUST_BY_HAND: &str =
    "rustup target add thumbv7em-none-eabihf && rustup component add rustfmt clippy";

/// How to do what [`python`] does.
pub(crate) const PYTHON_BY_HAND: &str = "python3 -m venv target/python && \
     target/python/bin/python -m pip install --no-deps --requirement tests/python/requirements.txt";

/// Formatter, linter and target, by rustup where one is missing.
pub(crate) fn rust() -> Result<(), String> {
    for (component, check) in [
        ("rustfmt", "cargo fmt --version"),
        ("clippy", "cargo clippy --version"),
    ] {
        if !succeeds(check) {
            rustup(&format!("rustup component add {component}"))?;
        }
    }
    // Where a target's library is, if it is installed.
    let query = format!("rustc --print target-libdir --target {TARGET}");
    let installed = output(&query).is_some_and(|path| Path::new(path.trim()).is_dir());
    if installed {
        Ok(())
    } else {
        rustup(&format!("rustup target add {TARGET}"))
    }
}

fn rustup(command: &str) -> Result<(), String> {
    if !succeeds("rustup --version") {
        return Err(format!(
            "rustup is not there to run `{command}`; install the same by hand"
        ));
    }
    loudly(command)
}

/// The emulator of the board's processor.
pub(crate) fn qemu() -> Result<(), String> {
    let qemu = Program {
        name: "qemu-system-arm",
        check: "qemu-system-arm --version".to_owned(),
        packages: [
            "qemu-system-arm",
            "qemu-system-arm",
            "qemu-system-arm",
            "qemu",
        ],
    };
    qemu.ensure()
}

/// The C++ compiler that libFuzzer is built with: `c++`, or what `CXX` says.
pub(crate) fn compiler() -> Result<(), String> {
    let compiler = std::env::var("CXX").unwrap_or_else(|_| "c++".to_owned());
    let compiler = Program {
        name: "a C++ compiler",
        check: format!("{compiler} --version"),
        packages: ["g++", "gcc-c++", "gcc", "gcc"],
    };
    compiler.ensure()
}

/// A virtual environment with the Python clients, in cargo's target folder.
pub(crate) fn python() -> Result<(), String> {
    let python = Program {
        name: "Python 3 with venv and pip",
        // What Debian leaves out of its plain python3.
        check: "python3 -m ensurepip --version".to_owned(),
        packages: ["python3 python3-venv", "python3", "python", "python"],
    };
    python.ensure()?;
    let interpreter = place::python();
    let works = Command::new(&interpreter)
        .args(["-m", "pip", "--version"])
        .output();
    if !works.is_ok_and(|output| output.status.success()) {
        let mut make = Command::new("python3");
        make.args(["-m", "venv", "--clear"])
            .arg(place::python_environment());
        succeeded(make.status(), "python3 -m venv")?;
    }
    let requirements = Path::new(env!("CARGO_MANIFEST_DIR")).join("python/requirements.txt");
    let mut install = Command::new(interpreter);
    install
        .args(["-m", "pip", "install", "--quiet", "--no-deps"])
        .args(["--disable-pip-version-check", "--requirement"])
        .arg(requirements);
    succeeded(install.status(), "pip install")
}
