//! Equation (5): which PWM gives no torque.

use armbridge_shared::actuator::{Joint, Pwm};

use super::claim::{Claim, Number, Rule};
use super::printed::DEAD_ZONE;
use super::text::number;

/// What the run finds.
#[derive(Clone, Debug)]
pub struct PwmLaw {
    /// PWM that (5) gives for no torque.
    pub zero_counts: f64,
    /// Torque in N m by (5) at both ends of the dead zone.
    pub dead_zone_nm: [f64; 2],
    /// Largest torques in N m that (5) can ask for.
    pub limits_nm: [f64; 2],
}

impl PwmLaw {
    /// Evaluates (5).
    pub fn find() -> Self {
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
                "PWM = {}τ + {} + {off}. A PWM of {off} is no torque; between {} and {} the \
                 torque is not enough to move the motors.",
                joint.gain_counts_per_nm, joint.offset_counts, DEAD_ZONE[0], DEAD_ZONE[1],
            ),
            find: format!(
                "By (5) no torque is PWM {}, and the dead zone reaches from {} to {} N m, {} \
                 times as far down as up. The servo can be asked for {} to {} N m.",
                number(self.zero_counts, 0),
                number(low, 4),
                number(high, 4),
                number(-low / high, 1),
                number(self.limits_nm[0], 3),
                number(self.limits_nm[1], 3),
            ),
            why: "The formula and the text next to it contradict each other. The offset was \
                  found together with the constant input, which moves one way only and so takes \
                  in the dry friction of that direction; but that is an inference."
                .into(),
            mend: format!(
                "Measure the offset for both directions. The library converts by (5), keeps \
                 {off} exactly for the motor that is off, and never sends it for a torque."
            ),
            printed: vec![
                Number::new(
                    "PWM for no torque by (5)",
                    "counts",
                    self.zero_counts,
                    Rule::Within(off.into(), 0.5),
                ),
                Number::new(
                    "Middle of the dead zone by (5)",
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
