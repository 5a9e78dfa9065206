//! What was found as a page: `report.html`, and each of its pictures as SVG and PNG.

mod friction;
mod heat;
mod residuals;
mod text;
mod windows;

use std::path::{Path, PathBuf};

use armbridge_shared::JOINTS;

use super::arm::Known;
use super::checks::Checks;
use super::diagnose::Diagnosis;
use super::fit_result::Found;
use super::forecast::Forecast;
use super::report::Report;
use crate::html;
use crate::plot;
use crate::plot::PlotError;
use crate::plot::drawing::Drawing;

/// What the page is of.
#[derive(Clone, Copy, Debug)]
pub struct Page<'a> {
    /// Each log, and what world it is of, in a line.
    pub logs: &'a [String],
    /// The numbers as a table.
    pub report: &'a Report,
    /// What was found.
    pub found: &'a Found,
    /// The checks of the fit.
    pub checks: &'a Checks,
    /// How well the numbers tell what they were not found in; none if that was not tried.
    pub forecasts: Option<&'a [Forecast]>,
    /// What these are of, in words.
    pub held_out: &'a str,
    /// What was not looked for.
    pub known: &'a Known,
}

/// Writes a page with the reason why there are no numbers into an existing folder; returns
/// its path.
///
/// # Errors
/// When it cannot be written.
pub fn no_numbers(
    folder: &Path,
    diagnosis: &Diagnosis,
    logs: &[String],
) -> Result<PathBuf, PlotError> {
    html::write(folder, &text::no_numbers(diagnosis, logs))
}

/// A picture with its caption.
struct Picture {
    name: &'static str,
    drawing: Drawing,
    caption: &'static str,
}

impl Page<'_> {
    /// Writes page and pictures into an existing folder; returns the page's path.
    ///
    /// # Errors
    /// When a file cannot be written or a drawing not be turned into pixels.
    pub fn write(&self, folder: &Path) -> Result<PathBuf, PlotError> {
        let pictures = self.pictures();
        let figures = pictures
            .iter()
            .map(|picture| (picture.name, picture.drawing.clone()));
        plot::write_all(folder, figures)?;
        html::write(folder, &text::page(self, &pictures))
    }

    fn pictures(&self) -> Vec<Picture> {
        const WINDOWS: [&str; JOINTS] = ["windows-1", "windows-2"];
        let known = self.known.with(&self.found.stribeck);
        let period_s = known.period_s;
        let windows = WINDOWS.into_iter().enumerate().filter_map(|(joint, name)| {
            Some(Picture {
                name,
                drawing: windows::draw(self.checks, joint, period_s)?,
                caption: "What the encoder said, and the motion that the numbers that were found \
                          make of the PWM alone, from a start that is sought for each window.",
            })
        });
        let others = [
            Picture {
                name: "residuals",
                drawing: residuals::draw(self.found, self.checks, period_s),
                caption: "Left, each window's errors, noise of the encoder included. Right, \
                          whether an error tells the ones after it: noise stays between the \
                          dashed lines in 95 of 100 cases.",
            },
            Picture {
                name: "friction",
                drawing: friction::draw(self.found, self.checks, &known),
                caption: "What of the torque is left for friction, over the speed, and the curve \
                          that was found. Dashed, the line that viscous friction alone would be.",
            },
            Picture {
                name: "correlations",
                drawing: heat::draw(self.found),
                caption: "Where two numbers are strongly correlated, an error of the one comes with an \
                          error of the other; their product or sum is known better than either.",
            },
        ];
        windows.chain(others).collect()
    }
}
