//! Output of a step and of the commands that it runs: the terminal, or a log file of its
//! own while another step runs beside it.

use std::fs::File;
use std::io::{self, Write};
use std::path::Path;
use std::process::{Command, Stdio};

use crate::paths;

/// Output of one step.
pub(crate) enum Output {
    Terminal,
    File(File),
}

impl Output {
    /// A file, truncated.
    pub(crate) fn file(path: &Path) -> io::Result<Self> {
        File::create(path).map(Self::File)
    }

    /// Writes a line.
    pub(crate) fn line(&self, line: &str) {
        match self {
            Self::Terminal => println!("{line}"),
            // A log that cannot be written does not fail the step.
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
        let line = command_line(command);
        self.line(&format!("    {line}"));
        let streams = self.stdio().and_then(|out| Ok((out, self.stdio()?)));
        let (out, err) = streams.map_err(|e| format!("no output for `{line}`: {e}"))?;
        let command = command.stdin(Stdio::null()).stdout(out).stderr(err);
        match command.current_dir(paths::root()).status() {
            Ok(status) if status.success() => Ok(()),
            Ok(status) => Err(format!("`{line}`: {status}")),
            Err(error) => Err(format!("cannot start `{line}`: {error}")),
        }
    }

    /// Runs cargo with these arguments.
    pub(crate) fn cargo(&self, arguments: &str) -> Result<(), String> {
        self.run(&mut cargo(arguments))
    }

    /// Runs a command given as a line, with single spaces between the arguments.
    pub(crate) fn command(&self, line: &str) -> Result<(), String> {
        self.run(&mut command(line))
    }
}

/// The cargo that started this program, with these arguments.
pub(crate) fn cargo(arguments: &str) -> Command {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command
        .args(arguments.split_whitespace())
        // It speeds up a repeated build after small edits, and slows down one from nothing.
        .env("CARGO_INCREMENTAL", "0")
        // Undivided crates take less time to optimise, and identification's tests half the
        // time to run; incremental builds need them divided.
        .env("CARGO_PROFILE_DEV_CODEGEN_UNITS", "1")
        .current_dir(paths::root());
    command
}

/// A command from its line.
fn command(line: &str) -> Command {
    let mut words = line.split(' ');
    let mut command = Command::new(words.next().unwrap_or_default());
    command.args(words).env("DEBIAN_FRONTEND", "noninteractive");
    command
}

/// Standard output of a command, if it succeeds.
pub(crate) fn printed(line: &str) -> Option<String> {
    let mut command = command(line);
    let output = command.stdin(Stdio::null()).output().ok()?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    output.status.success().then_some(text)
}

/// Whether a command succeeds.
pub(crate) fn succeeds(line: &str) -> bool {
    printed(line).is_some()
}

/// The command as it is typed.
fn command_line(command: &Command) -> String {
    let program = Path::new(command.get_program());
    let program = program.file_name().unwrap_or_default();
    let words = std::iter::once(program).chain(command.get_args());
    let words: Vec<_> = words.map(|word| word.to_string_lossy()).collect();
    words.join(" ")
}
