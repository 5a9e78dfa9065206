//! A set-up looked at before it moves anything: its gain, where the poles of the closed
//! loop are, how much can be wrong before it is unstable, and how it answers a step.
//!
//! # What is computed with
//!
//! The gain is the board's own, designed by the same code in single precision. The loop is
//! the linear one about upright: the arm that the set-up believes in, exactly discretised
//! with the torque held for a period; the torque decided in one tick and acting from the
//! next; the estimator as it is, given the torque that was asked for. A Kalman filter is
//! taken where its gain has settled.
//!
//! Left out is what is not linear: rounding to counts and PWM, limits, and dry friction
//! with what is fed forward against it. A joint that slides feels dry friction as a
//! constant, and the loop is the one that is looked at; one that is stuck is not moved by a
//! loop at all.
//!
//! | file      | what lives there                                    |
//! |-----------|-----------------------------------------------------|
//! | `model`   | arm, estimator and gain as one linear loop          |
//! | `poles`   | eigenvalues, as z and as frequency and damping      |
//! | `margins` | gain, phase, delay and disc margin, sensitivity     |
//! | `place`   | the gain that has chosen poles                      |
//! | `retune`   | the same control for another arm                    |
//! | `step`    | answers to a step: of the loop, and of the bench    |
//! | `draw`    | the figure of them                                  |

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
pub use place::{PlaceError, place};
pub use poles::{Pole, Poles};
pub use retune::{Redesign, retune};
pub use step::StepError;

use std::path::{Path, PathBuf};

use armbridge_shared::JOINTS;
use armbridge_shared::bridge::why_not;
use armbridge_shared::link::message::{Refusal, Settings, Setup};
use serde::Serialize;

use crate::plot::PlotError;
use model::Loop;

/// What is known of a set-up before it moves anything.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Design {
    /// Gain from state to torque: one row a torque, both angles before both speeds, in
    /// N m/rad and N m s/rad. Of computed torque, what it comes to upright.
    pub gain: [[f64; 2 * JOINTS]; JOINTS],
    /// Where the loop's poles are.
    pub poles: Poles,
    /// What can be wrong before it is unstable.
    pub margins: Margins,
    /// All eigenvalues of the whole loop are inside the unit circle.
    pub is_stable: bool,
}

/// Why a figure cannot be drawn.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    /// The bench does not run with this set-up.
    #[error(transparent)]
    Step(#[from] StepError),
    /// It cannot be written.
    #[error(transparent)]
    Plot(#[from] PlotError),
}

impl Design {
    /// Looks at a set-up.
    ///
    /// # Errors
    /// If no board would run with it.
    pub fn of(setup: &Setup) -> Result<Self, Refusal> {
        let settings = Settings {
            setup: *setup,
            ..Settings::default()
        };
        why_not(&settings).map_or(Ok(()), Err)?;
        let parts = Loop::of(setup)?;
        Ok(Self {
            // Matrices are stored by columns: those of the transpose are the rows.
            gain: parts.gain.transpose().data.0,
            poles: Poles::of(&parts),
            margins: Margins::of(&parts),
            is_stable: model::radius(&parts.closed()) < 1.0,
        })
    }
}

/// Draws how a set-up answers a step, on the bench and as the linear loop has it, to files
/// of this name that end in `.svg` and `.png`.
///
/// # Errors
/// If the bench does not run with it, or the files cannot be written.
pub fn draw_step(setup: &Setup, file: &Path) -> Result<Vec<PathBuf>, FigureError> {
    let answers = step::answers(setup)?;
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    let folder = file.parent().unwrap_or(Path::new(""));
    let drawing = draw::figure(setup, &answers);
    Ok(crate::plot::write_all(folder, [(&*name, drawing)])?)
}
