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
    signal(child, "INT");
}

/// Sends this signal.
#[cfg(unix)]
pub(crate) fn signal(child: &Child, name: &str) {
    let mut kill = Command::new("kill");
    let sent = kill
        .args([&format!("-{name}"), &child.id().to_string()])
        .status();
    assert!(sent.unwrap().success());
}

/// Terminals whose programs find each other, and none of other tests.
pub(crate) struct Terminals(PathBuf);

impl Terminals {
    pub(crate) fn new(test: &str) -> Self {
        let folder = crate::folder(test);
        let terminals = Self(folder);
        std::fs::create_dir_all(terminals.sockets()).unwrap();
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let private = std::fs::Permissions::from_mode(0o700);
            std::fs::set_permissions(terminals.sockets(), private).unwrap();
        }
        terminals.configure("patience_s = 0.5\n");
        terminals
    }

    /// Their `armbridge.toml`.
    pub(crate) fn configure(&self, text: &str) {
        std::fs::write(self.0.join("armbridge.toml"), text).unwrap();
    }

    /// Folder of their sockets.
    pub(crate) fn sockets(&self) -> PathBuf {
        self.0.join("sockets")
    }

    /// Size of the logs of their runs.
    pub(crate) fn logged_bytes(&self) -> u64 {
        let runs = std::fs::read_dir(self.0.join("runs")).into_iter().flatten();
        let logs = runs.flatten().map(|run| run.path().join("run.mcap"));
        logs.filter_map(|log| Some(log.metadata().ok()?.len()))
            .sum()
    }

    pub(crate) fn forget_runs(&self) {
        std::fs::remove_dir_all(self.0.join("runs")).unwrap();
    }

    fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_armbridge"));
        command.args(args).current_dir(&self.0);
        command.env_remove("ARMBRIDGE_LINK");
        command.env("ARMBRIDGE_SOCKETS", self.sockets());
        command
    }

    pub(crate) fn run(&self, args: &[&str]) -> Output {
        self.command(args).output().unwrap()
    }

    pub(crate) fn spawn(&self, args: &[&str]) -> Child {
        let mut command = self.command(args);
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command.spawn().unwrap()
    }
}
