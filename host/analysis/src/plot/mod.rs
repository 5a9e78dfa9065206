//! Plots of a run, each as SVG and PNG. The paper's figures use the same
//! panels and drawings.
//!
//! | figure     | shows                                                         |
//! |------------|---------------------------------------------------------------|
//! | `angles`   | samples, estimate and setpoint of both joints                 |
//! | `tracking` | estimate minus reference, with the settling band              |
//! | `torque`   | torque decided and sent, with the servos' limits              |
//! | `path`     | angle of joint 2 over that of joint 1, on equal scales        |
//! | `phase`    | speed over angle of both joints                               |
//! | `timing`   | start error, bus time and compute time of every tick, counted |
//! | `spectrum` | power of error, torque and innovation over frequency          |
//! | `difference` | angles of several runs minus those of the first             |
//!
//! All but `timing` exist for several runs as well, over each other; the legend names their
//! differences. [`draw_preview`] draws a planned run, `preview`. Time is in s after the first
//! armed tick, as in the summary, see [`time_origin`](armbridge_log::time_origin). Missing
//! records make a gap.
//!
//! ```text
//! log --events--> Collector: visible ticks, traces, spectra, counts --> Run --> Drawing --> file
//! ```

mod angles;
pub mod axis;
mod collector;
mod decimate;
mod difference;
pub mod drawing;
mod labels;
mod marks;
pub mod panel;
mod path;
mod phase;
mod png;
mod preview;
mod reduce;
mod rms;
mod run;
mod several;
mod spectrum;
mod svg;
#[cfg(test)]
mod tests;
mod text;
mod timing;
mod torque;
mod trace;
mod tracking;
mod welch;

pub use png::RasterError;
pub use preview::draw_preview;

use std::path::{Path, PathBuf};

use armbridge_link::message::Record;
use armbridge_log::output_file::{self, Existing};
use armbridge_log::recording::ReadError;
use armbridge_log::run_info::RunFacts;

pub use run::Run;

use drawing::{Anchor, Drawing, Font};
use panel::{INK, MUTED};

/// Width of every figure in px.
pub(crate) const WIDTH: f64 = 1040.0;

/// Failure to draw the plots.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    /// A log cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The name of a file has an ending of no format.
    #[error("expected a file ending in .svg or .png, or a name without an ending for both")]
    Format,
    /// A file cannot be written.
    #[error("cannot write {path}: {source}", path = path.display())]
    Write {
        /// File being written.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The drawing could not be rendered.
    #[error("cannot draw {path}: {source}", path = path.display())]
    Raster {
        /// File being drawn.
        path: PathBuf,
        /// Cause.
        source: RasterError,
    },
}

/// A figure of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Figure {
    /// Samples, estimate and setpoint.
    Angles,
    /// Estimate minus reference.
    Tracking,
    /// Torque and PWM.
    Torque,
    /// Angle of joint 2 over that of joint 1.
    Path,
    /// Speed over angle.
    Phase,
    /// Start error, bus time and compute time of each tick.
    Timing,
    /// Power of error, torque and innovation over frequency.
    Spectrum,
    /// Angles of runs minus those of the first.
    Difference,
}

impl Figure {
    /// All figures.
    pub const ALL: [Self; 8] = [
        Self::Angles,
        Self::Tracking,
        Self::Torque,
        Self::Path,
        Self::Phase,
        Self::Timing,
        Self::Spectrum,
        Self::Difference,
    ];

    /// Name of the figure's files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Angles => "angles",
            Self::Tracking => "tracking",
            Self::Torque => "torque",
            Self::Path => "path",
            Self::Phase => "phase",
            Self::Timing => "timing",
            Self::Spectrum => "spectrum",
            Self::Difference => "difference",
        }
    }

    /// The figure of one run, or of several; none if it does not exist for so many.
    fn draw(self, runs: &[Run]) -> Result<Option<Drawing>, ReadError> {
        let [run] = runs else {
            return several::draw(self, runs);
        };
        Ok(match self {
            Self::Angles => Some(angles::draw(run)),
            Self::Tracking => Some(tracking::draw(run)),
            Self::Torque => Some(torque::draw(run)),
            Self::Path => Some(path::draw(run)),
            Self::Phase => Some(phase::draw(run)),
            Self::Timing => Some(timing::draw(run)),
            Self::Spectrum => Some(spectrum::draw(run)),
            Self::Difference => None,
        })
    }
}

/// File formats written for each figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Formats {
    /// SVG, for print and editing.
    pub svg: bool,
    /// PNG, for everything else.
    pub png: bool,
}

impl Formats {
    /// Both formats.
    pub const ALL: Self = Self {
        svg: true,
        png: true,
    };

    /// Formats of a file by the ending of its name: both for one without.
    ///
    /// # Errors
    /// If the ending is another.
    pub fn of_file(path: &Path) -> Result<Self, PlotError> {
        let ending = path.extension().map(std::ffi::OsStr::to_ascii_lowercase);
        match ending.as_deref().map(|ending| ending.to_string_lossy()) {
            None => Ok(Self::ALL),
            Some(ending) if ending == "svg" => Ok(Self {
                png: false,
                ..Self::ALL
            }),
            Some(ending) if ending == "png" => Ok(Self {
                svg: false,
                ..Self::ALL
            }),
            Some(_) => Err(PlotError::Format),
        }
    }
}

