//! Plots of a run: three figures, each as SVG and PNG. The parts that they are
//! drawn with serve the [`paper`](crate::paper)'s figures as well.
//!
//! | file     | shows                                                         |
//! |----------|---------------------------------------------------------------|
//! | `angles` | samples, estimate and setpoint of both joints                 |
//! | `torque` | torque and PWM of both joints, with what the servos can do    |
//! | `timing` | start error, bus time and compute time of every tick          |
//!
//! Time is in s after the first record, as in the summary.

mod angles;
pub(crate) mod axis;
mod decimate;
pub(crate) mod panel;
mod png;
pub(crate) mod svg;
mod timing;
mod torque;

use crate::facts::RunFacts;
use crate::log::names;
use crate::summary::seconds_since;
use armbridge_shared::link::message::Record;
use axis::{Axis, Scale};
use panel::{ALARM, INK, MUTED, Panel};
use std::path::{Path, PathBuf};
use svg::{Anchor, Font, Svg};

/// Width of every figure in px.
pub(crate) const WIDTH: f64 = 1040.0;

/// Why the plots could not be drawn.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    /// The file system said no.
    #[error("cannot write {path}: {source}", path = path.display())]
    Write {
        /// File being written.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The drawing could not be turned into pixels.
    #[error("cannot draw {path}: {reason}", path = path.display())]
    Raster {
        /// File being drawn.
        path: PathBuf,
        /// What the library said.
        reason: String,
    },
}

/// Draws every figure into a folder; returns the files, SVG before PNG.
///
/// # Errors
/// When a file cannot be written or a drawing not be turned into pixels.
pub fn draw_all(
    folder: &Path,
    facts: &RunFacts,
    records: &[Record],
) -> Result<Vec<PathBuf>, PlotError> {
    let figures = [
        ("angles", angles::draw(facts, records)),
        ("torque", torque::draw(facts, records)),
        ("timing", timing::draw(facts, records)),
    ];
    write_all(folder, figures)
}

/// Writes drawings by these names into a folder; returns the files, SVG before
/// PNG.
pub(crate) fn write_all<'a>(
    folder: &Path,
    figures: impl IntoIterator<Item = (&'a str, String)>,
) -> Result<Vec<PathBuf>, PlotError> {
    let fonts = png::fonts();
    // Drawing pixels is most of the work, and the figures have nothing to do
    // with each other.
    std::thread::scope(|scope| {
        let spawn = |(name, svg): (&'a str, String)| {
            let fonts = fonts.clone();
            scope.spawn(move || {
                let svg_path = folder.join(format!("{name}.svg"));
                let png_path = folder.join(format!("{name}.png"));
                write(&svg_path, svg.as_bytes())?;
                let pixels = png::png(&svg, fonts).map_err(|reason| PlotError::Raster {
                    path: png_path.clone(),
                    reason,
                })?;
                write(&png_path, &pixels)?;
                Ok([svg_path, png_path])
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
fn figure(height: f64, title: &str, facts: &RunFacts) -> Svg {
    let mut svg = Svg::new(WIDTH, height);
    let bold = Font {
        size: 17.0,
        bold: true,
        colour: INK,
        anchor: Anchor::Start,
    };
    svg.text(
        (24.0, 32.0),
        &format!("{title} · armbridge {}", facts.name),
        bold,
        false,
    );
    let light = Font {
        size: 12.5,
        bold: false,
        colour: MUTED,
        anchor: Anchor::End,
    };
    svg.text((WIDTH - 24.0, 32.0), &facts.describe(), light, false);
    svg
}

/// The time axis of a run.
fn time_axis(facts: &RunFacts, records: &[Record]) -> Axis {
    let period_s = f64::from(facts.period_us) * 1e-6;
    let end_s = records
        .last()
        .map_or(1.0, |last| time_s(records, last) + period_s);
    Axis {
        scale: Scale::Linear,
        low: 0.0,
        high: end_s,
    }
}

/// Time of a record in its run.
fn time_s(records: &[Record], record: &Record) -> f64 {
    seconds_since(records[0].start_us, record)
}

/// A quantity of each tick over time.
fn over_time(
    records: &[Record],
    quantity: impl Fn(&Record) -> f64,
) -> impl Iterator<Item = (f64, f64)> {
    records
        .iter()
        .map(move |record| (time_s(records, record), quantity(record)))
}

/// Shades the time spent in faults and names each.
fn draw_faults(svg: &mut Svg, panel: &Panel, records: &[Record]) {
    let alike = |a: &Record, b: &Record| names::fault_of(a.mode) == names::fault_of(b.mode);
    for chunk in records.chunk_by(alike) {
        let Some(fault) = names::fault_of(chunk[0].mode) else {
            continue;
        };
        let (from, to) = (
            time_s(records, &chunk[0]),
            time_s(records, &chunk[chunk.len() - 1]),
        );
        panel.area(svg, (from, panel.y.low), (to, panel.y.high), ALARM, 0.08);
        let text = format!("fault: {}", names::fault(fault));
        let mut font = Font {
            size: 11.5,
            bold: true,
            colour: ALARM,
            anchor: Anchor::Start,
        };
        let (x, bottom) = panel.at(from, panel.y.low);
        svg.line(
            (x, panel.frame.y),
            (x, bottom),
            svg::Stroke::solid(ALARM, 1.2),
        );
        // In the shade, unless the frame ends too soon.
        let mut left = x + 7.0;
        if left + font.width(&text) > panel.frame.right() {
            (font.anchor, left) = (Anchor::End, x - 7.0);
        }
        svg.text((left, panel.frame.y + 34.0), &text, font, false);
    }
}
