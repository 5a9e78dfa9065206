//! The command line of what looks at logs: `info`, `plot`, `export`, `diff`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

pub(crate) const INFO_EXAMPLES: &str = "\
Examples:
  armbridge info
  armbridge info runs/2026-11-21T10-55-00Z-demo
  armbridge info run.mcap --json";

pub(crate) const PLOT_EXAMPLES: &str = "\
Examples:
  armbridge plot
  armbridge plot run.mcap --what tracking,spectrum --from 2 --to 6 --format svg
  armbridge plot --compare before.mcap after.mcap --out compared

Times are in s after the first tick of the log; runs that are compared begin where
the arm is first driven.";

pub(crate) const EXPORT_EXAMPLES: &str = "\
Examples:
  armbridge export csv
  armbridge export parquet run.mcap --out run.parquet
  armbridge export mat run.mcap

In Python:   pandas.read_parquet('run.parquet')
In MATLAB:   load run.mat; plot(log.time_s, log.angle_rad)";

pub(crate) const DIFF_EXAMPLES: &str = "\
Examples:
  armbridge diff runs/before runs/after
  armbridge diff a.mcap b.mcap --json

Exit codes: 0 the same, 1 they differ.";

/// A log to tell of.
#[derive(Args, Debug)]
pub(crate) struct InfoArgs {
    /// Log, or run folder with a run.mcap; by default the newest run.
    #[arg(value_name = "LOG")]
    pub(crate) log: Option<PathBuf>,
    /// Print one JSON object instead of the text.
    #[arg(long)]
    pub(crate) json: bool,
}

/// A log to draw.
#[derive(Args, Debug)]
pub(crate) struct PlotArgs {
    /// Log, or run folder with a run.mcap; by default the newest run.
    #[arg(value_name = "LOG")]
    pub(crate) log: Option<PathBuf>,
    /// Draw two logs on top of each other, and their difference.
    #[arg(long, num_args = 2, value_names = ["A", "B"], conflicts_with_all = ["log", "what", "from", "to"])]
    pub(crate) compare: Option<Vec<PathBuf>>,
    /// What to draw.
    #[arg(
        long,
        value_name = "WHAT,WHAT",
        value_delimiter = ',',
        default_value = "all"
    )]
    pub(crate) what: Vec<What>,
    /// Folder to write to; by default that of the log.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Leave out what is before this time.
    #[arg(long, value_name = "S")]
    pub(crate) from: Option<f64>,
    /// Leave out what is after this time.
    #[arg(long, value_name = "S")]
    pub(crate) to: Option<f64>,
    /// Kinds of files.
    #[arg(
        long,
        value_name = "svg,png",
        value_delimiter = ',',
        default_value = "svg,png"
    )]
    pub(crate) format: Vec<Picture>,
}

/// Kinds of picture files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Picture {
    /// For print and editing.
    Svg,
    /// For everything else.
    Png,
}

/// Figures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum What {
    /// Encoder, estimate and setpoint of both joints.
    Angles,
    /// Estimate minus reference.
    Tracking,
    /// Torque and PWM.
    Torque,
    /// Speed over angle.
    Phase,
    /// How late ticks began, and what they took.
    Timing,
    /// Power of error, torque and innovation over frequency.
    Spectrum,
    /// Every figure.
    All,
}

/// A log to convert.
#[derive(Args, Debug)]
pub(crate) struct ExportArgs {
    /// Kind of file.
    pub(crate) format: FormatName,
    /// Log, or run folder with a run.mcap; by default the newest run.
    #[arg(value_name = "LOG")]
    pub(crate) log: Option<PathBuf>,
    /// File to write; by default beside the log.
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

/// Two logs to compare.
#[derive(Args, Debug)]
pub(crate) struct DiffArgs {
    /// A log, or run folder with a run.mcap.
    #[arg(value_name = "A")]
    pub(crate) a: PathBuf,
    /// Another.
    #[arg(value_name = "B")]
    pub(crate) b: PathBuf,
    /// Print one JSON object instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}
