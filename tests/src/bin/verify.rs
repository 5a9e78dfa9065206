//! `cargo verify`: everything a change must pass, set-up included.
//!
//! Runs its steps in order, says how long each took, and stops at the first
//! that fails with the command that repeats it. Exit code 0: all passed; 1: a
//! step failed; 2: wrong arguments.
//!
//! Host code is checked and tested in the dev profile: this program was built
//! in it, dependencies included, so the tree is not built again, and overflow
//! checks are on. Firmware is checked in release, the profile of its images.

#[path = "verify/callers.rs"]
mod callers;
#[path = "verify/fuzz.rs"]
mod fuzz;
#[path = "verify/miri.rs"]
mod miri;
#[path = "verify/no_panic.rs"]
mod no_panic;
#[path = "verify/packages.rs"]
mod packages;
#[path = "verify/run.rs"]
mod run;
#[path = "verify/setup.rs"]
mod setup;
#[path = "verify/steps.rs"]
mod steps;

use std::ops::Range;
use std::path::Path;
use std::process::{Command, ExitCode};
use std::time::Instant;
use steps::{STEPS, Step, Work};

const USAGE: &str = "\
Set up what the tests need, then check, build and test everything.

usage: cargo verify [--from STEP | --only STEP | --list | --help]

  --from STEP  begin with this step
  --only STEP  do this step alone
  --list       say what the steps are and do nothing
  --help       say this and do nothing";

/// What the arguments ask for.
#[derive(Debug, PartialEq)]
enum Task {
    Help,
    List,
    /// These steps.
    Run(Range<usize>),
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match task(&arguments) {
        Ok(Task::Help) => println!("{USAGE}"),
        Ok(Task::List) => {
            for Step { name, what, work } in STEPS {
                println!("{name:<16}{what}\n{:16}{}", "", work.command());
            }
        }
        Ok(Task::Run(range)) => return run(&STEPS[range]),
        Err(what) => {
            eprintln!("{what}\n\n{USAGE}");
            return ExitCode::from(2);
        }
    }
    ExitCode::SUCCESS
}

fn task(arguments: &[&str]) -> Result<Task, String> {
    match arguments {
        [] => Ok(Task::Run(0..STEPS.len())),
        ["--help" | "-h"] => Ok(Task::Help),
        ["--list"] => Ok(Task::List),
        ["--from", name] => Ok(Task::Run(position(name)?..STEPS.len())),
        ["--only", name] => {
            let only = position(name)?;
            Ok(Task::Run(only..only + 1))
        }
        [option @ ("--from" | "--only")] => Err(format!("{option} wants the name of a step")),
        _ => Err(format!("cannot make sense of `{}`", arguments.join(" "))),
    }
}

fn position(name: &str) -> Result<usize, String> {
    STEPS
        .iter()
        .position(|step| step.name == name)
        .ok_or_else(|| format!("there is no step `{name}`; see cargo verify --list"))
}

/// Runs these steps.
fn run(steps: &[Step]) -> ExitCode {
    let begin = Instant::now();
    let mut times = Vec::new();
    for step in steps {
        println!(
            "\n==> {}: {}\n    {}",
            step.name,
            step.what,
            step.work.command()
        );
        let start = Instant::now();
        if let Err(why) = perform(&step.work) {
            let command = step.work.command();
            eprintln!("\nverify: step `{}` failed: {why}", step.name);
            eprintln!("repeat it with:    {command}");
            eprintln!("and go on with:    cargo verify --from {}", step.name);
            return ExitCode::FAILURE;
        }
        times.push((step.name, start.elapsed()));
    }
    println!();
    for (name, time) in &times {
        println!("{name:<16}{:>8.1} s", time.as_secs_f64());
    }
    println!("{:<16}{:>8.1} s", "all", begin.elapsed().as_secs_f64());
    println!("steps: {} passed, 0 failed", times.len());
    ExitCode::SUCCESS
}

fn perform(work: &Work) -> Result<(), String> {
    match work {
        Work::Do(work, _) => work(),
        Work::Cargo(arguments) => {
            let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
            // From the root of the workspace, wherever this was called.
            let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
            let status = Command::new(cargo)
                .args(arguments.split(' '))
                .current_dir(root)
                .status()
                .map_err(|e| format!("cannot start cargo: {e}"))?;
            if status.success() {
                Ok(())
            } else {
                Err(status.to_string())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_are_understood_or_refused() {
        assert_eq!(task(&[]), Ok(Task::Run(0..STEPS.len())));
        assert_eq!(task(&["--list"]), Ok(Task::List));
        let last = STEPS.len() - 1;
        let from = task(&["--from", STEPS[last - 1].name]);
        assert_eq!(from, Ok(Task::Run(last - 1..last + 1)));
        let only = task(&["--only", STEPS[0].name]);
        assert_eq!(only, Ok(Task::Run(0..1)));
        for wrong in [
            &["--from"][..],
            &["--from", "nowhere"],
            &["--only"],
            &["x"],
            &["--list", "x"],
        ] {
            assert!(task(wrong).is_err(), "{wrong:?}");
        }
    }

    #[test]
    fn each_step_has_a_name_of_its_own() {
        for (i, step) in STEPS.iter().enumerate() {
            assert!(
                STEPS[..i].iter().all(|other| other.name != step.name),
                "{}",
                step.name
            );
        }
    }
}
