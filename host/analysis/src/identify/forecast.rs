//! How well the numbers that were found predict a joint's motion in logs that were not
//! part of the fit.
//!
//! As long as a joint slides, at most 3 s, its motion is computed from the PWM that was
//! sent. Only where it starts, angle and speed, is taken from the log: once by all of the
//! window, which shows how far the numbers are off; and once by its first quarter of a
//! second alone, which is a forecast. An arm that stands falls away from where it is thought
//! to be as fast as its pole is unstable; a forecast is judged until what is not known of
//! its start, because of the encoder's noise, comes to a count.

use armbridge_shared::JOINTS;
use serde::Serialize;

use super::arm::Known;
use super::checks::{Followed, follow};
use super::dataset::{Trace, Window};
use super::fit_result::Found;
use super::quantity::{COUNT, Quantity};

/// Longest window, in s: in a few time constants of an unstable pole, what is not known of a
/// start outgrows all else.
const LONGEST_S: f64 = 3.0;
/// Length of the part of a window by which its start is found for a forecast, in s.
const START_S: f64 = 0.25;

/// How well a joint's motion is predicted.
#[derive(Clone, Debug, Serialize)]
pub struct Forecast {
    /// From 1.
    pub joint: usize,
    /// Windows in which it slides.
    pub windows: usize,
    /// Their length in all, in s.
    pub slid_s: f64,
    /// The longest, in s.
    pub longest_s: f64,
    /// Root mean square of measured less computed, in counts, noise of the encoder
    /// included, from starts by all of each window.
    pub rms_counts: f64,
    /// What of it is not the encoder's noise.
    pub model_counts: f64,
    /// Time constant of the joint's unstable pole as it stands, in s; none if it hangs.
    pub unstable_s: Option<f64>,
    /// After so long, at the median, what is not known of a start by its first quarter of
    /// a second comes to a count; none if it never does in these windows.
    pub diverges_s: Option<f64>,
    /// Root mean square of measured less forecast until then, in counts, noise included.
    pub ahead_rms_counts: f64,
    /// What of it is not the encoder's noise: errors of start and numbers.
    pub ahead_model_counts: f64,
    /// For how long in all that is, in s.
    pub ahead_s: f64,
}

/// Forecasts of both joints, in logs that the numbers were not found in.
pub fn forecast(found: &Found, traces: &[Trace], known: &Known) -> Vec<Forecast> {
    let known = &known.with(&found.stribeck);
    let zero = [0, 1].map(|joint| found.number(joint, Quantity::Zero).0);
    let traces: Vec<Trace> = traces
        .iter()
        .map(|trace| trace.smoothed(known, zero))
        .collect();
    let most = (LONGEST_S / known.period_s) as usize;
    let windows = |joint: usize| {
        traces
            .iter()
            .enumerate()
            .flat_map(|(index, trace)| trace.windows(index, joint, most))
            .collect::<Vec<Window>>()
    };
    let of_joint = |joint| of_windows(joint, &windows(joint), &traces, known, &found.at);
    (0..JOINTS)
        .map(of_joint)
        .map(|forecast| forecast.less_noise(found.noise_counts))
        .collect()
}

/// How well these windows of a joint are predicted; traces are smoothed.
pub(super) fn of_windows(
    joint: usize,
    windows: &[Window],
    traces: &[Trace],
    known: &Known,
    at: &[f64; COUNT],
) -> Forecast {
    let (mut all, mut ahead) = (Sum::default(), Sum::default());
    let mut diverges = Vec::new();
    for window in windows {
        let trace = &traces[window.trace];
        let fitted = ((START_S / known.period_s) as usize).min(window.len / 2);
        all.add(&follow(window, trace, known, at, window.len), 0..window.len);
        let followed = follow(window, trace, known, at, fitted);
        let beyond = followed
            .spread
            .iter()
            .skip(fitted)
            .position(|spread| *spread > 1.0);
        let end = beyond.map_or(window.len, |beyond| fitted + beyond);
        diverges.extend(beyond.map(|_| end as f64 * known.period_s));
        ahead.add(&followed, fitted..end);
    }
    diverges.sort_by(f64::total_cmp);
    let longest = windows.iter().map(|window| window.len).max().unwrap_or(0);
    Forecast {
        joint: joint + 1,
        windows: windows.len(),
        slid_s: all.ticks * known.period_s,
        longest_s: longest as f64 * known.period_s,
        rms_counts: all.rms(),
        model_counts: all.rms(),
        unstable_s: unstable_s(joint, known, at),
        diverges_s: diverges.get(diverges.len() / 2).copied(),
        ahead_rms_counts: ahead.rms(),
        ahead_model_counts: ahead.rms(),
        ahead_s: ahead.ticks * known.period_s,
    }
}

