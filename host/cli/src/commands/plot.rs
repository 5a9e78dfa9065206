//! `armbridge plot`: figures of a log, or of several logs over each other.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use armbridge_analysis::plot;
use armbridge_analysis::plot::{Figure, Formats, Run};
use armbridge_client::{ctrl_c, stdio};
use armbridge_log::inspect::diff::DiffError;
use armbridge_log::output_file::Existing;
use armbridge_log::time_origin::Align;
use clap::{Args, ValueEnum};

use super::interruptible::interruptible;
use super::{Outcome, log};

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge plot
  armbridge plot run.mcap --what tracking,spectrum --from 2 --to 6 --format svg
  armbridge plot before.mcap after.mcap --align setpoint --out compared

Times are in s after the first armed tick. Several runs are aligned where the
arm is first driven, or at another event, and drawn over each other as
compare-angles and so on. A file of the same name and other contents is kept:
the new one is angles-2.svg.";

/// Logs to draw.
#[derive(Args, Clone, Debug)]
pub(crate) struct PlotArgs {
    /// Logs, or run folders with a run.mcap; by default the newest run. Several are drawn over
    /// each other.
    #[arg(value_name = "LOG")]
    pub(crate) logs: Vec<PathBuf>,
    /// Event at which the times of several runs are aligned.
    #[arg(long, value_name = "EVENT", default_value = "drive")]
    pub(crate) align: AlignName,
    /// Figures to draw.
    #[arg(
        long,
        value_name = "WHAT,WHAT",
        value_delimiter = ',',
        default_value = "all"
    )]
    pub(crate) what: Vec<FigureName>,
    /// Folder to write to [default: that of the first log].
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

/// Events at which runs are aligned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum AlignName {
    /// First tick in which the motors are driven.
    Drive,
    /// First change of the reference after that.
    Setpoint,
    /// First armed tick.
    Start,
}

impl From<AlignName> for Align {
    fn from(name: AlignName) -> Self {
        match name {
            AlignName::Drive => Self::Drive,
            AlignName::Setpoint => Self::Setpoint,
            AlignName::Start => Self::Start,
        }
    }
}

/// Figures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum FigureName {
    /// Encoder, estimate and setpoint of both joints.
    Angles,
    /// Estimate minus reference.
    Tracking,
    /// Torque decided and sent.
    Torque,
    /// Angle of joint 2 over that of joint 1.
    Path,
    /// Speed over angle.
    Phase,
    /// Start delay and duration of ticks.
    Timing,
    /// Power spectra of error, torque and innovation.
    Spectrum,
    /// Angles of several runs minus those of the first.
    Difference,
    /// Every figure.
    All,
}

pub(crate) fn run(args: &PlotArgs) -> Outcome {
    let formats = Formats {
        svg: args.format.contains(&Picture::Svg),
        png: args.format.contains(&Picture::Png),
    };
    let reading = args.clone();
    let runs = interruptible("the logs were read; nothing is drawn", move || {
        // An error that may go to another thread.
        runs(&reading).map_err(|error| error.to_string())
    })??;
    let folder = folder(args, &runs)?;
    let mut count = 0;
    for figure in figures(&args.what) {
        if ctrl_c::is_raised() {
            let signal = ctrl_c::in_words();
            return Err(format!("ended by {signal} after {count} files").into());
        }
        let files = plot::draw(&folder, &[figure], formats, Existing::Number, &runs)?;
        count += files.len();
        for file in files {
            stdio::print_line(file.display())?;
        }
    }
    if count == 0 {
        return Err("timing is a figure of one run, and difference one of several".into());
    }
    Ok(ExitCode::SUCCESS)
}

/// Reads the runs; the times of several are aligned.
fn runs(args: &PlotArgs) -> Result<Vec<Run>, Box<dyn std::error::Error>> {
    if let [] | [_] = args.logs.as_slice() {
        let path = log::find(args.logs.first().map(PathBuf::as_path))?;
        return Ok(vec![read(args, &path, 0.0)?]);
    }
    let mut runs = Vec::new();
    for log in &args.logs {
        let path = log::find(Some(log))?;
        let run = Run::read(&path, [None; 2])?;
        let event = args.align.into();
        let zero_s = run.time_of(event);
        let zero_s = zero_s.ok_or(DiffError::NoEvent { path, event })?;
        // The window is known once the event is.
        let run = match (args.from, args.to) {
            (None, None) => run,
            _ => read(args, &run.path, zero_s)?,
        };
        runs.push(run.shifted(zero_s));
    }
    Ok(runs)
}

/// Reads a log in the requested window, whose times count from `zero_s`.
fn read(args: &PlotArgs, path: &Path, zero_s: f64) -> Result<Run, Box<dyn std::error::Error>> {
    let window_s = [args.from, args.to].map(|end_s| end_s.map(|end_s| end_s + zero_s));
    let run = if args.logs.len() > 1 {
        Run::read(path, window_s)?
    } else {
        Run::read_with_baseline(path, window_s)?
    };
    let path = path.display();
    for damage in &run.damage {
        stdio::note(format_args!("{path}: {damage}"));
    }
    let Some([begin_s, end_s]) = run.covered_s else {
        let why = format!("{path} has no ticks to draw; `armbridge info` shows its contents");
        return Err(why.into());
    };
    let (from, to) = (args.from.unwrap_or(0.0), args.to.unwrap_or(end_s - zero_s));
    if from < to && from + zero_s <= end_s && to + zero_s >= begin_s {
        return Ok(run);
    }
    let why = format!(
        "nothing lies between --from {from} and --to {to} s: {path} lasts from {:.3} to {:.3} s",
        begin_s - zero_s,
        end_s - zero_s
    );
    Err(why.into())
}

fn figures(names: &[FigureName]) -> Vec<Figure> {
    let figure = |name: &FigureName| match name {
        FigureName::Angles => vec![Figure::Angles],
        FigureName::Tracking => vec![Figure::Tracking],
        FigureName::Torque => vec![Figure::Torque],
        FigureName::Path => vec![Figure::Path],
        FigureName::Phase => vec![Figure::Phase],
        FigureName::Timing => vec![Figure::Timing],
        FigureName::Spectrum => vec![Figure::Spectrum],
        FigureName::Difference => vec![Figure::Difference],
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
fn folder(args: &PlotArgs, runs: &[Run]) -> Result<PathBuf, String> {
    let beside = runs.first().and_then(|run| run.path.parent());
    let beside = beside.map(Path::to_path_buf);
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
