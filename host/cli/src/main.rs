//! The `armbridge` program.
#![forbid(unsafe_code)]
// They panic where the output is gone: `armbridge_client::stdio` does not.
#![deny(clippy::print_stderr, clippy::print_stdout)]

mod args;
mod cli;
mod commands;
mod exit;

use std::process::ExitCode;

use armbridge_client::stdio;
use armbridge_client::stdio::Stdout;
use clap::error::ErrorKind;

fn main() -> ExitCode {
    armbridge_log::metadata::set_commit(env!("ARMBRIDGE_GIT"));
    let error = match cli::parse() {
        Ok(command) => return exit::code(command.run()),
        Err(error) => error,
    };
    match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => {
            let printed = Stdout::checked(error.print());
            return exit::code(printed.map(|()| ExitCode::SUCCESS).map_err(Into::into));
        }
        // A command of commands without one: its help, as it is laid out.
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            stdio::note_text(error.render());
        }
        _ => {
            let line = without_usage(&error.to_string());
            stdio::note(format_args!("armbridge: {line}"));
        }
    }
    ExitCode::from(exit::IMPOSSIBLE)
}

/// clap's message on wrong arguments, in one line without the usage.
fn without_usage(message: &str) -> String {
    let paragraphs = message.split("\n\n").map(|paragraph| {
        let words: Vec<&str> = paragraph.split_whitespace().collect();
        words.join(" ")
    });
    let text: Vec<String> = paragraphs
        .filter(|paragraph| !paragraph.starts_with("Usage:"))
        .collect();
    let text = text.join(". ");
    text.strip_prefix("error: ").unwrap_or(&text).to_owned()
}
