//! The `armbridge` program.
//!
//! Exit codes: 0 done, 1 a fault ended the run, 2 it could not be done as asked.
#![forbid(unsafe_code)]

mod cli;
mod commands;

use std::error::Error;
use std::process::ExitCode;

use clap::Parser;
use cli::{Cli, Command};
use commands::{demo, emulate, servos};

fn main() -> ExitCode {
    let cli = Cli::parse();
    let result = match &cli.command {
        None => demo::run(&cli.demo),
        Some(Command::Demo(args)) => demo::run(args),
        Some(Command::Emulate(args)) => emulate::run(args),
        Some(Command::Servos(args)) => servos::run(args),
    };
    match result {
        Ok(code) => code,
        Err(error) => {
            eprintln!("armbridge: {}", in_one_line(&*error));
            ExitCode::from(2)
        }
    }
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
