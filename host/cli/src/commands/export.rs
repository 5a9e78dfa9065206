//! `armbridge export`: a log in another program's format, or the arm for a simulator.

mod arm;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use armbridge_client::{ctrl_c, stdio};
use armbridge_log::export::Format;
use armbridge_log::inspect::{Head, log as inspect};
use armbridge_log::output_file::OutputFile;
use armbridge_log::{export, output_file};
use armbridge_sim::plant::robot_description::RobotFormat;
use clap::{Args, ValueEnum};

use super::{Outcome, log};
use crate::args::ForceArgs;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge export csv
  armbridge export parquet run.mcap --out run.parquet
  armbridge export mat run.mcap
  armbridge export csv --out - | head -3
  armbridge export mjcf arm.toml            the arm of identify fit --out

In Python:   pandas.read_parquet('run.parquet')
In MATLAB:   load run.mat; plot(log.time_s, log.angle_rad_1)";

/// A log to convert, or an arm.
#[derive(Args, Debug)]
pub(crate) struct ExportArgs {
    /// File format.
    pub(crate) format: FormatName,
    /// Log, or run folder with a run.mcap; by default the newest run. For mjcf and urdf, whose
    /// arm is that of the board's settings, also a file with parameters, or a virtual arm.
    #[arg(value_name = "LOG")]
    pub(crate) log: Option<PathBuf>,
    /// File to write, with the ending of the format, or - to print csv, mjcf or urdf [default:
    /// beside the log, with a number if there is another one].
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
}

/// Formats of exported files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum FormatName {
    /// One row per tick, units in the header.
    Csv,
    #[value(help = "Columns for pandas, polars, DuckDB")]
    Parquet,
    /// Named fields for MATLAB and Octave.
    Mat,
    #[value(help = "The arm as a model of MuJoCo")]
    Mjcf,
    /// The arm as a robot description.
    Urdf,
}

pub(crate) fn run(args: &ExportArgs) -> Outcome {
    match args.format {
        FormatName::Csv => export_log(args, Format::Csv),
        FormatName::Parquet => export_log(args, Format::Parquet),
        FormatName::Mat => export_log(args, Format::Mat),
        FormatName::Mjcf => arm::run(args, RobotFormat::Mjcf),
        FormatName::Urdf => arm::run(args, RobotFormat::Urdf),
    }
}

fn export_log(args: &ExportArgs, format: Format) -> Outcome {
    if let Some(out) = &args.out {
        check_ending(out, format)?;
    }
    let log = log::find(args.log.as_deref())?;
    let beside = || log.with_extension(format.extension());
    let out = args.out.clone().unwrap_or_else(beside);
    let is_printed = output_file::is_stdout(&out);
    ctrl_c::listen()?;
    let file = OutputFile::create(&out, args.force.existing(args.out.as_ref()));
    let file = file.map_err(|error| {
        let out = out.display();
        format!("cannot write {out}: {error}; or choose another place with --out")
    })?;
    let file = file.interrupted_by(ctrl_c::is_raised);
    // Read to its end first: its damage is exported, too.
    let head = Head::read(&log, |_| ())?;
    // Rows that are read without being written end as well.
    let rows = || Ok(inspect::rows(&log)?.take_while(|_| !ctrl_c::is_raised()));
    let (out, ticks) = export::write(format, file, &head.about(), rows)?;
    for damage in &head.damage {
        stdio::note(format_args!("{}: {damage}", log.display()));
    }
    if !is_printed {
        let megabytes = out.metadata().map_or(0.0, |file| file.len() as f64 / 1e6);
        let out = out.display();
        stdio::print_line(format_args!("{out} · {ticks} ticks, {megabytes:.1} MB"))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Checks that a file's name ends as its format does: programs go by the ending.
fn check_ending(out: &Path, format: Format) -> Result<(), String> {
    if output_file::is_stdout(out) {
        return match format {
            Format::Csv => Ok(()),
            Format::Parquet | Format::Mat => Err(format!(
                "only csv can be printed; name a file ending in .{}",
                format.extension()
            )),
        };
    }
    let ending = out.extension().and_then(std::ffi::OsStr::to_str);
    let others = [Format::Csv, Format::Parquet, Format::Mat].map(Format::extension);
    let other = ending.filter(|ending| {
        !ending.eq_ignore_ascii_case(format.extension())
            && (others
                .iter()
                .any(|other| ending.eq_ignore_ascii_case(other))
                || ending.eq_ignore_ascii_case("mcap"))
    });
    other.map_or(Ok(()), |ending| {
        Err(format!(
            "{} ends in .{ending}, but the format is {}; name a file ending in .{1}",
            out.display(),
            format.extension()
        ))
    })
}
