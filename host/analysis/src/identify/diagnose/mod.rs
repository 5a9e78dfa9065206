//! Diagnosis of data that do not identify an arm: a [`Diagnosis`] in place of wrong
//! estimates.
//!
//! | when           | check                                                          |
//! |----------------|----------------------------------------------------------------|
//! | before the fit | [`Tally`]: empty, samples lost, encoder or motor at a limit    |
//! | before the fit | duration of sliding; which motor drives a joint, and in which direction |
//! | after the fit  | external torque, with its time; mismatch of the model          |

mod bump;
mod diagnosis;
mod external_torque;
mod motor_assignment;
mod tally;

pub use diagnosis::Diagnosis;
use external_torque::ExternalTorque;
pub use tally::{JointTally, Tally};

pub(super) use bump::Bump;

use armbridge_servo::JOINTS;

use super::arm::KnownParameters;
use super::cost::WindowFit;
use super::dataset::{Trace, encoder_noise_counts};
use super::fit::fit;
use super::fit_result::FitResult;
use super::initial_guess::InitialGuessError;
use super::prior::Prior;
use super::quantity::Quantity;

/// Shortest duration of sliding in s: that of the most informative experiments.
const SLIDING_MIN_S: f64 = 2.0;
/// Largest tolerated fraction of outliers among the windows.
const OUTLIER_FRACTION: f64 = 0.4;
/// Largest tolerated ratio of residual to encoder noise.
const NOISE_RATIO: f64 = 2.0;
/// Longest window in ticks.
const WINDOW: usize = 1_000;

/// Fits the parameters of an arm, and checks data and fit.
///
/// # Errors
/// If the data do not identify the arm.
pub fn identify(
    traces: &[Trace],
    tally: &Tally,
    known: &KnownParameters,
    prior: &Prior,
) -> Result<FitResult, Diagnosis> {
    check_data(traces, tally, known, prior)?;
    let fit = fit(traces, known, prior).map_err(|error| from_initial_guess(&error, known))?;
    check_fit(traces, known, &fit)?;
    Ok(fit)
}

/// Checks data before a fit.
///
/// # Errors
/// If they cannot identify an arm.
pub fn check_data(
    traces: &[Trace],
    tally: &Tally,
    known: &KnownParameters,
    prior: &Prior,
) -> Result<(), Diagnosis> {
    tally.check()?;
    let zero = [0, 1].map(|joint| Quantity::Zero.value(prior.mean[Quantity::Zero.index(joint)]));
    let smoothed = smoothed(traces, known, zero);
    for joint in 0..known.joints {
        let windows = smoothed
            .iter()
            .flat_map(|trace| trace.windows(0, joint, WINDOW));
        let ticks: usize = windows.map(|window| window.len).sum();
        let sliding_s = ticks as f64 * known.period_s;
        if sliding_s < SLIDING_MIN_S {
            return Err(too_short(joint, sliding_s));
        }
    }
    motor_assignment::check(&smoothed, known)
}

/// Checks a fit.
///
/// # Errors
/// If torques other than the motors' act on the arm, or the model does not fit.
pub fn check_fit(
    traces: &[Trace],
    known: &KnownParameters,
    fit: &FitResult,
) -> Result<(), Diagnosis> {
    let known = &known.with_friction(fit);
    let smoothed = fit.smoothed(traces, known);
    let episodes = external_torque::episodes(&smoothed, known, fit);
    let by_magnitude =
        |a: &&ExternalTorque, b: &&ExternalTorque| a.torque_nm.abs().total_cmp(&b.torque_nm.abs());
    if let Some(episode) = episodes.iter().max_by(by_magnitude) {
        let trace = &traces[episode.trace];
        let from_s = trace.start_s + episode.first as f64 * known.period_s;
        let ticks: usize = episodes.iter().map(|episode| episode.len).sum();
        return Err(Diagnosis::ExternalTorque {
            log: trace.log + 1,
            joint: episode.joint + 1,
            from_s,
            to_s: from_s + episode.len as f64 * known.period_s,
            torque_nm: episode.torque_nm.abs(),
            episodes: episodes.len(),
            total_s: ticks as f64 * known.period_s,
        });
    }
    let (outliers, windows) = (fit.outliers(), fit.window_fits.len());
    let noise_counts = encoder_noise_counts(traces, known.joints);
    let is_noisy = fit.noise_counts > NOISE_RATIO * noise_counts;
    if is_noisy || outliers as f64 > OUTLIER_FRACTION * windows as f64 {
        let mut all: Vec<f64> = fit.window_fits.iter().map(WindowFit::rms_counts).collect();
        all.sort_by(f64::total_cmp);
        return Err(Diagnosis::ModelMismatch {
            outliers,
            windows,
            rms_counts: all.get(windows / 2).copied().unwrap_or(f64::NAN),
            noise_counts,
        });
    }
    Ok(())
}

fn smoothed(traces: &[Trace], known: &KnownParameters, zero: [f64; JOINTS]) -> Vec<Trace> {
    let smooth = |trace: &Trace| trace.smoothed(known, zero);
    traces.iter().map(smooth).collect()
}

fn too_short(joint: usize, sliding_s: f64) -> Diagnosis {
    Diagnosis::TooShort {
        joint: joint + 1,
        sliding_s,
        required_s: SLIDING_MIN_S,
    }
}

/// Diagnosis of a failed initial guess.
fn from_initial_guess(error: &InitialGuessError, known: &KnownParameters) -> Diagnosis {
    let InitialGuessError {
        joint,
        segments,
        gain,
    } = *error;
    if gain == 0.0 {
        // Segments of 160 ticks, 20 ticks apart.
        too_short(joint, 20.0 * segments as f64 * known.period_s)
    } else {
        Diagnosis::NotDriven { joint: joint + 1 }
    }
}
