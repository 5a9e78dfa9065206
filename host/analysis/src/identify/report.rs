//! What was found, as a table and as data.

use armbridge_log::text_table;
use armbridge_shared::JOINTS;
use serde::Serialize;

use super::fit_result::Found;
use super::quantity::Quantity;
use super::search::Prior;

/// Standard errors to either side in which a number is with 95 %.
const INTERVAL: f64 = 1.96;

/// A number of a joint.
#[derive(Clone, Debug, Serialize)]
pub struct Number {
    /// From 1.
    pub joint: usize,
    /// Its name.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// What was found.
    pub value: f64,
    /// Half of its 95 % interval.
    pub within: f64,
    /// What was believed before; nothing of static friction, nor of how dry friction falls.
    pub before: Option<f64>,
    /// What is to be kept in mind of it; empty for most.
    pub remark: &'static str,
}

/// All of it.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Joint by joint.
    pub numbers: Vec<Number>,
    /// Joints, from 1, whose static friction is not identified: too few breakaways.
    pub never_gave_way: Vec<usize>,
    /// Seconds of the logs in which a joint slides.
    pub sliding_s: f64,
    /// Windows of these that were compared.
    pub windows: usize,
    /// Of these, how many the model does not explain.
    pub odd: usize,
    /// Standard deviation of an encoder's noise in counts, rounding included.
    pub noise_counts: f64,
}

impl Report {
    /// Of what was found in logs with this tick period.
    pub fn new(found: &Found, prior: &Prior, period_s: f64) -> Self {
        let mut numbers = Vec::new();
        for joint in 0..JOINTS {
            for quantity in Quantity::ALL {
                let (value, error) = found.number(joint, quantity);
                let before: f64 = quantity.value(prior.mean[quantity.at(joint)]);
                let remark = remark(found, prior, joint, quantity);
                numbers.push(Number {
                    joint: joint + 1,
                    name: quantity.name(),
                    unit: quantity.unit(),
                    value,
                    within: INTERVAL * error,
                    before: Some(before),
                    remark,
                });
            }
            numbers.extend(found.stribeck[joint].iter().flat_map(|of| {
                let number = |name, unit, value: f64, error: f64| Number {
                    joint: joint + 1,
                    name,
                    unit,
                    value,
                    within: INTERVAL * error,
                    before: None,
                    remark: "dry friction falls with speed",
                };
                let torque = Quantity::Coulomb.unit();
                [
                    number("Stribeck friction", torque, of.drop_nm, of.drop_error_nm),
                    number(
                        "Stribeck speed",
                        "rad/s",
                        of.speed_rad_s,
                        of.speed_error_rad_s,
                    ),
                ]
            }));
            numbers.extend(found.friction[joint].map(|friction| Number {
                joint: joint + 1,
                name: "static friction",
                unit: Quantity::Coulomb.unit(),
                value: friction.torque_nm,
                within: INTERVAL * friction.error_nm,
                before: None,
                remark: "",
            }));
        }
        let ticks: usize = found
            .stretches
            .iter()
            .map(|stretch| stretch.window.len)
            .sum();
        let joints = 1..=JOINTS;
        let is_silent = |joint: &usize| found.friction[joint - 1].is_none();
        Self {
            numbers,
            never_gave_way: joints.filter(is_silent).collect(),
            sliding_s: ticks as f64 * period_s,
            windows: found.stretches.len(),
            odd: found.odd(),
            noise_counts: found.noise_counts,
        }
    }

    /// As text, ending in a line feed.
    pub fn table(&self) -> String {
        let mut rows = vec![
            [
                "joint",
                "parameter",
                "estimate",
                "95 % interval",
                "unit",
                "before",
                "",
            ]
            .map(str::to_owned)
            .to_vec(),
        ];
        for number in &self.numbers {
            rows.push(number.cells());
        }
        let silent = self.never_gave_way.iter().map(|joint| {
            format!("static friction of joint {joint} not identified: too few breakaways\n")
        });
        format!(
            "{}{}\n{:.1} s of sliding in {} windows, {} of them rejected; residual {:.2} counts\n",
            text_table::columns(&rows),
            silent.collect::<String>(),
            self.sliding_s,
            self.windows,
            self.odd,
            self.noise_counts
        )
    }
}

impl Number {
    /// What a table has of it: joint, name, value, interval, unit, before, remark.
    pub(super) fn cells(&self) -> Vec<String> {
        vec![
            self.joint.to_string(),
            self.name.to_owned(),
            digits(self.value, self.within),
            format!("± {}", digits(self.within, self.within)),
            self.unit.to_owned(),
            self.before
                .map_or_else(String::new, |before| digits(before, self.within)),
            self.remark.to_owned(),
        ]
    }
}

/// What is to be kept in mind of a number; nothing of most.
fn remark(found: &Found, prior: &Prior, joint: usize, quantity: Quantity) -> &'static str {
    if found.is_unseen(prior, joint, quantity) {
        return "not identifiable from these logs";
    }
    if found.rests_on_weight(joint, quantity) {
        return "scale fixed by the arm's weight";
    }
    // What a dead zone about the motor's true zero takes away is none on average.
    let (offset, _) = found.number(joint, Quantity::Offset);
    let (edge, error) = found.number(joint, quantity);
    if found.has_none(quantity.at(joint)) {
        return "none";
    }
    let is_alike = match quantity {
        Quantity::DeadBelow => edge < -2.0 * offset + INTERVAL * error,
        Quantity::DeadAbove => edge < 2.0 * offset + INTERVAL * error,
        Quantity::Inertia
        | Quantity::Gravity
        | Quantity::Viscous
        | Quantity::Coulomb
        | Quantity::Gain
        | Quantity::Offset
        | Quantity::Zero
        | Quantity::Delay => false,
    };
    if is_alike { "may be zero" } else { "" }
}

/// A number to two digits of how far it may be off.
pub(super) fn digits(value: f64, within: f64) -> String {
    let places = if within > 0.0 && within.is_finite() {
        (1.0 - within.log10().floor()).clamp(0.0, 9.0) as usize
    } else {
        6
    };
    format!("{value:.places$}")
}
