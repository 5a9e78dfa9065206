//! Plots of a run, each as SVG and PNG. The parts that they are drawn with serve
//! the [`paper`](crate::paper)'s figures as well.
//!
//! | figure     | shows                                                         |
//! |------------|---------------------------------------------------------------|
//! | `angles`   | samples, estimate and setpoint of both joints                 |
//! | `tracking` | estimate minus reference, with the band of what is settled    |
//! | `torque`   | torque and PWM of both joints, with what the servos can do    |
//! | `phase`    | speed over angle of both joints                               |
//! | `timing`   | start error, bus time and compute time of every tick, counted |
//! | `spectrum` | power of error, torque and innovation over frequency          |
//!
//! [`draw_preview`] draws what is to come, `preview`; [`compare()`] lays two runs on top of
//! each other. Time is in s after the first record, as in the summary. Where records are
//! missing, there is a gap.

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

use armbridge_log::run_info::RunFacts;
use armbridge_shared::link::message::Record;

use drawing::{Anchor, Drawing, Font};
use panel::{INK, MUTED};
use run::Run;

/// Width of every figure in px.
pub(crate) const WIDTH: f64 = 1040.0;

/// Why the plots could not be drawn.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    /// A file cannot be written.
    #[error("cannot write {path}: {source}", path = path.display())]
    Write {
        /// File being written.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The drawing could not be turned into pixels.
    #[error("cannot draw {path}: {source}", path = path.display())]
    Raster {
        /// File being drawn.
        path: PathBuf,
        /// Why.
        source: RasterError,
    },
}

/// Figures to choose from.
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
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Angles,
        Self::Tracking,
        Self::Torque,
        Self::Phase,
        Self::Timing,
        Self::Spectrum,
    ];

    /// Name of its files.
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

/// What is written of each figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Formats {
    /// For print and editing.
    pub svg: bool,
    /// For everything else.
    pub png: bool,
}

impl Formats {
    /// Both.
    pub const ALL: Self = Self {
        svg: true,
        png: true,
    };
}

/// Draws the figures that a run folder has; returns the files, SVG before PNG.
///
/// # Errors
/// When a file cannot be written or a drawing not be turned into pixels.
pub fn draw_all(
    folder: &Path,
    facts: &RunFacts,
    records: &[Record],
) -> Result<Vec<PathBuf>, PlotError> {
    let figures = [Figure::Angles, Figure::Torque, Figure::Timing];
    draw(folder, &figures, Formats::ALL, facts, records, [None; 2])
}

/// Draws figures into a folder, of the whole run or of what lies between two times
/// in s after its first record; returns the files, SVG before PNG.
///
/// # Errors
/// When a file cannot be written or a drawing not be turned into pixels.
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

/// Writes drawings by these names into a folder, as SVG and PNG.
pub(crate) fn write_all<'a>(
    folder: &Path,
    figures: impl IntoIterator<Item = (&'a str, Drawing)>,
) -> Result<Vec<PathBuf>, PlotError> {
    write_as(folder, Formats::ALL, figures)
}

/// Writes drawings by these names into a folder; returns the files, SVG before
/// PNG.
fn write_as<'a>(
    folder: &Path,
    formats: Formats,
    figures: impl IntoIterator<Item = (&'a str, Drawing)>,
) -> Result<Vec<PathBuf>, PlotError> {
    // Drawing pixels is most of the work, and the figures have nothing to do
    // with each other.
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
    std::fs::write(path, bytes).map_err(|source| PlotError::Write {
        path: path.to_path_buf(),
        source,
    })
}

/// A figure with its title line.
fn figure(height: f64, title: &str, facts: &RunFacts) -> Drawing {
    let title = format!("{title} · armbridge {}", facts.name);
    titled(height, &title, &facts.describe())
}

/// A figure with a title, and what it is about beside it.
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
