//! `armbridge plot`: figures of a log, or of two logs over each other.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use armbridge_analysis::plot;
use armbridge_analysis::plot::{Figure, Formats};
use armbridge_analysis::run_folder::DEFAULT_BASE;
use armbridge_client::stdio;
use armbridge_client::stdio::Stdout;
use armbridge_log::inspect::Log;
use armbridge_log::log_path::find;
use armbridge_log::recording::ReadError;
use clap::{Args, ValueEnum};

use super::Outcome;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge plot
  armbridge plot run.mcap --what tracking,spectrum --from 2 --to 6 --format svg
  armbridge plot --compare before.mcap after.mcap --out compared

Times are in s after the first tick of the log; compared runs are aligned where the arm
is first driven.";

/// A log to draw.
#[derive(Args, Debug)]
pub(crate) struct PlotArgs {
    /// Log, or run folder with a run.mcap; by default the newest run.
    #[arg(value_name = "LOG")]
    pub(crate) log: Option<PathBuf>,
    /// Draw two logs over each other, and their difference.
    #[arg(long, num_args = 2, value_names = ["A", "B"], conflicts_with_all = ["log", "what", "from", "to"])]
    pub(crate) compare: Option<Vec<PathBuf>>,
    /// Figures to draw.
    #[arg(
        long,
        value_name = "WHAT,WHAT",
        value_delimiter = ',',
        default_value = "all"
    )]
    pub(crate) what: Vec<FigureName>,
    /// Folder to write to [default: that of the log].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Leave out ticks before this time.
    #[arg(long, value_name = "S")]
    pub(crate) from: Option<f64>,
    /// Leave out ticks after this time.
    #[arg(long, value_name = "S")]
    pub(crate) to: Option<f64>,
    /// File formats.
    #[arg(
        long,
        value_name = "svg,png",
        value_delimiter = ',',
        default_value = "svg,png"
    )]
    pub(crate) format: Vec<Picture>,
}

/// File formats of figures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Picture {
    /// For print and editing.
    Svg,
    /// For everything else.
    Png,
}

/// Figures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum FigureName {
    /// Encoder, estimate and setpoint of both joints.
    Angles,
    /// Estimate minus reference.
    Tracking,
    /// Torque and PWM.
    Torque,
    /// Speed over angle.
    Phase,
    /// Start delay and duration of ticks.
    Timing,
    /// Power spectra of error, torque and innovation.
    Spectrum,
    /// Every figure.
    All,
}

pub(crate) fn run(args: &PlotArgs) -> Outcome {
    let formats = Formats {
        svg: args.format.contains(&Picture::Svg),
        png: args.format.contains(&Picture::Png),
    };
    let files = match args.compare.as_deref() {
        Some([a, b]) => {
            let [first, second] = [load(Some(a))?, load(Some(b))?];
            for log in [&first, &second] {
                is_driven(log)?;
            }
            plot::compare(&folder(args, &first)?, formats, &first, &second)?
        }
        Some(_) => return Err("--compare takes two logs".into()),
        None => {
            let log = load(args.log.as_deref())?;
            window(args, &log)?;
            plot::draw(
                &folder(args, &log)?,
                &figures(&args.what),
                formats,
                &log.head.facts,
                &log.records,
                [args.from, args.to],
            )?
        }
    };
    let mut out = Stdout;
    for file in files {
        writeln!(out, "{}", file.display()).map_err(|error| format!("cannot print: {error}"))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn load(path: Option<&Path>) -> Result<Log, ReadError> {
    let log = Log::load(&find(path, Path::new(DEFAULT_BASE))?)?;
    for damage in &log.head.damage {
        stdio::note(format_args!("{}: {damage}", log.head.path.display()));
    }
    Ok(log)
}

/// Checks that a run can be compared with another.
fn is_driven(log: &Log) -> Result<(), String> {
    log.driven_from().map(|_| ()).ok_or_else(|| {
        let path = log.head.path.display();
        format!(
            "in {path} the arm is never driven, so it cannot be compared with another run; plot it \
             by itself"
        )
    })
}

/// Checks that there are ticks between the requested times.
fn window(args: &PlotArgs, log: &Log) -> Result<(), String> {
    let path = log.head.path.display();
    let [first, .., last] = log.records.as_slice() else {
        return Err(format!(
            "{path} has no ticks to draw; `armbridge info` shows its contents"
        ));
    };
    let end_s = last.start_us.saturating_sub(first.start_us) as f64 * 1e-6;
    let (from, to) = (args.from.unwrap_or(0.0), args.to.unwrap_or(end_s));
    // After a reset the board's clock begins anew: then any time may be within.
    if (from < to && to > 0.0 && from < end_s) || last.start_us < first.start_us {
        return Ok(());
    }
    Err(format!(
        "nothing lies between --from {from} and --to {to} s: {path} lasts from 0 to {end_s:.3} s"
    ))
}

fn figures(names: &[FigureName]) -> Vec<Figure> {
    let figure = |name: &FigureName| match name {
        FigureName::Angles => vec![Figure::Angles],
        FigureName::Tracking => vec![Figure::Tracking],
        FigureName::Torque => vec![Figure::Torque],
        FigureName::Phase => vec![Figure::Phase],
        FigureName::Timing => vec![Figure::Timing],
        FigureName::Spectrum => vec![Figure::Spectrum],
        FigureName::All => Figure::ALL.to_vec(),
    };
    let requested: Vec<Figure> = names.iter().flat_map(figure).collect();
    // Each once, in their order.
    let figures = Figure::ALL.into_iter();
    figures
        .filter(|figure| requested.contains(figure))
        .collect()
}

/// Folder to write to.
fn folder(args: &PlotArgs, log: &Log) -> Result<PathBuf, String> {
    let beside = log.head.path.parent().map(Path::to_path_buf);
    let folder = args.out.clone().or(beside).unwrap_or_default();
    // A log in this folder has none in its name.
    if folder.as_os_str().is_empty() {
        return Ok(PathBuf::from("."));
    }
    std::fs::create_dir_all(&folder).map_err(|error| {
        let folder = folder.display();
        format!("cannot make the folder {folder}: {error}; choose another place with --out")
    })?;
    Ok(folder)
}
