//! Report of a fit, as a table and as data.

use armbridge_log::text_table;
use serde::Serialize;

use super::arm::KnownParameters;
use super::fit_result::FitResult;
use super::prior::Prior;
use super::quantity::Quantity;

/// Standard errors on either side of a 95 % interval.
const Z_95: f64 = 1.96;

/// Estimate of a joint's parameter.
#[derive(Clone, Debug, Serialize)]
pub struct Estimate {
    /// Joint, from 1.
    pub joint: usize,
    /// Name.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Estimated value.
    pub value: f64,
    /// Half-width of its 95 % confidence interval.
    pub half_width_95: f64,
    /// Prior mean; `None` for static friction, the Stribeck curve and load friction.
    pub prior_mean: Option<f64>,
    /// Remark; empty for most.
    pub remark: &'static str,
}

/// Report of a fit.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Estimates, joint by joint.
    pub estimates: Vec<Estimate>,
    /// Joints, from 1, whose static friction is not identified: too few breakaways.
    pub static_friction_unidentified: Vec<usize>,
    /// Seconds of the logs in which a joint slides.
    pub sliding_s: f64,
    /// Number of windows.
    pub windows: usize,
    /// Number of windows that are outliers.
    pub outliers: usize,
    /// Standard deviation of an encoder's noise in counts, rounding included.
    pub noise_counts: f64,
}

impl Report {
    /// Report of a fit to logs of an arm with these known parameters.
    pub fn new(fit: &FitResult, prior: &Prior, known: &KnownParameters) -> Self {
        let mut estimates = Vec::new();
        for joint in 0..known.joints {
            for quantity in Quantity::ALL {
                let (value, error) = fit.estimate(joint, quantity);
                let prior_mean: f64 = quantity.value(prior.mean[quantity.index(joint)]);
                let remark = remark(fit, prior, joint, quantity);
                estimates.push(Estimate {
                    joint: joint + 1,
                    name: quantity.name(),
                    unit: quantity.unit(),
                    value,
                    half_width_95: Z_95 * error,
                    prior_mean: Some(prior_mean),
                    remark,
                });
            }
            estimates.extend(fit.stribeck[joint].iter().flat_map(|curve| {
                let estimate = |name, unit, value: f64, error: f64| Estimate {
                    joint: joint + 1,
                    name,
                    unit,
                    value,
                    half_width_95: Z_95 * error,
                    prior_mean: None,
                    remark: "dry friction falls with speed",
                };
                let torque = Quantity::Coulomb.unit();
                [
                    estimate(
                        "Stribeck friction",
                        torque,
                        curve.drop_nm,
                        curve.drop_error_nm,
                    ),
                    estimate(
                        "Stribeck speed",
                        "rad/s",
                        curve.speed_rad_s,
                        curve.speed_error_rad_s,
                    ),
                ]
            }));
            estimates.extend(fit.load[joint].map(|load| Estimate {
                joint: joint + 1,
                name: "load friction",
                unit: "N m/N m",
                value: load.load,
                half_width_95: Z_95 * load.error,
                prior_mean: None,
                remark: "dry friction grows with the load on the gears",
            }));
            estimates.extend(fit.static_friction[joint].map(|friction| Estimate {
                joint: joint + 1,
                name: "static friction",
                unit: Quantity::Coulomb.unit(),
                value: friction.torque_nm,
                half_width_95: Z_95 * friction.error_nm,
                prior_mean: None,
                remark: "",
            }));
        }
        let ticks = fit.window_ticks();
        let joints = 1..=known.joints;
        let is_unidentified = |joint: &usize| fit.static_friction[joint - 1].is_none();
        Self {
            estimates,
            static_friction_unidentified: joints.filter(is_unidentified).collect(),
            sliding_s: ticks as f64 * known.period_s,
            windows: fit.window_fits.len(),
            outliers: fit.outliers(),
            noise_counts: fit.noise_counts,
        }
    }

    /// The table as text, ending in a line feed.
    pub fn table(&self) -> String {
        let mut rows = vec![
            [
                "joint",
                "parameter",
                "estimate",
                "95 % interval",
                "unit",
                "prior",
                "",
            ]
            .map(str::to_owned)
            .to_vec(),
        ];
        for estimate in &self.estimates {
            rows.push(estimate.cells());
        }
        let unidentified = self.static_friction_unidentified.iter().map(|joint| {
            format!("static friction of joint {joint} not identified: too few breakaways\n")
        });
        format!(
            "{}{}\n{:.1} s of sliding in {} windows, {} of them rejected; residual {:.2} counts\n",
            text_table::columns(&rows),
            unidentified.collect::<String>(),
            self.sliding_s,
            self.windows,
            self.outliers,
            self.noise_counts
        )
    }
}

impl Estimate {
    /// Cells of a table row: joint, name, value, interval, unit, prior mean, remark.
    pub(super) fn cells(&self) -> Vec<String> {
        vec![
            self.joint.to_string(),
            self.name.to_owned(),
            digits(self.value, self.half_width_95),
            format!("± {}", digits(self.half_width_95, self.half_width_95)),
            self.unit.to_owned(),
            self.prior_mean.map_or_else(String::new, |prior_mean| {
                digits(prior_mean, self.half_width_95)
            }),
            self.remark.to_owned(),
        ]
    }
}

/// Remark on an estimate; empty for most.
fn remark(fit: &FitResult, prior: &Prior, joint: usize, quantity: Quantity) -> &'static str {
    if fit.is_unidentified(prior, joint, quantity) {
        return "not identifiable from these logs";
    }
    if fit.is_fixed_by_weight(joint, quantity) {
        return "scale fixed by the arm's weight";
    }
    // On average a dead zone about the motor's true neutral removes no torque.
    let (offset, _) = fit.estimate(joint, Quantity::Offset);
    let (edge, error) = fit.estimate(joint, quantity);
    if fit.has_no_dead_zone(quantity.index(joint)) {
        return "none";
    }
    let may_be_zero = match quantity {
        Quantity::DeadBelow => edge < -2.0 * offset + Z_95 * error,
        Quantity::DeadAbove => edge < 2.0 * offset + Z_95 * error,
        Quantity::Inertia
        | Quantity::Gravity
        | Quantity::Viscous
        | Quantity::Coulomb
        | Quantity::Gain
        | Quantity::Offset
        | Quantity::Zero
        | Quantity::Delay => false,
    };
    if may_be_zero { "may be zero" } else { "" }
}

/// A value to two digits of its uncertainty.
pub(super) fn digits(value: f64, half_width_95: f64) -> String {
    let places = if half_width_95 > 0.0 && half_width_95.is_finite() {
        (1.0 - half_width_95.log10().floor()).clamp(0.0, 9.0) as usize
    } else {
        6
    };
    format!("{value:.places$}")
}
