//! `armbridge export`: a log in another program's format.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use armbridge_analysis::run_folder::DEFAULT_BASE;
use armbridge_log::export;
use armbridge_log::export::Format;
use armbridge_log::inspect::{Head, log};
use armbridge_log::log_path::find;
use clap::{Args, ValueEnum};

use super::Outcome;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge export csv
  armbridge export parquet run.mcap --out run.parquet
  armbridge export mat run.mcap

In Python:   pandas.read_parquet('run.parquet')
In MATLAB:   load run.mat; plot(log.time_s, log.angle_rad_1)";

/// A log to convert.
#[derive(Args, Debug)]
pub(crate) struct ExportArgs {
    /// File format.
    pub(crate) format: FormatName,
    /// Log, or run folder with a run.mcap; by default the newest run.
    #[arg(value_name = "LOG")]
    pub(crate) log: Option<PathBuf>,
    /// File to write [default: beside the log].
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
}

/// Formats of exported files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum FormatName {
    /// One row per tick, units in the header.
    Csv,
    /// Columns for pandas, polars, `DuckDB`.
    Parquet,
    /// Named fields for MATLAB and Octave.
    Mat,
}

pub(crate) fn run(args: &ExportArgs) -> Outcome {
    let format = match args.format {
        FormatName::Csv => Format::Csv,
        FormatName::Parquet => Format::Parquet,
        FormatName::Mat => Format::Mat,
    };
    let log = find(args.log.as_deref(), Path::new(DEFAULT_BASE))?;
    let out = out(args, &log, format)?;
    // Read to its end first: its damage is exported, too.
    let head = Head::read(&log, |_| ())?;
    let rows = || Ok(log::rows(&log)?);
    let ticks = export::write(format, &out, &head.about(), rows)?;
    for damage in &head.damage {
        eprintln!("{}: {damage}", log.display());
    }
    let megabytes = out.metadata().map_or(0.0, |file| file.len() as f64 / 1e6);
    let line = format!("{} · {ticks} ticks, {megabytes:.1} MB", out.display());
    writeln!(std::io::stdout(), "{line}").map_err(|error| format!("cannot print: {error}"))?;
    Ok(ExitCode::SUCCESS)
}

/// Path to write to.
fn out(args: &ExportArgs, log: &Path, format: Format) -> Result<PathBuf, String> {
    let beside = || log.with_extension(format.extension());
    let out = args.out.clone().unwrap_or_else(beside);
    if out == log {
        return Err(format!(
            "{} is the log itself; choose another file with --out",
            out.display()
        ));
    }
    Ok(out)
}
