//! `cargo verify`: everything that finds mistakes in a change, set-up included.
//!
//! Two lanes of steps run side by side, one for the host and one for the board: cargo
//! has a lock for each of their folders, and one lane compiles while the other waits for
//! a linker or a clock. Each step has a log file; the end of it is shown if the step
//! fails. Exit code 0: all passed; 1: a step failed; 2: wrong arguments.
//!
//! Host code is checked and tested in the dev profile, firmware in the profile of its
//! images, and cargo is always asked for the whole workspace: so no dependency is built
//! in two forms. Overflow checks are on.

#[cfg(test)]
mod first_build;
mod fuzz;
mod host;
mod images;
mod lanes;
mod miri;
mod mutations;
mod no_panic;
mod output;
mod outside;
mod packages;
mod paths;
mod python_package;
mod release;
mod setup;
mod steps;
mod tree_copy;
mod wine;

use std::process::ExitCode;

use steps::{CAMPAIGN, GATE, Step};

const USAGE: &str = "\
Set up what the tests need, then check, build and test everything.

usage: cargo verify [--campaign] [--only STEP.. | --list | --help]

  --campaign   the long tests instead: many more seeds, streams, faults and fuzzing
  --only STEP  these steps alone, one after the other, in the terminal
  --list       list the steps
  --help       print this help";

/// Time of the campaign, as measured.
const CAMPAIGN_TIME: &str = "an hour on two cores";

/// Action that the arguments ask for.
#[derive(Debug, PartialEq)]
enum Task {
    Help,
    List,
    Gate,
    Campaign,
    /// The steps with these names.
    Only(Vec<String>),
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match task(&arguments) {
        Ok(Task::Help) => println!("{USAGE}"),
        Ok(Task::List) => {
            for Step { name, what, .. } in GATE {
                println!("{name:<16}{what}");
            }
            println!("\nwith --campaign, {CAMPAIGN_TIME}:");
            for Step { name, what, .. } in CAMPAIGN {
                println!("{name:<16}{what}");
            }
        }
        Ok(Task::Gate) => return lanes::run(GATE),
        Ok(Task::Campaign) => {
            println!("cargo verify --campaign: {CAMPAIGN_TIME}");
            return lanes::run(CAMPAIGN);
        }
        Ok(Task::Only(names)) => return lanes::run_only(&names),
        Err(what) => {
            eprintln!("{what}\n\n{USAGE}");
            return ExitCode::from(2);
        }
    }
    ExitCode::SUCCESS
}

fn task(arguments: &[&str]) -> Result<Task, String> {
    match arguments {
        [] => Ok(Task::Gate),
        ["--campaign"] => Ok(Task::Campaign),
        ["--help" | "-h"] => Ok(Task::Help),
        ["--list"] => Ok(Task::List),
        ["--only"] => Err("--only needs the name of a step".to_owned()),
        ["--only", names @ ..] => {
            let unknown = names.iter().find(|name| steps::named(name).is_none());
            match unknown {
                Some(name) => Err(format!(
                    "unknown step `{name}`; `cargo verify --list` names all"
                )),
                None => Ok(Task::Only(names.iter().map(ToString::to_string).collect())),
            }
        }
        _ => Err(format!("unknown arguments `{}`", arguments.join(" "))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_are_understood_or_refused() {
        assert_eq!(task(&[]), Ok(Task::Gate));
        assert_eq!(task(&["--list"]), Ok(Task::List));
        assert_eq!(task(&["--campaign"]), Ok(Task::Campaign));
        let names = [GATE[0].name, CAMPAIGN[0].name];
        let only = Task::Only(names.map(str::to_owned).to_vec());
        assert_eq!(task(&["--only", names[0], names[1]]), Ok(only));
        for wrong in [
            &["--only"][..],
            &["--only", "nowhere"],
            &["x"],
            &["--list", "x"],
        ] {
            assert!(task(wrong).is_err(), "{wrong:?}");
        }
    }
}
