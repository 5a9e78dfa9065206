//! Set-up: the programs that the steps need beside Rust itself.
//!
//! A program that is present is never touched. A missing one is installed where that
//! needs no answer from the user; otherwise the error names the command to run.

use std::path::Path;
use std::process::Command;

use crate::output::{Output, printed, succeeds};
use crate::outside::WEB_TARGET;
use crate::packages::ensure;
use crate::paths;

/// Targets: of both firmware images, of the program on Windows and macOS, and of web pages.
const TARGETS: [&str; 4] = [
    "thumbv7em-none-eabihf",
    "x86_64-pc-windows-gnu",
    "aarch64-apple-darwin",
    WEB_TARGET,
];

/// Formatter, linter and targets, by rustup where one is missing; the test runner, by
/// cargo.
pub(crate) fn rust(out: &Output) -> Result<(), String> {
    for (component, check) in [
        ("rustfmt", "cargo fmt --version"),
        ("clippy", "cargo clippy --version"),
    ] {
        if !succeeds(check) {
            rustup(out, &format!("rustup component add {component}"))?;
        }
    }
    for target in TARGETS {
        // Where a target's library is, if it is installed.
        let query = format!("rustc --print target-libdir --target {target}");
        let installed = printed(&query).is_some_and(|path| Path::new(path.trim()).is_dir());
        if !installed {
            rustup(out, &format!("rustup target add {target}"))?;
        }
    }
    if succeeds("cargo nextest --version") {
        return Ok(());
    }
    // It takes minutes, hence the line in the terminal, not in the log.
    println!("      cargo-nextest, which runs the tests, is missing and is built once");
    out.cargo("install --locked cargo-nextest")
}

fn rustup(out: &Output, command: &str) -> Result<(), String> {
    if !succeeds("rustup --version") {
        return Err(format!(
            "rustup is not there to run `{command}`; install the same by hand"
        ));
    }
    out.command(command)
}

/// Everything that the campaign needs.
pub(crate) fn campaign(out: &Output) -> Result<(), String> {
    rust(out)?;
    python(out)?;
    compiler(out)
}

/// The emulator of the board's processor.
pub(crate) fn qemu(out: &Output) -> Result<(), String> {
    let qemu = "qemu-system-arm";
    ensure(
        out,
        qemu,
        "qemu-system-arm --version",
        [qemu, qemu, qemu, "qemu"],
    )
}

/// The browser in which pages are looked at.
pub(crate) fn browser(out: &Output) -> Result<(), String> {
    ensure(out, "Chromium", "chromium --version", ["chromium"; 4])
}

/// The languages of the JSON server's clients: GNU Octave with sockets, Node, and a shell with nc.
pub(crate) fn languages(out: &Output) -> Result<(), String> {
    let octave = [
        "octave octave-instrument-control",
        "octave",
        "octave",
        "octave",
    ];
    ensure(
        out,
        "GNU Octave with its package instrument-control",
        "octave-cli --no-gui --eval pkg('load','instrument-control')",
        octave,
    )?;
    ensure(
        out,
        "Node",
        "node --version",
        ["nodejs", "nodejs", "nodejs", "node"],
    )?;
    let netcat = ["netcat-openbsd", "netcat", "openbsd-netcat", "netcat"];
    ensure(out, "nc", "nc -h", netcat)
}

/// The C++ compiler that libFuzzer is built with: `CXX`, else `c++`.
pub(crate) fn compiler(out: &Output) -> Result<(), String> {
    let compiler = std::env::var("CXX").unwrap_or_else(|_| "c++".to_owned());
    let check = format!("{compiler} --version");
    ensure(
        out,
        "a C++ compiler",
        &check,
        ["g++", "gcc-c++", "gcc", "gcc"],
    )
}

/// The linker of programs for Windows.
pub(crate) fn mingw(out: &Output) -> Result<(), String> {
    let packages = [
        "gcc-mingw-w64-x86-64",
        "mingw64-gcc",
        "mingw-w64-gcc",
        "mingw-w64",
    ];
    ensure(
        out,
        "MinGW-w64",
        "x86_64-w64-mingw32-gcc --version",
        packages,
    )
}

/// The environment in which a program for Windows runs.
pub(crate) fn wine(out: &Output) -> Result<(), String> {
    let packages = ["wine wine64", "wine", "wine", "wine-stable"];
    ensure(out, "Wine", "wine --version", packages)
}

/// The program that flashes DFU files.
pub(crate) fn dfu_util(out: &Output) -> Result<(), String> {
    ensure(out, "dfu-util", "dfu-suffix --version", ["dfu-util"; 4])
}

/// A virtual environment with the Python clients, in cargo's target folder.
pub(crate) fn python(out: &Output) -> Result<(), String> {
    // Debian's plain python3 lacks ensurepip.
    ensure(
        out,
        "Python 3 with venv and pip",
        "python3 -m ensurepip --version",
        ["python3 python3-venv", "python3", "python", "python"],
    )?;
    let environment = paths::python_environment();
    let interpreter = environment.join("bin/python");
    let works = Command::new(&interpreter)
        .args(["-m", "pip", "--version"])
        .output();
    if !works.is_ok_and(|output| output.status.success()) {
        let mut make = Command::new("python3");
        out.run(make.args(["-m", "venv", "--clear"]).arg(environment))?;
    }
    let mut install = Command::new(interpreter);
    install
        .args(["-m", "pip", "install", "--quiet", "--no-deps"])
        .args(["--disable-pip-version-check", "--requirement"])
        .arg(paths::root().join("tests/python/requirements.txt"));
    out.run(&mut install)
}
