//! All fits of a set of recordings: every form of friction on all of them and with some held
//! out, and the intervals of the most elaborate one.

use armbridge_log::text_table;
use serde::Serialize;

use super::covariance_adaptation::Search;
use super::filter::{Innovations, has_form, innovations, rounding_counts};
use super::fit::{Fit, Interrupted, Task, best, fit_all};
use super::holdout::{Holdout, Partition};
use super::jackknife::{Estimate, estimates};
use super::parameters::FrictionForm;
use super::recording::Recording;

/// Searches of every fit.
const SEEDS: [u64; 2] = [1, 2];
/// A search from the values of small servos.
const SEARCH: Search = Search {
    population: 20,
    evaluations: 3_000,
    deviation: 0.4,
    deviation_min: 3e-3,
    seed: 0,
};
/// A search from the fit to all recordings, with one of them left out.
const NEAR_SEARCH: Search = Search {
    population: 12,
    evaluations: 1_200,
    deviation: 0.03,
    deviation_min: 1e-3,
    seed: 1,
};
/// Form of friction whose parameters have intervals.
const ESTIMATED: FrictionForm = FrictionForm::LoadStribeck;
/// Fewest recordings: a jackknife of fewer says nothing.
const RECORDINGS_MIN: usize = 4;

/// Reason for which recordings are not fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PendulumError {
    /// There are too few.
    #[error("at least {RECORDINGS_MIN} recordings are needed, not {0}")]
    TooFew(usize),
    /// Ended early.
    #[error("interrupted")]
    Interrupted,
}

impl From<Interrupted> for PendulumError {
    fn from(_: Interrupted) -> Self {
        Self::Interrupted
    }
}

/// Result of an identification.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Errors of the forms of friction.
    pub forms: Vec<FormErrors>,
    /// Errors of fits with recordings held out.
    pub holdouts: Vec<Holdout>,
    /// Errors by recording.
    pub recordings: Vec<RecordingErrors>,
    /// The board's Kalman filter over all recordings, with each form of friction that it can have.
    pub innovations: Vec<Innovations>,
    /// Form of friction that the estimates belong to.
    pub estimated: FrictionForm,
    /// Its parameters, fitted to all recordings.
    pub estimates: Vec<Estimate>,
}

/// Errors of a form of friction.
#[derive(Clone, Debug, Serialize)]
pub struct FormErrors {
    /// The form.
    pub form: FrictionForm,
    /// Number of its parameters.
    pub parameters: usize,
    /// Error of the fit to all recordings, on these, in degrees.
    pub fitted_deg: f64,
    /// Error on recordings of gains that were held out in degrees; each held out once.
    pub held_out_gain_deg: Option<f64>,
    /// The same for trajectories.
    pub held_out_trajectory_deg: Option<f64>,
    /// Fitted values by name, in SI units.
    pub values: serde_json::Map<String, serde_json::Value>,
}

/// Errors of a recording, with the parameters fitted to all.
#[derive(Clone, Debug, Serialize)]
pub struct RecordingErrors {
    /// File.
    pub file: String,
    /// Name of the goals' course.
    pub trajectory: String,
    /// Gain of the position controller.
    pub gain: f64,
    /// Error of each form of friction in degrees.
    pub errors_deg: Vec<f64>,
}

