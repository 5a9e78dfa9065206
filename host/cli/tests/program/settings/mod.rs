//! Settings as a user reads, changes, configures and designs them; and the completion of
//! arguments in a shell.

mod board;
mod files;
mod shell;

use std::path::PathBuf;
use std::process::{Command, Output};

/// The program, in an empty folder.
struct Program(tempfile::TempDir);

impl Program {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn run(&self, args: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_armbridge"));
        let command = command.args(args).current_dir(self.0.path());
        let command = command
            .env_remove("ARMBRIDGE_LINK")
            .env_remove("ARMBRIDGE_OUT");
        command.output().unwrap()
    }

    /// Its standard output; it must succeed.
    fn says(&self, args: &[&str]) -> String {
        let output = self.run(args);
        let (stdout, stderr) = (text(&output.stdout), text(&output.stderr));
        assert!(output.status.success(), "{args:?}: {stderr}");
        stdout.to_owned()
    }

    /// One line on standard error with these words, and exit code 2.
    fn fails(&self, args: &[&str], words: &[&str]) {
        let output = self.run(args);
        let line = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {line}");
        assert_eq!(line.trim_end().lines().count(), 1, "{args:?}: {line}");
        for word in words {
            assert!(line.contains(word), "{args:?}: no {word:?} in {line:?}");
        }
    }

    fn json(&self, args: &[&str]) -> serde_json::Value {
        serde_json::from_str(&self.says(args)).unwrap()
    }
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}
