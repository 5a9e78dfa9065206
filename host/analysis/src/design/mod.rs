//! Linear analysis of a set-up before it moves anything: gain, closed-loop poles, stability
//! margins and step response.
//!
//! # Model
//!
//! The gain is the board's own, designed by the same code in single precision. The loop is
//! linear about upright: the arm model of the set-up, exactly discretised with the torque
//! held for a period; the torque computed in one tick acts from the next; the
//! estimator's input is the requested torque. A Kalman filter has its steady-state gain.
//!
//! Nonlinear effects are excluded: rounding to counts and PWM, limits, and dry friction with
//! its feed-forward. For a sliding joint, dry friction is a constant and the loop is the one
//! analysed; a joint that sticks does not respond at all.
//!
//! | file      | contents                                              |
//! |-----------|-------------------------------------------------------|
//! | `model`   | arm, estimator and gain as one linear loop            |
//! | `poles`   | eigenvalues, as z and as frequency and damping        |
//! | `margins` | gain, phase, delay and disc margin, sensitivity       |
//! | `place`   | pole placement                                        |
//! | `retune`  | the same control for another arm                      |
//! | `step`    | step responses of the loop and of the simulated bench |
//! | `draw`    | figure of the step responses                          |

mod draw;
mod margins;
mod model;
mod place;
mod poles;
mod retune;
mod step;
#[cfg(test)]
mod tests;

pub use margins::{Crossing, Disc, JointMargins, Margins};
pub use place::{PlaceError, place, pole_pair};
pub use poles::{Pole, Poles};
pub use retune::{Redesign, retune};
pub use step::StepError;

use std::path::{Path, PathBuf};

use armbridge_board::bridge::settings_refusal;
use armbridge_link::message::{Refusal, Settings, Setup};
use armbridge_log::output_file::Existing;
use armbridge_servo::JOINTS;
use serde::Serialize;

use crate::plot::{Formats, PlotError, write_as};
use model::LinearLoop;

/// Linear analysis of a set-up.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Design {
    /// Gain from state to torque: one row per torque, both angles before both speeds, in
    /// N m/rad and N m s/rad. For computed torque, its linearisation upright.
    pub gain: [[f64; 2 * JOINTS]; JOINTS],
    /// Poles of the loop.
    pub poles: Poles,
    /// Stability margins.
    pub margins: Margins,
    /// All eigenvalues of the closed loop are inside the unit circle.
    pub is_stable: bool,
}

/// Reason why a figure cannot be drawn.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    /// The step responses failed.
    #[error(transparent)]
    Step(#[from] StepError),
    /// The figure cannot be written.
    #[error(transparent)]
    Plot(#[from] PlotError),
}

impl Design {
    /// Analyses a set-up.
    ///
    /// # Errors
    /// If a board would refuse it.
    pub fn from_setup(setup: &Setup) -> Result<Self, Refusal> {
        let settings = Settings {
            setup: *setup,
            ..Settings::default()
        };
        settings_refusal(&settings).map_or(Ok(()), Err)?;
        let system = LinearLoop::from_setup(setup)?;
        Ok(Self {
            // Matrices are stored by columns: those of the transpose are the rows.
            gain: system.gain.transpose().data.0,
            poles: Poles::from_loop(&system),
            margins: Margins::from_loop(&system),
            is_stable: model::spectral_radius(&system.closed()) < 1.0,
        })
    }
}

/// Draws the step responses of a set-up, on the simulated bench and by the linear loop, to
/// `file`, which is an SVG or a PNG; without an ending, both are written.
///
/// # Errors
/// If the name has another ending, the bench does not run with the set-up, or the files cannot be
/// written.
pub fn draw_step(
    setup: &Setup,
    file: &Path,
    existing: Existing,
) -> Result<Vec<PathBuf>, FigureError> {
    let formats = Formats::of_file(file)?;
    let responses = step::responses(setup)?;
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    let folder = file.parent().unwrap_or(Path::new(""));
    let drawing = draw::figure(setup, &responses);
    Ok(write_as(folder, formats, existing, [(&*name, drawing)])?)
}
