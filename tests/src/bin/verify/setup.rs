//! What must be on the machine beside Rust itself, and how it gets there.
//!
//! What is there already is never touched. What is missing is installed where
//! that needs no question answered; otherwise the error says which command to
//! run.

use std::process::{Command, Stdio};

/// Target of both firmware images.
const TARGET: &str = "thumbv7em-none-eabihf";

/// How to do what [`rust`] does.
pub(crate) const RUST_BY_HAND: &str =
    "rustup target add thumbv7em-none-eabihf && rustup component add rustfmt clippy";

/// How to install QEMU with one package manager.
struct Manager {
    program: &'static str,
    /// Brings the list of packages up to date, where that is a step of its own.
    refresh: Option<&'static str>,
    install: &'static str,
    needs_root: bool,
}

const MANAGERS: [Manager; 4] = [
    Manager {
        program: "apt-get",
        refresh: Some("apt-get update"),
        install: "apt-get install --yes --no-install-recommends qemu-system-arm",
        needs_root: true,
    },
    Manager {
        program: "dnf",
        refresh: None,
        install: "dnf install --assumeyes qemu-system-arm",
        needs_root: true,
    },
    Manager {
        program: "pacman",
        refresh: None,
        install: "pacman --sync --needed --noconfirm qemu-system-arm",
        needs_root: true,
    },
    Manager {
        program: "brew",
        refresh: None,
        install: "brew install qemu",
        needs_root: false,
    },
];

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
    let installed = output(&query).is_some_and(|path| std::path::Path::new(path.trim()).is_dir());
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

/// QEMU, by the system's package manager where it is missing.
pub(crate) fn qemu() -> Result<(), String> {
    let check = "qemu-system-arm --version";
    if let Some(version) = output(check) {
        println!("{}", version.lines().next().unwrap_or_default());
        return Ok(());
    }
    let manager = MANAGERS
        .iter()
        .find(|m| succeeds(&format!("{} --version", m.program)));
    let Some(manager) = manager else {
        return Err(
            "qemu-system-arm is missing; install QEMU so that it is on the path".to_owned(),
        );
    };
    let root = !manager.needs_root || output("id -u").is_some_and(|id| id.trim() == "0");
    let prefix = if root { "" } else { "sudo " };
    if !root && !succeeds("sudo --non-interactive true") {
        return Err(format!(
            "qemu-system-arm is missing; run: {prefix}{}",
            manager.install
        ));
    }
    if let Some(refresh) = manager.refresh {
        // A source that cannot be reached need not be the one QEMU is in.
        if let Err(why) = loudly(&format!("{prefix}{refresh}")) {
            println!("{why}; trying all the same");
        }
    }
    loudly(&format!("{prefix}{}", manager.install))
        .map_err(|why| format!("{why}; qemu-system-arm is missing and has to be installed"))?;
    if succeeds(check) {
        Ok(())
    } else {
        Err(format!("`{check}` still fails"))
    }
}

/// A command from its words.
fn command(line: &str) -> Command {
    let mut words = line.split(' ');
    let mut command = Command::new(words.next().unwrap_or_default());
    command
        .args(words)
        .stdin(Stdio::null())
        .env("DEBIAN_FRONTEND", "noninteractive");
    command
}

/// Runs a command and shows what it says.
fn loudly(line: &str) -> Result<(), String> {
    println!("    {line}");
    match command(line).status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("`{line}` failed: {status}")),
        Err(e) => Err(format!("cannot start `{line}`: {e}")),
    }
}

/// Runs a command silently.
fn succeeds(line: &str) -> bool {
    output(line).is_some()
}

/// What a command printed, if it succeeded.
fn output(line: &str) -> Option<String> {
    let output = command(line)
        .output()
        .ok()
        .filter(|output| output.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).into_owned())
}
