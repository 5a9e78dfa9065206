//! Equation (5): the PWM that gives no torque.

use armbridge_control::actuator::Joint;
use armbridge_servo::Pwm;

use super::claim::{Claim, Number, Rule};
use super::printed::DEAD_ZONE;
use super::text::number;

/// Results of the run.
#[derive(Clone, Debug)]
pub struct PwmLaw {
    /// PWM that (5) gives for no torque.
    pub zero_counts: f64,
    /// Torque in N m by (5) at both ends of the dead zone.
    pub dead_zone_nm: [f64; 2],
    /// Smallest and largest torque in N m that (5) can command.
    pub limits_nm: [f64; 2],
}

impl PwmLaw {
    /// Evaluates (5).
    pub fn compute() -> Self {
        let joint = Joint::<f64>::paper();
        let torque = |counts| joint.torque(Pwm::saturating(counts));
        Self {
            zero_counts: f64::from(Pwm::OFF.counts()) + joint.offset_counts,
            dead_zone_nm: DEAD_ZONE.map(torque),
            limits_nm: [Pwm::MIN, Pwm::MAX].map(|pwm| joint.torque(pwm)),
        }
    }

    /// Half the width of the dead zone in N m.
    pub fn dead_zone_half_nm(&self) -> f64 {
        (self.dead_zone_nm[1] - self.dead_zone_nm[0]) / 2.0
    }

    /// The claim about (5).
    pub fn claims(&self) -> Vec<Claim> {
        let joint = Joint::<f64>::paper();
        let off = Pwm::OFF.counts();
        let [low, high] = self.dead_zone_nm;
        vec![Claim {
            id: "pwm",
            title: "Equation (5): torque and PWM",
            paper: format!(
                "PWM = {}τ + {} + {off}. A PWM of {off} gives no torque; between {} and {} the \
                 torque is too small to move the motors.",
                joint.gain_counts_per_nm, joint.offset_counts, DEAD_ZONE[0], DEAD_ZONE[1],
            ),
            finding: format!(
                "By (5), zero torque is PWM {}, and the dead zone extends from {} to {} N m, {} \
                 times as far below zero as above. The range of (5) is {} to {} N m.",
                number(self.zero_counts, 0),
                number(low, 4),
                number(high, 4),
                number(-low / high, 1),
                number(self.limits_nm[0], 3),
                number(self.limits_nm[1], 3),
            ),
            explanation:
                "The formula and the text next to it contradict each other. The offset was \
                          probably fitted to the constant input, which moves the arm in one \
                          direction only and therefore includes the dry friction of that \
                          direction. This is an inference."
                    .into(),
            remedy: format!(
                "Measure the offset in both directions. The library converts by (5), reserves \
                 {off} for a motor that is off, and never sends it for a torque."
            ),
            printed: vec![
                Number::new(
                    "PWM for no torque by (5)",
                    "counts",
                    self.zero_counts,
                    Rule::Within(off.into(), 0.5),
                ),
                Number::new(
                    "Centre of the dead zone by (5)",
                    "N m",
                    f64::midpoint(low, high),
                    Rule::Within(0.0, 0.5 / joint.gain_counts_per_nm),
                ),
            ],
            reading: Vec::new(),
            figures: Vec::new(),
        }]
    }
}
