//! Where a step's words go, its commands' included: the terminal, or a file of its own
//! while another step runs beside it.

use std::fs::File;
use std::io::{self, Write};
use std::path::Path;
use std::process::{Command, Stdio};

use crate::paths;

/// The words of one step.
pub(crate) enum Output {
    Terminal,
    File(File),
}

impl Output {
    /// A file, made anew.
    pub(crate) fn file(path: &Path) -> io::Result<Self> {
        File::create(path).map(Self::File)
    }

    /// A line.
    pub(crate) fn say(&self, line: &str) {
        match self {
            Self::Terminal => println!("{line}"),
            // A log that cannot be written costs the words, not the step.
            Self::File(file) => drop(writeln!(&*file, "{line}")),
        }
    }

    fn stdio(&self) -> io::Result<Stdio> {
        match self {
            Self::Terminal => Ok(Stdio::inherit()),
            Self::File(file) => file.try_clone().map(Stdio::from),
        }
    }

    /// Runs a command at the root of the workspace. The error says how it ended.
    pub(crate) fn run(&self, command: &mut Command) -> Result<(), String> {
        let line = line(command);
        self.say(&format!("    {line}"));
        let streams = self.stdio().and_then(|out| Ok((out, self.stdio()?)));
        let (out, err) = streams.map_err(|e| format!("no output for `{line}`: {e}"))?;
        let command = command.stdin(Stdio::null()).stdout(out).stderr(err);
        match command.current_dir(paths::root()).status() {
            Ok(status) if status.success() => Ok(()),
            Ok(status) => Err(format!("`{line}`: {status}")),
            Err(error) => Err(format!("cannot start `{line}`: {error}")),
        }
    }

    /// Runs cargo with these words.
    pub(crate) fn cargo(&self, words: &str) -> Result<(), String> {
        self.run(&mut cargo(words))
    }

    /// Runs a command given as words with single spaces between them.
    pub(crate) fn words(&self, words: &str) -> Result<(), String> {
        self.run(&mut command(words))
    }
}

/// The cargo that started this program, with these words.
pub(crate) fn cargo(words: &str) -> Command {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command
        .args(words.split_whitespace())
        .current_dir(paths::root());
    command
}

/// A command from its words.
fn command(words: &str) -> Command {
    let mut words = words.split(' ');
    let mut command = Command::new(words.next().unwrap_or_default());
    command.args(words).env("DEBIAN_FRONTEND", "noninteractive");
    command
}

/// What a command printed, if it succeeded.
pub(crate) fn printed(words: &str) -> Option<String> {
    let mut command = command(words);
    let output = command.stdin(Stdio::null()).output().ok()?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    output.status.success().then_some(text)
}

/// Whether a command succeeds.
pub(crate) fn succeeds(words: &str) -> bool {
    printed(words).is_some()
}

/// The command as it is typed.
fn line(command: &Command) -> String {
    let program = Path::new(command.get_program());
    let program = program.file_name().unwrap_or_default();
    let words = std::iter::once(program).chain(command.get_args());
    let words: Vec<_> = words.map(|word| word.to_string_lossy()).collect();
    words.join(" ")
}
