//! `armbridge doctor`: checks this machine for the needs of each job, with remedies.
//!
//! Nothing is changed and no device is opened: opening a serial port can reset what is
//! behind it.

mod tools;

use std::fmt;
use std::fs::{self, File};
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use armbridge::config::Config;
use armbridge::device_permissions;
use armbridge::finding::Finding;
use armbridge_client::stdio::Stdout;
use clap::builder::PossibleValue;
use clap::{Args, ValueEnum};
use ratatui::crossterm::terminal;
use serde_json::{Value, json};

use super::Outcome;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge doctor                the simulated arm, and all that is optional
  armbridge doctor emulate        fails unless the firmware can be emulated
  armbridge doctor usb flash --json

Exit codes: 0 the simulated arm and the named jobs can run, 1 something that
they need is missing or stale.";

/// Smallest terminal that the dashboard and the tables fit: columns and lines.
const TERMINAL: (u16, u16) = (80, 24);

/// The jobs that must be possible.
#[derive(Args, Debug)]
pub(crate) struct DoctorArgs {
    /// Jobs that must be possible, besides a simulated run.
    #[arg(value_enum, value_name = "JOB")]
    jobs: Vec<Job>,
    /// Print one JSON object instead of the table.
    #[arg(long)]
    json: bool,
}

/// A job with needs of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Job {
    /// Simulated runs, with logs and plots.
    Run,
    /// The dashboard.
    Watch,
    /// The firmware image in QEMU.
    Emulate,
    /// A board or servos at a serial port.
    Serial,
    /// A board's control pipes on USB.
    Usb,
    /// Firmware on a board, by a debug probe.
    Flash,
    /// Logs exported as Parquet.
    Parquet,
    /// The server for viewers.
    Foxglove,
    /// Log lines of an emulated board.
    Defmt,
}

impl fmt::Display for Job {
    /// Its name on the command line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let value = self.to_possible_value();
        f.write_str(value.as_ref().map_or("", PossibleValue::get_name))
    }
}

/// One thing that jobs need.
struct Check {
    name: &'static str,
    job: Job,
    result: Finding,
}

pub(crate) fn run(args: &DoctorArgs) -> Outcome {
    let checks = [
        (Job::Run, "output folder", output_folder()?),
        (Job::Watch, "terminal", terminal_size()),
        (Job::Emulate, "QEMU", tools::qemu()),
        (Job::Emulate, "firmware image", tools::image()),
        (Job::Flash, "Rust target", tools::rust_target()),
        (Job::Flash, "probe-rs", tools::probe_rs()),
        (
            Job::Serial,
            "serial ports",
            device_permissions::serial_ports(),
        ),
        (
            Job::Usb,
            "USB permission",
            device_permissions::usb_permission(),
        ),
        (
            Job::Parquet,
            "Parquet files",
            part("parquet", cfg!(feature = "parquet")),
        ),
        (
            Job::Foxglove,
            "viewer server",
            part("foxglove", cfg!(feature = "foxglove")),
        ),
        (
            Job::Defmt,
            "board log lines",
            part("defmt", cfg!(feature = "defmt")),
        ),
    ];
    let checks = checks.map(|(job, name, result)| Check { name, job, result });
    let is_missing = |check: &&Check| check.result.parts().2.is_some();
    let is_asked = |check: &&Check| check.job == Job::Run || args.jobs.contains(&check.job);
    let needed = checks.iter().filter(is_asked).find(is_missing);
    let mut out = Stdout;
    if args.json {
        let rows: Vec<Value> = checks.iter().map(as_json).collect();
        writeln!(out, "{}", json!({ "ok": needed.is_none(), "checks": rows }))?;
        return Ok(ExitCode::from(u8::from(needed.is_some())));
    }
    print_row(&mut out, ["check", "needed for", "state", "finding"])?;
    checks.iter().try_for_each(|check| print(&mut out, check))?;
    match needed {
        None => writeln!(out, "\nThe simulated arm can run: `armbridge run`.")?,
        Some(check) => {
            let (state, ..) = check.result.parts();
            writeln!(out, "\n{} is {state} for {}.", check.name, check.job)?;
        }
    }
    Ok(ExitCode::from(u8::from(needed.is_some())))
}

fn print_row(out: &mut impl Write, row: [&str; 4]) -> std::io::Result<()> {
    let [check, job, state, finding] = row;
    writeln!(out, "{check:<16}{job:<12}{state:<9}{finding}")
}

/// A line, and lines with the remedy.
fn print(out: &mut impl Write, check: &Check) -> std::io::Result<()> {
    let job = check.job.to_string();
    let (state, text, remedy) = check.result.parts();
    print_row(out, [check.name, &job, state, text])?;
    let mut lines = remedy.unwrap_or_default().lines();
    lines.try_for_each(|line| writeln!(out, "    {line}"))
}

fn as_json(check: &Check) -> Value {
    let (state, text, remedy) = check.result.parts();
    json!({
        "check": check.name,
        "needed_for": check.job.to_string(),
        "state": state,
        "finding": text,
        "remedy": remedy,
    })
}

/// Whether a run's folder can be made where the configuration puts it.
fn output_folder() -> Result<Finding, super::Error> {
    let folder = Config::discover()?.out(None);
    let there = std::path::absolute(&folder)?;
    let existing = there.ancestors().find(|folder| folder.is_dir());
    let written = write_probe(existing.unwrap_or(&there));
    let shown = folder.display();
    Ok(match written {
        Ok(()) => Finding::Ok(format!("{shown} can be written")),
        Err(error) => Finding::missing(
            format!("{shown} cannot be written: {error}"),
            "name another folder: `--out FOLDER`, or ARMBRIDGE_OUT",
        ),
    })
}

/// Writes a file into a folder and removes it.
fn write_probe(folder: &Path) -> std::io::Result<()> {
    let file: PathBuf = folder.join(format!(".armbridge-doctor-{}", std::process::id()));
    let written = File::create_new(&file)?.write_all(b"writable");
    // Even if the disk is full.
    let removed = fs::remove_file(file);
    written.and(removed)
}

/// A part of the program that a build has only if it is asked for.
fn part(feature: &str, is_built: bool) -> Finding {
    if is_built {
        return Finding::Ok("in this build".into());
    }
    Finding::missing(
        "left out of this build",
        format!("cargo build --release --features {feature}"),
    )
}

fn terminal_size() -> Finding {
    if !std::io::stdout().is_terminal() {
        return Finding::Open("standard output is no terminal".into());
    }
    match terminal::size() {
        Ok((columns, lines)) if columns >= TERMINAL.0 && lines >= TERMINAL.1 => {
            Finding::Ok(format!("{columns} columns, {lines} lines"))
        }
        Ok((columns, lines)) => Finding::missing(
            format!("{columns} columns, {lines} lines"),
            format!("enlarge it to {} columns, {} lines", TERMINAL.0, TERMINAL.1),
        ),
        Err(error) => Finding::Open(format!("its size is not known: {error}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_that_was_left_out_is_named_with_the_build_that_has_it() {
        let left_out = part("parquet", false);
        let (state, text, remedy) = left_out.parts();
        assert_eq!((state, text), ("missing", "left out of this build"));
        assert_eq!(remedy, Some("cargo build --release --features parquet"));
        assert_eq!(part("parquet", true).parts().0, "ok");
    }
}
