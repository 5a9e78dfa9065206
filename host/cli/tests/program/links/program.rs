//! The program itself, started on a link.

use std::fmt::Display;
use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};

/// Where it runs.
pub(crate) fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("links")
}

/// A socket of this machine.
pub(crate) const TCP: &str = "tcp://127.0.0.1:0";

/// The program on a link, with half a second of patience.
pub(crate) fn command(link: &impl Display, args: &[&str]) -> Command {
    let folder = folder();
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("armbridge.toml"), "patience_s = 0.5\n").unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_armbridge"));
    command.args(args).args(["--link", &link.to_string()]);
    command.current_dir(folder).env_remove("ARMBRIDGE_LINK");
    command
}

/// Runs it to its end.
pub(crate) fn run(link: &impl Display, args: &[&str]) -> Output {
    command(link, args).output().unwrap()
}

/// Starts it.
pub(crate) fn spawn(link: &impl Display, args: &[&str]) -> Child {
    let mut command = command(link, args);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command.spawn().unwrap()
}

/// Its output.
pub(crate) fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

/// It ended with this code, and printed `words`.
#[track_caller]
pub(crate) fn assert_ends(output: &Output, code: i32, words: &str) {
    let messages = format!("{}{}", text(&output.stdout), text(&output.stderr));
    assert_eq!(output.status.code(), Some(code), "{messages}");
    assert!(messages.contains(words), "no {words:?} in {messages:?}");
    assert!(!messages.contains("panicked"), "{messages}");
}

/// As Ctrl-C does.
#[cfg(unix)]
pub(crate) fn interrupt(child: &Child) {
    let mut kill = Command::new("kill");
    let sent = kill.args(["-INT", &child.id().to_string()]).status();
    assert!(sent.unwrap().success());
}
