//! Forecast: how well the estimates predict a joint's motion in logs excluded from the fit.
//!
//! While a joint slides, at most 3 s, its motion is computed from the PWM that was sent. Only
//! the initial state of each window, angle and speed, is fitted: once to all of the window,
//! which shows the error of the parameters; and once to its first quarter of a second, which
//! makes the rest a forecast. A standing arm amplifies an error of the initial state by its
//! unstable pole; a forecast counts until the uncertainty of its initial state, because of the
//! encoder's noise, reaches one count.

use serde::Serialize;

use super::arm::KnownParameters;
use super::checks::{Rollout, rollout};
use super::dataset::{Trace, Window};
use super::fit_result::FitResult;
use super::quantity::{COUNT, Quantity};

/// Longest window in s: within a few time constants of an unstable pole, the uncertainty of
/// the initial state dominates.
const LONGEST_S: f64 = 3.0;
/// Length in s of the part of a window that the initial state of a forecast is fitted to.
const START_S: f64 = 0.25;

/// Accuracy of a joint's predicted motion.
#[derive(Clone, Debug, Serialize)]
pub struct Forecast {
    /// Joint, from 1.
    pub joint: usize,
    /// Number of windows in which it slides.
    pub windows: usize,
    /// Total length of the windows in s.
    pub sliding_s: f64,
    /// Longest window in s.
    pub longest_s: f64,
    /// Root mean square of the residuals in counts, encoder noise included, with initial
    /// states fitted to all of each window.
    pub rms_counts: f64,
    /// The same without the encoder's noise.
    pub model_rms_counts: f64,
    /// Time constant of the joint's unstable pole upright, in s; `None` if the arm hangs.
    pub unstable_time_constant_s: Option<f64>,
    /// Median time in s until the uncertainty of an initial state from the first quarter of a
    /// second reaches one count; `None` if it never does in these windows.
    pub divergence_s: Option<f64>,
    /// Root mean square of the forecast's residuals until then in counts, noise included.
    pub forecast_rms_counts: f64,
    /// The same without the encoder's noise: errors of initial state and parameters.
    pub forecast_model_rms_counts: f64,
    /// Total length of the forecasts in s.
    pub forecast_s: f64,
}

/// Forecasts of both joints, in logs excluded from the fit.
pub fn forecast(fit: &FitResult, traces: &[Trace], known: &KnownParameters) -> Vec<Forecast> {
    let known = &known.with_friction(fit);
    let traces = fit.smoothed(traces, known);
    let max_len = (LONGEST_S / known.period_s) as usize;
    let windows = |joint: usize| {
        traces
            .iter()
            .enumerate()
            .flat_map(|(index, trace)| trace.windows(index, joint, max_len))
            .collect::<Vec<Window>>()
    };
    let forecast_joint =
        |joint| forecast_windows(joint, &windows(joint), &traces, known, &fit.coordinates);
    (0..known.joints)
        .map(forecast_joint)
        .map(|forecast| forecast.with_noise_removed(fit.noise_counts))
        .collect()
}

/// Forecast of these windows of a joint; traces are smoothed.
pub(super) fn forecast_windows(
    joint: usize,
    windows: &[Window],
    traces: &[Trace],
    known: &KnownParameters,
    coordinates: &[f64; COUNT],
) -> Forecast {
    let (mut fitted_errors, mut forecast_errors) =
        (SquaredErrors::default(), SquaredErrors::default());
    let mut divergence_times_s = Vec::new();
    for window in windows {
        let trace = &traces[window.trace];
        let fitted_ticks = ((START_S / known.period_s) as usize).min(window.len / 2);
        fitted_errors.add(
            &rollout(window, trace, known, coordinates, window.len),
            0..window.len,
        );
        let forecast = rollout(window, trace, known, coordinates, fitted_ticks);
        let diverged = forecast
            .deviation
            .iter()
            .skip(fitted_ticks)
            .position(|deviation| *deviation > 1.0);
        let end = diverged.map_or(window.len, |diverged| fitted_ticks + diverged);
        divergence_times_s.extend(diverged.map(|_| end as f64 * known.period_s));
        forecast_errors.add(&forecast, fitted_ticks..end);
    }
    divergence_times_s.sort_by(f64::total_cmp);
    let longest = windows.iter().map(|window| window.len).max().unwrap_or(0);
    Forecast {
        joint: joint + 1,
        windows: windows.len(),
        sliding_s: fitted_errors.ticks * known.period_s,
        longest_s: longest as f64 * known.period_s,
        rms_counts: fitted_errors.rms(),
        model_rms_counts: fitted_errors.rms(),
        unstable_time_constant_s: unstable_time_constant_s(joint, known, coordinates),
        divergence_s: divergence_times_s
            .get(divergence_times_s.len() / 2)
            .copied(),
        forecast_rms_counts: forecast_errors.rms(),
        forecast_model_rms_counts: forecast_errors.rms(),
        forecast_s: forecast_errors.ticks * known.period_s,
    }
}

