//! Holdout: a second fit without the last fifth of the windows, validated on these. It serves
//! where there is no other log.

use armbridge_servo::JOINTS;

use super::arm::KnownParameters;
use super::checks::Checks;
use super::cost::{WindowFit, cost};
use super::dataset::Window;
use super::fit_result::FitResult;
use super::forecast::{Forecast, forecast_windows};
use super::prior::Prior;
use super::search::{ErrorModel, Search};

/// Fraction of the windows that is held out.
const HOLDOUT_FRACTION: f64 = 0.2;
/// Most ticks in all windows for a second fit: six minutes at 1 kHz. A search that begins
/// near its minimum evaluates them some twelve times.
const TICKS_MAX: usize = 360_000;

/// Forecasts of the last fifth of both joints' windows, fitted to the others; `None` for
/// windows of more than [`TICKS_MAX`] ticks, whose second fit would take long.
pub fn holdout_forecasts(
    fit: &FitResult,
    checks: &Checks,
    known: &KnownParameters,
    prior: &Prior,
) -> Option<Vec<Forecast>> {
    if fit.window_ticks() > TICKS_MAX {
        return None;
    }
    let known = &known.with_friction(fit);
    let mut kept = fit.window_fits.clone();
    cost(
        &mut kept,
        &checks.traces,
        known,
        &fit.coordinates,
        fit.outlier_limit_counts2,
    );
    let held_out: [Vec<Window>; JOINTS] =
        core::array::from_fn(|joint| last_windows(&fit.window_fits, joint));
    let is_kept = |window_fit: &WindowFit| {
        let Window {
            trace,
            joint,
            first,
            ..
        } = window_fit.window;
        let is_same = |window: &Window| (window.trace, window.first) == (trace, first);
        !held_out[joint].iter().any(is_same)
    };
    let kept = kept.into_iter().filter(is_kept).collect();
    let errors = ErrorModel {
        variance_counts2: fit.noise_counts.powi(2),
        outlier_limit_counts2: fit.outlier_limit_counts2,
    };
    let traces = &checks.traces;
    let search = Search::new(kept, traces, known, prior, fit.coordinates, errors).minimise();
    let coordinates = search.coordinates();
    let forecast = |joint| forecast_windows(joint, &held_out[joint], traces, known, &coordinates);
    let forecasts = (0..known.joints).map(forecast);
    Some(
        forecasts
            .map(|forecast| forecast.with_noise_removed(fit.noise_counts))
            .collect(),
    )
}

/// Last windows of a joint, in the order of traces.
fn last_windows(window_fits: &[WindowFit], joint: usize) -> Vec<Window> {
    let of_joint = window_fits
        .iter()
        .filter(|window_fit| window_fit.window.joint == joint);
    let mut windows: Vec<Window> = of_joint
        .map(|window_fit| window_fit.window.clone())
        .collect();
    windows.sort_by_key(|window| (window.trace, window.first));
    let kept = windows.len() - (windows.len() as f64 * HOLDOUT_FRACTION) as usize;
    windows.split_off(kept)
}