/// Figures of a run folder.
const RUN_FIGURES: [Figure; 3] = [Figure::Angles, Figure::Torque, Figure::Timing];

/// Draws the figures of a run beside its log, with its baseline, if there is one; returns the
/// files, SVG before PNG. [`draw`] makes the same files of the same log.
///
/// # Errors
/// If the log cannot be read, a file cannot be written or a drawing cannot be rendered.
pub fn draw_run(log: &Path) -> Result<Vec<PathBuf>, PlotError> {
    let run = Run::read_with_baseline(log, [None; 2])?;
    let folder = log.parent().unwrap_or(Path::new(""));
    draw(folder, &RUN_FIGURES, Formats::ALL, Existing::Number, &[run])
}

/// Draws the figures of a run folder from records in memory; returns the files, SVG before PNG.
///
/// # Errors
/// If a file cannot be written or a drawing cannot be rendered.
pub fn draw_all(
    folder: &Path,
    existing: Existing,
    facts: &RunFacts,
    records: &[Record],
) -> Result<Vec<PathBuf>, PlotError> {
    let run = Run::of_records(facts, records);
    draw(folder, &RUN_FIGURES, Formats::ALL, existing, &[run])
}

/// Draws figures of one run, or of several over each other, into a folder. Figures of one run
/// only are left out for several, and the other way round. Returns the files, SVG before PNG.
///
/// # Errors
/// If a file cannot be written or a drawing cannot be rendered.
pub fn draw(
    folder: &Path,
    figures: &[Figure],
    formats: Formats,
    existing: Existing,
    runs: &[Run],
) -> Result<Vec<PathBuf>, PlotError> {
    let several = if runs.len() > 1 { "compare-" } else { "" };
    let mut files = Vec::new();
    // One by one: the pixels of a figure take more memory than an hour's run.
    for figure in figures {
        if let Some(drawing) = figure.draw(runs)? {
            let name = format!("{several}{}", figure.name());
            files.extend(write_figure(folder, formats, existing, &name, &drawing)?);
        }
    }
    Ok(files)
}

/// Writes named drawings into a folder, as SVG and PNG; files that exist are kept.
///
/// # Errors
/// [`PlotError`] of the file that cannot be written.
pub fn write_all<N: AsRef<str>>(
    folder: &Path,
    figures: impl IntoIterator<Item = (N, Drawing)>,
) -> Result<Vec<PathBuf>, PlotError> {
    write_as(folder, Formats::ALL, Existing::Number, figures)
}

/// Writes named drawings into a folder; returns the files, SVG before PNG.
pub(crate) fn write_as<N: AsRef<str>>(
    folder: &Path,
    formats: Formats,
    existing: Existing,
    figures: impl IntoIterator<Item = (N, Drawing)>,
) -> Result<Vec<PathBuf>, PlotError> {
    let mut files = Vec::new();
    for (name, drawing) in figures {
        files.extend(write_figure(
            folder,
            formats,
            existing,
            name.as_ref(),
            &drawing,
        )?);
    }
    Ok(files)
}

/// Writes a drawing into a folder; returns the files.
fn write_figure(
    folder: &Path,
    formats: Formats,
    existing: Existing,
    name: &str,
    drawing: &Drawing,
) -> Result<Vec<PathBuf>, PlotError> {
    let mut files = Vec::new();
    if formats.svg {
        let path = folder.join(format!("{name}.svg"));
        files.push(write(&path, drawing.svg().as_bytes(), existing)?);
    }
    if formats.png {
        let path = folder.join(format!("{name}.png"));
        let pixels = png::png(drawing).map_err(|source| PlotError::Raster {
            path: path.clone(),
            source,
        })?;
        files.push(write(&path, &pixels, existing)?);
    }
    Ok(files)
}

/// Writes a file; returns its path, which may have a number.
pub(crate) fn write(path: &Path, bytes: &[u8], existing: Existing) -> Result<PathBuf, PlotError> {
    output_file::write(path, bytes, existing).map_err(|source| PlotError::Write {
        path: path.to_path_buf(),
        source,
    })
}

/// Empty figure of a run with its title.
fn figure(height: f64, title: &str, facts: &RunFacts) -> Drawing {
    let title = format!("{title} · armbridge {}", facts.name);
    titled(height, &title, &facts.describe())
}

/// Empty figure with a title and a note beside it.
pub fn titled(height: f64, title: &str, about: &str) -> Drawing {
    let mut drawing = Drawing::new(WIDTH, height);
    let bold = Font {
        size: 17.0,
        bold: true,
        colour: INK,
        anchor: Anchor::Start,
    };
    drawing.text((24.0, 32.0), title, bold, false);
    let light = Font {
        size: 12.5,
        bold: false,
        colour: MUTED,
        anchor: Anchor::End,
    };
    drawing.text((WIDTH - 24.0, 32.0), about, light, false);
    drawing
}
