//! Crates outside the workspace: the shared crates as other projects have them, by path and as
//! packages, and the masters of others that drive the virtual servos.

use std::process::Command;

use armbridge_verify::TARGET;

use crate::output::{Output, cargo, printed};
use crate::paths;

/// Target of web pages.
pub(crate) const WEB_TARGET: &str = "wasm32-unknown-unknown";

/// Crates that can be published.
const PACKAGES: [&str; 4] = [
    "armbridge-servo",
    "armbridge-control",
    "armbridge-link",
    "armbridge-board",
];

/// Builds `tests/outside` for the boards' processor and for web pages, and runs its test on
/// the host.
pub(crate) fn run(out: &Output) -> Result<(), String> {
    let host = printed("rustc --print host-tuple").ok_or("cannot ask rustc for its host")?;
    out.run(&mut outside("build", &[TARGET, WEB_TARGET]))?;
    // A named host has the procedural macros of the build before.
    out.run(&mut outside("test", &[host.trim()]))
}

/// Cargo on `tests/outside`, for these targets.
fn outside(command: &str, targets: &[&str]) -> Command {
    let mut cargo = apart("outside", command);
    cargo.args(targets.iter().flat_map(|target| ["--target", target]));
    cargo
}

/// Cargo on a crate in `tests` that is a workspace of its own, in a target folder of its own.
fn apart(name: &str, command: &str) -> Command {
    let mut cargo = cargo(command);
    cargo
        .args(["--manifest-path", &format!("tests/{name}/Cargo.toml")])
        .arg("--target-dir")
        .arg(paths::target().join(name));
    cargo
}

/// Builds `tests/masters`, which the tests of the program run.
pub(crate) fn masters(out: &Output) -> Result<(), String> {
    out.run(&mut apart("masters", "build --locked"))
}

/// Makes packages of the shared crates, without a warning. They are built elsewhere: by every
/// other step.
pub(crate) fn package(out: &Output) -> Result<(), String> {
    let output = cargo("package --no-verify --offline --allow-dirty")
        .args(PACKAGES.iter().flat_map(|name| ["--package", name]))
        .output()
        .map_err(|e| format!("cannot start cargo: {e}"))?;
    let text = String::from_utf8_lossy(&output.stderr);
    out.line(text.trim_end());
    if output.status.success() && !text.contains("warning:") {
        Ok(())
    } else {
        Err(format!("the shared crates make no clean packages:\n{text}"))
    }
}