/// Fits all forms of friction to recordings; `done` receives the finished share of the work.
///
/// # Errors
/// If there are too few recordings, or ctrl-C ends the work.
pub fn identify(
    recordings: &[Recording],
    mut done: impl FnMut(f64),
) -> Result<Report, PendulumError> {
    if recordings.len() < RECORDINGS_MIN {
        return Err(PendulumError::TooFew(recordings.len()));
    }
    let partitions = Partition::of(recordings);
    let all: Vec<&Recording> = recordings.iter().collect();
    let mut sets = vec![all.clone()];
    sets.extend(partitions.iter().map(|it| it.part(recordings, false)));
    let mut tasks = Vec::new();
    for set in &sets {
        for form in FrictionForm::ALL {
            tasks.extend(SEEDS.map(|seed| Task {
                form,
                recordings: set.clone(),
                start: None,
                search: Search { seed, ..SEARCH },
            }));
        }
    }
    // A task of the jackknife takes a fifth of the time.
    let total = tasks.len() as f64 + recordings.len() as f64 / 5.0;
    let fits = fit_all(&tasks, |finished| done(finished as f64 / total))?;
    let fits: Vec<Fit> = fits.chunks(SEEDS.len()).filter_map(best).collect();
    let by_set: Vec<&[Fit]> = fits.chunks(FrictionForm::ALL.len()).collect();
    let [fitted, held_out @ ..] = by_set.as_slice() else {
        return Err(PendulumError::Interrupted);
    };
    let holdouts: Vec<Holdout> = partitions
        .iter()
        .zip(held_out)
        .map(|(partition, fits)| partition.errors(recordings, fits))
        .collect();
    let estimated = fitted
        .iter()
        .find(|fit| fit.form == ESTIMATED)
        .ok_or(PendulumError::Interrupted)?;
    let without_one: Vec<Task<'_>> = (0..all.len())
        .map(|left_out| {
            let mut recordings = all.clone();
            recordings.remove(left_out);
            Task {
                form: ESTIMATED,
                recordings,
                start: Some(estimated.parameters),
                search: NEAR_SEARCH,
            }
        })
        .collect();
    let before = tasks.len() as f64;
    let without_one = fit_all(&without_one, |finished| {
        done((before + finished as f64 / 5.0) / total);
    })?;
    let without_one: Vec<_> = without_one.iter().map(|fit| fit.parameters).collect();
    Ok(Report {
        forms: fitted
            .iter()
            .map(|fit| form_errors(fit, &holdouts))
            .collect(),
        recordings: recordings
            .iter()
            .map(|recording| recording_errors(recording, fitted))
            .collect(),
        innovations: fitted
            .iter()
            .filter(|fit| has_form(fit.form))
            .filter_map(|fit| innovations(&all, fit))
            .collect(),
        holdouts,
        estimated: ESTIMATED,
        estimates: estimates(ESTIMATED, &estimated.parameters, &without_one),
    })
}

fn form_errors(fit: &Fit, holdouts: &[Holdout]) -> FormErrors {
    let quantities = fit.form.quantities();
    let values = quantities.iter().map(|&quantity| {
        let name = format!("{} ({})", quantity.name(), quantity.unit());
        (name, fit.parameters.get(quantity).into())
    });
    FormErrors {
        form: fit.form,
        parameters: quantities.len(),
        fitted_deg: fit.error_deg,
        held_out_gain_deg: held_out_deg(fit.form, holdouts, "gain"),
        held_out_trajectory_deg: held_out_deg(fit.form, holdouts, "trajectory"),
        values: values.collect(),
    }
}

/// Error of a form over all samples of holdouts of a kind; `None` if there are none.
fn held_out_deg(form: FrictionForm, holdouts: &[Holdout], kind: &str) -> Option<f64> {
    let of_kind = holdouts.iter().filter(|holdout| holdout.kind == kind);
    let (mut sum, mut samples) = (0.0, 0);
    for holdout in of_kind {
        let error = holdout.errors.iter().find(|error| error.form == form)?;
        sum += error.held_out_deg * holdout.samples as f64;
        samples += holdout.samples;
    }
    (samples > 0).then(|| sum / samples as f64)
}

fn recording_errors(recording: &Recording, fits: &[Fit]) -> RecordingErrors {
    let error_deg = |fit: &Fit| super::error_deg(&[recording], &fit.parameters);
    RecordingErrors {
        file: recording.name.clone(),
        trajectory: recording.trajectory().to_owned(),
        gain: recording.gain,
        errors_deg: fits.iter().map(error_deg).collect(),
    }
}

