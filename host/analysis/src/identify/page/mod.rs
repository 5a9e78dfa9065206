//! Report of a fit as a page: `report.html`, and each of its figures as SVG and PNG.

mod correlation_map;
mod friction;
mod residuals;
mod text;
mod windows;

use std::path::{Path, PathBuf};

use armbridge_log::output_file::Existing;
use armbridge_servo::JOINTS;

use super::arm::KnownParameters;
use super::checks::Checks;
use super::diagnose::Diagnosis;
use super::fit_result::FitResult;
use super::forecast::Forecast;
use super::report::Report;
use crate::plot::drawing::Drawing;
use crate::plot::{Formats, PlotError};
use crate::{html, plot};

/// Contents of the page.
#[derive(Clone, Copy, Debug)]
pub struct Page<'a> {
    /// Path, name and link of each log, a line each.
    pub logs: &'a [String],
    /// The estimates as a table.
    pub report: &'a Report,
    /// The fit.
    pub fit: &'a FitResult,
    /// The checks of the fit.
    pub checks: &'a Checks,
    /// Forecasts of data excluded from the fit; `None` if skipped.
    pub forecasts: Option<&'a [Forecast]>,
    /// Description of these data.
    pub held_out: &'a str,
    /// Parameters that are not estimated.
    pub known: &'a KnownParameters,
}

/// Writes a page with the diagnosis of data that identify no arm into an existing folder;
/// returns its path.
///
/// # Errors
/// When it cannot be written.
pub fn write_diagnosis(
    folder: &Path,
    diagnosis: &Diagnosis,
    logs: &[String],
    existing: Existing,
) -> Result<PathBuf, PlotError> {
    html::write(folder, &text::diagnosis(diagnosis, logs), existing)
}

/// A figure with its caption.
struct Figure {
    name: &'static str,
    drawing: Drawing,
    caption: &'static str,
}

impl Page<'_> {
    /// Writes page and figures into an existing folder; returns the page's path. Figures that
    /// exist are kept, unless the page may be replaced.
    ///
    /// # Errors
    /// When a file cannot be written or a drawing not be turned into pixels.
    pub fn write(&self, folder: &Path, existing: Existing) -> Result<PathBuf, PlotError> {
        let figures = self.figures();
        let drawings = figures
            .iter()
            .map(|figure| (figure.name, figure.drawing.clone()));
        let beside = match existing {
            Existing::Replace => Existing::Replace,
            Existing::Refuse | Existing::Number => Existing::Number,
        };
        plot::write_as(folder, Formats::ALL, beside, drawings)?;
        html::write(folder, &text::page(self, &figures), existing)
    }

    fn figures(&self) -> Vec<Figure> {
        const WINDOWS: [&str; JOINTS] = ["windows-1", "windows-2"];
        let known = self.known.with_friction(self.fit);
        let period_s = known.period_s;
        let windows = WINDOWS.into_iter().enumerate().filter_map(|(joint, name)| {
            Some(Figure {
                name,
                drawing: windows::draw(self.checks, joint, period_s)?,
                caption: "Encoder counts, and the motion that the model computes from the PWM \
                          alone, with a fitted initial state for each window.",
            })
        });
        let others = [
            Figure {
                name: "residuals",
                drawing: residuals::draw(self.fit, self.checks, period_s),
                caption: "Left, residual of each window, encoder noise included. Right, \
                          autocorrelation of the residuals: white noise stays between the \
                          dashed lines in 95 of 100 cases.",
            },
            Figure {
                name: "friction",
                drawing: friction::draw(self.fit, self.checks, &known),
                caption: "Friction torque against speed, and the estimated curve. Dashed: \
                          viscous friction alone.",
            },
            Figure {
                name: "correlations",
                drawing: correlation_map::draw(self.fit, known.joints),
                caption: "Errors of strongly correlated parameters come together; their product \
                          or sum is more certain than either.",
            },
        ];
        windows.chain(others).collect()
    }
}