impl Forecast {
    /// The same with this noise of the encoder removed.
    pub(super) fn with_noise_removed(self, noise_counts: f64) -> Self {
        let model = |rms: f64| (rms.powi(2) - noise_counts.powi(2)).max(0.0).sqrt();
        Self {
            model_rms_counts: model(self.rms_counts),
            forecast_model_rms_counts: model(self.forecast_rms_counts),
            ..self
        }
    }

    /// Headings of [`cells`](Self::cells).
    pub const HEADS: [&'static str; 10] = [
        "joint",
        "sliding",
        "windows",
        "longest",
        "rms",
        "noise removed",
        "forecast rms",
        "noise removed",
        "unstable pole",
        "time to one count",
    ];

    /// Cells of a table row.
    pub fn cells(&self) -> [String; 10] {
        let seconds = |s: f64| format!("{s:.2} s");
        let counts = |counts: f64| {
            if counts.is_finite() {
                format!("{counts:.2}")
            } else {
                "-".into()
            }
        };
        [
            self.joint.to_string(),
            seconds(self.sliding_s),
            self.windows.to_string(),
            seconds(self.longest_s),
            counts(self.rms_counts),
            counts(self.model_rms_counts),
            format!(
                "{} in {}",
                counts(self.forecast_rms_counts),
                seconds(self.forecast_s)
            ),
            counts(self.forecast_model_rms_counts),
            self.unstable_time_constant_s.map_or("none".into(), seconds),
            self.divergence_s.map_or("not reached".into(), seconds),
        ]
    }
}

/// Sum of squared residuals.
#[derive(Default)]
struct SquaredErrors {
    squares: f64,
    ticks: f64,
}

impl SquaredErrors {
    fn add(&mut self, rollout: &Rollout, part: core::ops::Range<usize>) {
        for error in rollout.residuals[part]
            .iter()
            .filter(|error| error.is_finite())
        {
            self.squares += error * error;
            self.ticks += 1.0;
        }
    }

    fn rms(&self) -> f64 {
        (self.squares / self.ticks).sqrt()
    }
}

/// Time constant in s of a joint's unstable pole, with both joints upright.
fn unstable_time_constant_s(
    joint: usize,
    known: &KnownParameters,
    coordinates: &[f64; COUNT],
) -> Option<f64> {
    let parameter = |joint: usize, quantity: Quantity| -> f64 {
        quantity.value(coordinates[quantity.index(joint)])
    };
    let link = parameter(1, Quantity::Gravity);
    let [p, e] = known.coupling(link);
    let (inertia, gravity) = match joint {
        0 => (
            parameter(0, Quantity::Inertia) + p + e,
            parameter(0, Quantity::Gravity) + link,
        ),
        _ => (parameter(joint, Quantity::Inertia), link),
    };
    let viscous = parameter(joint, Quantity::Viscous);
    // mass x² + viscous x - gravity = 0
    let root = (viscous * viscous + 4.0 * inertia * gravity).sqrt();
    (known.gravity_sign() > 0.0).then(|| 2.0 * inertia / (root - viscous))
}

#[cfg(test)]
mod tests {
    use super::*;
    use armbridge_link::message::Setup;
    use armbridge_servo::JOINTS;

    #[test]
    fn the_papers_arm_falls_with_the_poles_of_its_linear_model() {
        let setup = Setup::default();
        let mut coordinates = [0.0; COUNT];
        for joint in 0..JOINTS {
            for quantity in Quantity::ALL {
                coordinates[quantity.index(joint)] =
                    quantity.coordinate(quantity.nominal(&setup, joint));
            }
        }
        let linear = setup
            .arm
            .map(f64::from)
            .linearise(nalgebra::Vector2::zeros());
        for joint in 0..JOINTS {
            // x'' = a x + b x'
            let [a, b] = [
                linear.a[(2 + joint, joint)],
                linear.a[(2 + joint, 2 + joint)],
            ];
            let pole = b / 2.0 + (b * b / 4.0 + a).sqrt();
            let fit =
                unstable_time_constant_s(joint, &KnownParameters::from_setup(&setup), &coordinates)
                    .unwrap();
            assert!((fit * pole - 1.0).abs() < 1e-6, "{fit} s, {pole} 1/s");
        }
        let mut known = KnownParameters::from_setup(&setup);
        known.mounting = armbridge_control::arm::Mounting::Hanging;
        assert_eq!(unstable_time_constant_s(0, &known, &coordinates), None);
    }
}