impl Forecast {
    /// With this noise of the encoder.
    pub(super) fn less_noise(self, noise_counts: f64) -> Self {
        let model = |rms: f64| (rms.powi(2) - noise_counts.powi(2)).max(0.0).sqrt();
        Self {
            model_counts: model(self.rms_counts),
            ahead_model_counts: model(self.ahead_rms_counts),
            ..self
        }
    }

    /// Heads of [`cells`](Self::cells).
    pub const HEADS: [&'static str; 10] = [
        "joint",
        "slides",
        "windows",
        "longest",
        "rms",
        "noise removed",
        "forecast rms",
        "noise removed",
        "unstable pole",
        "diverged after",
    ];

    /// What a table has of it.
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
            seconds(self.slid_s),
            self.windows.to_string(),
            seconds(self.longest_s),
            counts(self.rms_counts),
            counts(self.model_counts),
            format!(
                "{} in {}",
                counts(self.ahead_rms_counts),
                seconds(self.ahead_s)
            ),
            counts(self.ahead_model_counts),
            self.unstable_s.map_or("none".into(), seconds),
            self.diverges_s
                .map_or("not there".into(), |s| format!("after {}", seconds(s))),
        ]
    }
}

/// Squares of errors.
#[derive(Default)]
struct Sum {
    squares: f64,
    ticks: f64,
}

impl Sum {
    fn add(&mut self, followed: &Followed, part: core::ops::Range<usize>) {
        for error in followed.errors[part]
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

/// Time constant with which a joint falls from upright, the other being upright too.
fn unstable_s(joint: usize, known: &Known, at: &[f64; COUNT]) -> Option<f64> {
    let number =
        |joint: usize, quantity: Quantity| -> f64 { quantity.value(at[quantity.at(joint)]) };
    let link = number(1, Quantity::Gravity);
    let [p, e] = known.reach(link);
    let (mass, gravity) = match joint {
        0 => (
            number(0, Quantity::Inertia) + p + e,
            number(0, Quantity::Gravity) + link,
        ),
        _ => (number(joint, Quantity::Inertia), link),
    };
    let viscous = number(joint, Quantity::Viscous);
    // mass x² + viscous x - gravity = 0
    let root = (viscous * viscous + 4.0 * mass * gravity).sqrt();
    (known.stands() > 0.0).then(|| 2.0 * mass / (root - viscous))
}

#[cfg(test)]
mod tests {
    use super::*;
    use armbridge_shared::link::message::Setup;

    #[test]
    fn the_papers_arm_falls_with_the_poles_of_its_linear_model() {
        let setup = Setup::default();
        let mut at = [0.0; COUNT];
        for joint in 0..JOINTS {
            for quantity in Quantity::ALL {
                at[quantity.at(joint)] = quantity.coordinate(quantity.of(&setup, joint));
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
            let found = unstable_s(joint, &Known::of(&setup), &at).unwrap();
            assert!((found * pole - 1.0).abs() < 1e-6, "{found} s, {pole} 1/s");
        }
        let mut known = Known::of(&setup);
        known.mounting = armbridge_shared::arm::Mounting::Hanging;
        assert_eq!(unstable_s(0, &known, &at), None);
    }
}
