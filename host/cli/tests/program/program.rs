//! The program in a folder of its own, without the environment's link and folder.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The program, in a folder of this test alone.
pub(crate) struct Program(pub(crate) PathBuf);

impl Program {
    pub(crate) fn new(test: &str) -> Self {
        Self(crate::folder(test))
    }

    pub(crate) fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_armbridge"));
        command.args(args).current_dir(&self.0);
        command.env_remove("ARMBRIDGE_LINK");
        command.env_remove("ARMBRIDGE_OUT");
        command
    }

    pub(crate) fn run(&self, args: &[&str]) -> Output {
        self.command(args).output().unwrap()
    }

    /// Its standard output; it must succeed.
    pub(crate) fn prints(&self, args: &[&str]) -> String {
        let output = self.run(args);
        assert!(
            output.status.success(),
            "{args:?}: {}",
            text(&output.stderr)
        );
        text(&output.stdout).to_owned()
    }

    pub(crate) fn json(&self, args: &[&str]) -> serde_json::Value {
        serde_json::from_str(&self.prints(args)).unwrap()
    }

    /// One line on standard error with these words, and exit code 2.
    #[track_caller]
    pub(crate) fn refuses(&self, args: &[&str], words: &[&str]) {
        let output = self.run(args);
        let line = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {line}");
        assert_eq!(line.trim_end().lines().count(), 1, "{args:?}: {line}");
        for word in words {
            assert!(line.contains(word), "{args:?}: no {word:?} in {line}");
        }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    pub(crate) fn write(&self, name: &str, text: &str) {
        fs::write(self.0.join(name), text).unwrap();
    }
}

/// Output as text.
pub(crate) fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

/// Standard error as text.
pub(crate) fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Names in a folder, in order; none where there is no folder.
pub(crate) fn names(folder: &Path) -> Vec<String> {
    let Ok(entries) = fs::read_dir(folder) else {
        return Vec::new();
    };
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = names.collect();
    names.sort();
    names
}
