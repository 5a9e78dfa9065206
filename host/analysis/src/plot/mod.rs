//! Plots of a run, each as SVG and PNG. The [`paper`](crate::paper)'s figures use the same
//! panels and drawings.
//!
//! | figure     | shows                                                         |
//! |------------|---------------------------------------------------------------|
//! | `angles`   | samples, estimate and setpoint of both joints                 |
//! | `tracking` | estimate minus reference, with the settling band              |
//! | `torque`   | torque and PWM of both joints, with the servos' limits        |
//! | `phase`    | speed over angle of both joints                               |
//! | `timing`   | start error, bus time and compute time of every tick, counted |
//! | `spectrum` | power of error, torque and innovation over frequency          |
//!
//! [`draw_preview`] draws a planned run, `preview`; [`compare()`] overlays two runs. Time is
//! in s after the first record, as in the summary. Missing records make a gap.

mod angles;
pub(crate) mod axis;
mod compare;
mod decimate;
pub(crate) mod drawing;
pub(crate) mod panel;
mod phase;
mod png;
mod preview;
mod run;
mod spectrum;
mod svg;
mod text;
mod timing;
mod torque;
mod tracking;
mod welch;

pub use compare::compare;
pub use png::RasterError;
pub use preview::draw_preview;

use std::path::{Path, PathBuf};

use armbridge_log::output_file;
use armbridge_log::output_file::Existing;
use armbridge_log::run_info::RunFacts;
use armbridge_shared::link::message::Record;

use drawing::{Anchor, Drawing, Font};
use panel::{INK, MUTED};
use run::Run;

/// Width of every figure in px.
pub(crate) const WIDTH: f64 = 1040.0;

/// Failure to draw the plots.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
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
    /// Speed over angle.
    Phase,
    /// Start error, bus time and compute time of each tick.
    Timing,
    /// Power of error, torque and innovation over frequency.
    Spectrum,
}

impl Figure {
    /// All figures.
    pub const ALL: [Self; 6] = [
        Self::Angles,
        Self::Tracking,
        Self::Torque,
        Self::Phase,
        Self::Timing,
        Self::Spectrum,
    ];

    /// Name of the figure's files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Angles => "angles",
            Self::Tracking => "tracking",
            Self::Torque => "torque",
            Self::Phase => "phase",
            Self::Timing => "timing",
            Self::Spectrum => "spectrum",
        }
    }

    fn draw(self, run: &Run) -> Drawing {
        match self {
            Self::Angles => angles::draw(run),
            Self::Tracking => tracking::draw(run),
            Self::Torque => torque::draw(run),
            Self::Phase => phase::draw(run),
            Self::Timing => timing::draw(run),
            Self::Spectrum => spectrum::draw(run),
        }
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
}

/// Draws the figures of a run folder; returns the files, SVG before PNG.
///
/// # Errors
/// If a file cannot be written or a drawing cannot be rendered.
pub fn draw_all(
    folder: &Path,
    facts: &RunFacts,
    records: &[Record],
) -> Result<Vec<PathBuf>, PlotError> {
    let figures = [Figure::Angles, Figure::Torque, Figure::Timing];
    draw(folder, &figures, Formats::ALL, facts, records, [None; 2])
}

/// Draws figures into a folder, of the whole run or of the time between `from_s` and `to_s`
/// after its first record; returns the files, SVG before PNG.
///
/// # Errors
/// If a file cannot be written or a drawing cannot be rendered.
pub fn draw(
    folder: &Path,
    figures: &[Figure],
    formats: Formats,
    facts: &RunFacts,
    records: &[Record],
    [from_s, to_s]: [Option<f64>; 2],
) -> Result<Vec<PathBuf>, PlotError> {
    let run = Run::new(facts, records, from_s, to_s);
    let drawn: Vec<_> = std::thread::scope(|scope| {
        let spawn = |figure: &Figure| {
            let (figure, run) = (*figure, &run);
            (figure.name(), scope.spawn(move || figure.draw(run)))
        };
        let threads: Vec<_> = figures.iter().map(spawn).collect();
        let drawing = |(name, thread): (_, std::thread::ScopedJoinHandle<'_, Drawing>)| {
            let drawing = thread.join();
            (
                name,
                drawing.unwrap_or_else(|panic| std::panic::resume_unwind(panic)),
            )
        };
        threads.into_iter().map(drawing).collect()
    });
    write_as(folder, formats, drawn)
}

/// Writes named drawings into a folder, as SVG and PNG.
pub(crate) fn write_all<'a>(
    folder: &Path,
    figures: impl IntoIterator<Item = (&'a str, Drawing)>,
) -> Result<Vec<PathBuf>, PlotError> {
    write_as(folder, Formats::ALL, figures)
}

/// Writes named drawings into a folder; returns the files, SVG before PNG.
fn write_as<'a>(
    folder: &Path,
    formats: Formats,
    figures: impl IntoIterator<Item = (&'a str, Drawing)>,
) -> Result<Vec<PathBuf>, PlotError> {
    // Rendering pixels takes most of the time, and the figures are independent.
    std::thread::scope(|scope| {
        let spawn = |(name, drawing): (&'a str, Drawing)| {
            scope.spawn(move || {
                let svg_path = folder.join(format!("{name}.svg"));
                let png_path = folder.join(format!("{name}.png"));
                let mut files = Vec::new();
                if formats.svg {
                    write(&svg_path, drawing.svg().as_bytes())?;
                    files.push(svg_path);
                }
                if formats.png {
                    let pixels = png::png(&drawing).map_err(|source| PlotError::Raster {
                        path: png_path.clone(),
                        source,
                    })?;
                    write(&png_path, &pixels)?;
                    files.push(png_path);
                }
                Ok(files)
            })
        };
        let threads: Vec<_> = figures.into_iter().map(spawn).collect();
        let mut files = Vec::new();
        for thread in threads {
            let drawn = thread
                .join()
                .unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            files.extend(drawn?);
        }
        Ok(files)
    })
}

pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<(), PlotError> {
    let written = output_file::write(path, bytes, Existing::Replace);
    written.map(|_| ()).map_err(|source| PlotError::Write {
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
pub(crate) fn titled(height: f64, title: &str, about: &str) -> Drawing {
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