impl Report {
    /// The report as text, ending in a line feed.
    pub fn text(&self) -> String {
        format!(
            "mean absolute error of the simulated angle in degrees:\n{}\n\
             errors on recordings held out of the fit (on those of the fit) in degrees:\n{}\n\
             errors by recording, fitted to all, in degrees:\n{}\n\
             innovations of the board's Kalman filter, in counts (rounding alone: {:.2}), over all \
             recordings:\n{}\n\
             parameters with friction by {}, fitted to all recordings:\n{}",
            text_table::columns(&self.form_rows()),
            text_table::columns(&self.holdout_rows()),
            text_table::columns(&self.recording_rows()),
            rounding_counts(),
            text_table::columns(&self.innovation_rows()),
            self.estimated.name(),
            text_table::columns(&self.estimate_rows())
        )
    }

    fn form_rows(&self) -> Vec<Vec<String>> {
        let heads = [
            "friction",
            "parameters",
            "fitted",
            "other gains",
            "other trajectories",
        ];
        let optional = |error: Option<f64>| error.map_or_else(|| "–".to_owned(), degrees);
        let row = |errors: &FormErrors| {
            vec![
                errors.form.name().to_owned(),
                errors.parameters.to_string(),
                degrees(errors.fitted_deg),
                optional(errors.held_out_gain_deg),
                optional(errors.held_out_trajectory_deg),
            ]
        };
        with_heads(&heads, self.forms.iter().map(row))
    }

    fn holdout_rows(&self) -> Vec<Vec<String>> {
        let row = |holdout: &Holdout| {
            let errors = holdout.errors.iter().map(|error| {
                let [held_out, fitted] = [error.held_out_deg, error.fitted_deg].map(degrees);
                format!("{held_out} ({fitted})")
            });
            [holdout.held_out.clone()]
                .into_iter()
                .chain(errors)
                .collect()
        };
        with_heads(&form_heads(&["held out"]), self.holdouts.iter().map(row))
    }

    fn recording_rows(&self) -> Vec<Vec<String>> {
        let row = |recording: &RecordingErrors| {
            let first = [recording.trajectory.clone(), recording.gain.to_string()];
            let errors = recording.errors_deg.iter().copied().map(degrees);
            first.into_iter().chain(errors).collect()
        };
        let heads = form_heads(&["trajectory", "kp"]);
        with_heads(&heads, self.recordings.iter().map(row))
    }

    fn innovation_rows(&self) -> Vec<Vec<String>> {
        let row = |it: &Innovations| {
            vec![
                it.form.name().to_owned(),
                format!("{:.2}", it.rms_counts),
                format!("{:.2}", it.slow_rms_counts),
                format!("{:.2}", it.fast_rms_counts),
                format!(
                    "{:.3} (± {:.3})",
                    it.autocorrelation, it.autocorrelation_limit
                ),
                format!("{:.1}", 1e3 * it.disturbance_rms_nm),
            ]
        };
        let heads = [
            "friction",
            "rms",
            "below 0.2 rad/s",
            "above",
            "autocorrelation (of noise)",
            "disturbance, mN m rms",
        ];
        with_heads(&heads, self.innovations.iter().map(row))
    }

    fn estimate_rows(&self) -> Vec<Vec<String>> {
        let row = |estimate: &Estimate| {
            let places = if estimate.half_width_95 > 0.0 && estimate.half_width_95.is_finite() {
                (1.0 - estimate.half_width_95.log10().floor()).clamp(0.0, 9.0) as usize
            } else {
                6
            };
            let digits = |value: f64| format!("{value:.places$}");
            vec![
                estimate.name.to_owned(),
                digits(estimate.value),
                format!("± {}", digits(estimate.half_width_95)),
                estimate.unit.to_owned(),
            ]
        };
        let heads = ["parameter", "estimate", "95 % interval", "unit"];
        with_heads(&heads, self.estimates.iter().map(row))
    }
}

fn with_heads(heads: &[&str], rows: impl Iterator<Item = Vec<String>>) -> Vec<Vec<String>> {
    let heads = heads.iter().map(|&head| head.to_owned()).collect();
    [heads].into_iter().chain(rows).collect()
}

fn form_heads(first: &[&'static str]) -> Vec<&'static str> {
    let forms = FrictionForm::ALL.iter().map(|form| form.name());
    first.iter().copied().chain(forms).collect()
}

fn degrees(error_deg: f64) -> String {
    format!("{error_deg:.2}")
}
