//! The `armbridge` program.
//!
//! Exit codes: 0 done, 1 a fault ended the run or no servo did as asked, 2 it
//! could not be done as asked.
#![forbid(unsafe_code)]

mod cli;
mod commands;

use std::error::Error;
use std::process::ExitCode;

use cli::Command;
use commands::{
    arm, bench, calibrate, config, demo, design, diff, emulate, export, get, identify, info, live,
    off, paper, plot, replay, run, scan, servo, servos, set, shell, status, torture, watch,
};

fn main() -> ExitCode {
    armbridge_log::metadata::set_commit(env!("ARMBRIDGE_GIT"));
    let cli = match cli::parse() {
        Ok(cli) => cli,
        Err(help) if !help.use_stderr() => help.exit(),
        Err(error) => {
            eprintln!("armbridge: {}", without_usage(&error.to_string()));
            return ExitCode::from(2);
        }
    };
    let result = match &cli.command {
        None => demo::run(&cli.demo),
        Some(Command::Demo(args)) => demo::run(args),
        Some(Command::Emulate(args)) => emulate::run(args),
        Some(Command::Run(args)) => run::run(args),
        Some(Command::Servos(args)) => servos::run(args),
        Some(Command::Status(args)) => status::run(args),
        Some(Command::Arm(args)) => arm::run(args),
        Some(Command::Disarm(args)) => off::disarm(args),
        Some(Command::Stop(args)) => off::stop(args),
        Some(Command::Clear(args)) => off::clear(args),
        Some(Command::Calibrate(args)) => calibrate::run(args),
        Some(Command::Scan(args)) => scan::run(args),
        Some(Command::Servo(args)) => servo::run(args),
        Some(Command::Bench(args)) => bench::run(args),
        Some(Command::Torture(args)) => torture::run(args),
        Some(Command::Get(args)) => get::run(args),
        Some(Command::Set(args)) => set::run(args),
        Some(Command::Design(args)) => design::run(args),
        Some(Command::Config(args)) => config::run(args),
        Some(Command::Completions(args)) => shell::completions(args),
        Some(Command::Man(args)) => shell::man(args),
        Some(Command::Info(args)) => info::run(args),
        Some(Command::Plot(args)) => plot::run(args),
        Some(Command::Export(args)) => export::run(args),
        Some(Command::Diff(args)) => diff::run(args),
        Some(Command::Identify(args)) => identify::run(args),
        Some(Command::Watch(args)) => watch::run(args),
        Some(Command::Replay(args)) => replay::run(args),
        Some(Command::Live(args)) => live::run(args),
        Some(Command::Paper(args)) => paper::run(args),
    };
    match result {
        Ok(code) => code,
        Err(error) => {
            eprintln!("armbridge: {}", in_one_line(&*error));
            ExitCode::from(2)
        }
    }
}

/// What clap says of wrong arguments, in one line: its paragraphs but the usage.
fn without_usage(message: &str) -> String {
    let paragraphs = message.split("\n\n").map(|paragraph| {
        let words: Vec<&str> = paragraph.split_whitespace().collect();
        words.join(" ")
    });
    let said: Vec<String> = paragraphs
        .filter(|paragraph| !paragraph.starts_with("Usage:"))
        .collect();
    let said = said.join(". ");
    said.strip_prefix("error: ").unwrap_or(&said).to_owned()
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
