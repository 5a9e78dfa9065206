//! The Python package as its users have it: a wheel, installed into an empty environment.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::output::Output;
use crate::paths;

/// Builds the wheel in the dev profile, which checks overflows, and runs its tests and the checkers
/// of its types.
pub(crate) fn run(out: &Output) -> Result<(), String> {
    let folder = paths::target().join("python-package");
    let (tools, environment) = (folder.join("tools"), folder.join("environment"));
    let wheels = folder.join("wheels");
    make_environment(out, &tools, "host/python/tests/build-requirements.txt")?;
    if wheels.exists() {
        std::fs::remove_dir_all(&wheels).map_err(|e| format!("{}: {e}", wheels.display()))?;
    }
    // The interpreter is named: without one the wheel would be for the first that is found.
    out.run(
        Command::new(tools.join("bin/maturin"))
            .args(["build", "--profile", "dev", "--locked", "--quiet"])
            .args(["--manifest-path", "host/python/Cargo.toml", "--interpreter"])
            .arg(tools.join("bin/python"))
            .arg("--out")
            .arg(&wheels)
            .arg("--target-dir")
            .arg(folder.join("build")),
    )?;
    make_environment(out, &environment, "host/python/tests/requirements.txt")?;
    let python = |arguments: &[&str]| {
        let mut command = Command::new(environment.join("bin/python"));
        command.args(arguments);
        command
    };
    let mut install = python(&[
        "-m",
        "pip",
        "install",
        "--quiet",
        "--disable-pip-version-check",
    ]);
    install.args(["--no-deps", "--force-reinstall"]);
    out.run(install.arg(wheel(&wheels)?))?;
    out.run(&mut python(&[
        "-m",
        "pytest",
        "--quiet",
        "-p",
        "no:cacheprovider",
        "host/python",
    ]))?;
    out.run(&mut python(&[
        "-m",
        "mypy",
        "--strict",
        "host/python/tests",
    ]))?;
    out.run(&mut python(&["-m", "mypy.stubtest", "armbridge"]))?;
    let mut pyright = python(&["-m", "pyright", "--pythonpath"]);
    pyright.arg(environment.join("bin/python"));
    out.run(pyright.arg("host/python/tests"))
}

/// A virtual environment with what this file lists.
fn make_environment(out: &Output, folder: &Path, requirements: &str) -> Result<(), String> {
    let interpreter = folder.join("bin/python");
    if !interpreter.exists() {
        out.run(
            Command::new("python3")
                .args(["-m", "venv", "--clear"])
                .arg(folder),
        )?;
    }
    let mut install = Command::new(interpreter);
    install.args([
        "-m",
        "pip",
        "install",
        "--quiet",
        "--disable-pip-version-check",
    ]);
    out.run(install.args(["--requirement", requirements]))
}

/// The only wheel in this folder.
fn wheel(folder: &Path) -> Result<PathBuf, String> {
    let entries = std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let wheels: Vec<_> = entries.flatten().map(|entry| entry.path()).collect();
    match &wheels[..] {
        [wheel] if wheel.to_string_lossy().contains("-abi3-") => Ok(wheel.clone()),
        _ => Err(format!("expected one abi3 wheel, got {wheels:?}")),
    }
}
