//! Running commands, given as a line with single spaces between the words.

use std::process::{Command, Stdio};

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
pub(crate) fn loudly(line: &str) -> Result<(), String> {
    println!("    {line}");
    succeeded(command(line).status(), line)
}

/// Runs a command silently.
pub(crate) fn succeeds(line: &str) -> bool {
    output(line).is_some()
}

/// What a command printed, if it succeeded.
pub(crate) fn output(line: &str) -> Option<String> {
    let output = command(line)
        .output()
        .ok()
        .filter(|output| output.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// An error that names what failed.
pub(crate) fn succeeded(
    result: std::io::Result<std::process::ExitStatus>,
    what: &str,
) -> Result<(), String> {
    match result {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("`{what}` failed: {status}")),
        Err(e) => Err(format!("cannot start `{what}`: {e}")),
    }
}
