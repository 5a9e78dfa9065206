//! The `armbridge` program.
//!
//! Exit codes: 0 done; 1 it failed on the board, on a servo or by its result; 2 it could not
//! be done at all.
#![forbid(unsafe_code)]

mod args;
mod cli;
mod commands;

use std::error::Error;
use std::process::ExitCode;

fn main() -> ExitCode {
    armbridge_log::metadata::set_commit(env!("ARMBRIDGE_GIT"));
    let command = match cli::parse() {
        Ok(command) => command,
        Err(help) if !help.use_stderr() => help.exit(),
        Err(error) => {
            eprintln!("armbridge: {}", without_usage(&error.to_string()));
            return ExitCode::from(2);
        }
    };
    let result = command.run();
    match result {
        Ok(code) => code,
        Err(error) => {
            eprintln!("armbridge: {}", in_one_line(&*error));
            ExitCode::from(2)
        }
    }
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

/// An error and its causes.
fn in_one_line(error: &dyn Error) -> String {
    let mut line = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        let text = error.to_string();
        if !line.contains(&text) {
            line = format!("{line}: {text}");
        }
        cause = error.source();
    }
    line
}
