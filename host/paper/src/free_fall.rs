//! Fig. 5: free fall of joint 1 from near upright, and the fit of b1 to it.

use core::f64::consts::{FRAC_PI_2, PI};

use armbridge_control::arm::Parameters;

use super::chart::{CORRECTED, Chart, Curve, DIFFERENCE, Figure, Level, MODEL, Subplot};
use super::claim::{Claim, Number, Rule};
use super::identification::{JointParameters, SampledExperiment, VISCOUS, VirtualArm, fit};
use super::printed::{B1_FALL, B1_PUSH, PERIOD_S};
use super::pwm::PwmLaw;
use super::text::number;

/// Start angle of falls without dry friction, in rad.
const NEAR_UPRIGHT_RAD: f64 = 0.1;

/// Results of the run.
#[derive(Clone, Debug)]
pub struct FreeFall {
    /// b1 fitted to a fall of the arm of (7), in N m s/rad.
    pub b1_without: f64,
    /// Coulomb friction in N m with which the same fit gives the paper's b1.
    pub coulomb_nm: f64,
    /// b1 of that fit, in N m s/rad.
    pub b1_with: f64,
    /// Angle between that arm at rest and hanging down, in degrees.
    pub short_deg: f64,
    /// Change of the time to a quarter turn, with half and one and a half times
    /// the inertia, in per cent.
    pub inertia_effect: [f64; 2],
    /// Change of that time with half and one and a half times b1, in per cent.
    pub friction_effect: [f64; 2],
    /// Fall of the arm with dry friction.
    dry: SampledExperiment,
}

impl FreeFall {
    /// Simulates falls with and without dry friction, and fits b1 to them.
    pub fn compute() -> Self {
        let arm = Parameters::<f64>::paper();
        let smooth = VirtualArm::paper(arm.b1, 0.0, 0).with_ideal_encoder();
        let smooth = smooth.free_fall(NEAR_UPRIGHT_RAD, 4.0);

        // The fitted b1 increases with dry friction: bisect.
        let (mut low_nm, mut high_nm) = (0.02, 0.2);
        for _ in 0..16 {
            let middle_nm = f64::midpoint(low_nm, high_nm);
            if fit_b1(&fall_with(middle_nm)) < B1_FALL {
                low_nm = middle_nm;
            } else {
                high_nm = middle_nm;
            }
        }
        let coulomb_nm = f64::midpoint(low_nm, high_nm);
        let fall = fall_with(coulomb_nm);
        let end_rad = fall.points().last().map_or(f64::NAN, |(_, q)| q);

        let nominal_s = quarter_turn_s(&arm);
        let change = |arm: Parameters<f64>| 100.0 * (quarter_turn_s(&arm) / nominal_s - 1.0);
        let inertia = |scale: f64| Parameters {
            i1x: arm.i1x * scale,
            i2x: arm.i2x * scale,
            i2y: arm.i2y * scale,
            i2z: arm.i2z * scale,
            ..arm
        };
        let friction = |scale: f64| Parameters {
            b1: arm.b1 * scale,
            ..arm
        };
        Self {
            b1_without: fit_b1(&smooth),
            coulomb_nm,
            b1_with: fit_b1(&fall),
            short_deg: (PI - end_rad).to_degrees(),
            inertia_effect: [0.5, 1.5].map(|scale| change(inertia(scale))),
            friction_effect: [0.5, 1.5].map(|scale| change(friction(scale))),
            dry: fall,
        }
    }

    /// The claims about the free fall.
    pub fn claims(&self) -> Vec<Claim> {
        vec![self.friction_claim(), self.inertia_claim()]
    }

    fn friction_claim(&self) -> Claim {
        let b1 = |quantity, found| {
            Number::new(quantity, "N m s/rad", found, Rule::Within(B1_FALL, 0.002))
        };
        let dead_zone_nm = PwmLaw::compute().dead_zone_half_nm();
        Claim {
            id: "fall",
            title: "Fig. 5: free fall",
            paper: format!(
                "A fit to a free fall gives b1 = {B1_FALL}. The form is not exactly that of the \
                 data, and the arm does not reach 180°, because of static friction."
            ),
            finding: format!(
                "The arm of (7) has b1 = {}, and the fit recovers {}. With {} N m of Coulomb \
                 friction and b1 = {B1_PUSH}, a fit of viscous friction alone gives {}, and the \
                 arm comes to rest {}° short of 180°.",
                Parameters::<f64>::paper().b1,
                number(self.b1_without, 3),
                number(self.coulomb_nm, 3),
                number(self.b1_with, 3),
                number(self.short_deg, 1),
            ),
            explanation: format!(
                "A fit of viscous friction alone attributes dry friction to it. The paper's \
                 {B1_FALL} and {B1_PUSH} then describe the same arm in two experiments. The dry \
                 friction required is {} times the half width of the dead zone, {} N m: \
                 back-driving a gear takes more torque.",
                number(self.coulomb_nm / dead_zone_nm, 1),
                number(dead_zone_nm, 2),
            ),
            remedy: "Fit Coulomb friction together with b1. The measured curve is not available; \
                     the figure shows the simulated arm with dry friction."
                .into(),
            printed: vec![b1("b1 fitted to a fall of the arm of (7)", self.b1_without)],
            reading: vec![
                b1("b1 fitted to a fall with dry friction", self.b1_with),
                Number::new(
                    "Distance from 180° at rest with dry friction",
                    "°",
                    self.short_deg,
                    Rule::AtLeast(1.0),
                ),
                Number::new(
                    "Ratio of Coulomb friction to the dead zone's half width",
                    "",
                    self.coulomb_nm / dead_zone_nm,
                    Rule::AtMost(2.0),
                ),
            ],
            figures: vec![self.figure()],
        }
    }

    fn inertia_claim(&self) -> Claim {
        let largest = |effect: [f64; 2]| effect[0].abs().max(effect[1].abs());
        let ratio = largest(self.inertia_effect) / largest(self.friction_effect);
        Claim {
            id: "inertia",
            title: "The effect of the inertias",
            paper: "The inertia parameters have a relatively small effect on the overall system."
                .into(),
            finding: format!(
                "Half and one and a half times the moments of inertia change the time of the fall \
                 to 90° by {} and {} %; half and one and a half times b1 change it by {} and {} %.",
                number(self.inertia_effect[0], 1),
                number(self.inertia_effect[1], 1),
                number(self.friction_effect[0], 1),
                number(self.friction_effect[1], 1),
            ),
            explanation: "The fall is slow: friction, not inertia, balances the gravity torque."
                .into(),
            remedy:
                "No correction is needed. It also follows that a free fall cannot identify the \
                     inertia."
                    .into(),
            printed: vec![Number::new(
                "Ratio of the effects of inertia and friction on the fall",
                "",
                ratio,
                Rule::AtMost(0.5),
            )],
            reading: Vec::new(),
            figures: Vec::new(),
        }
    }

    fn figure(&self) -> Figure {
        let arm = Parameters::<f64>::paper();
        let degrees = self.dry.points().map(|(t, q)| (t, q.to_degrees()));
        let from_rad = self.dry.start_rad;
        let motion = |b1| {
            let numbers = JointParameters {
                b1,
                ..JointParameters::from_arm(&arm)
            };
            let motion = numbers.motion(from_rad, PERIOD_S, self.dry.angles_rad.len());
            motion.map(|(t, q)| (t, q.to_degrees())).collect()
        };
        let mut subplot = Subplot::new(
            "Joint 1",
            "angle (°)",
            vec![
                Curve::new("dry friction", DIFFERENCE, degrees.collect()),
                Curve::new("fit, viscous only", MODEL, motion(self.b1_with)),
                Curve::new("true b1, no dry friction", CORRECTED, motion(B1_PUSH)),
            ],
        );
        subplot.y = Some([0.0, 195.0]);
        subplot.levels = vec![Level {
            name: "hanging down".to_owned(),
            y: 180.0,
        }];
        Figure {
            name: "fig5",
            paper_figure: Some("Fig. 5"),
            caption: format!(
                "Free fall of joint 1 from {} rad. The paper's measured curve is not available; \
                 the curve is that of the simulated arm with {} N m of Coulomb friction and \
                 b1 = {B1_PUSH}, which stops short of 180° as the paper's arm does. A fit of \
                 viscous friction alone gives b1 = {}.",
                number(from_rad, 3),
                number(self.coulomb_nm, 3),
                number(self.b1_with, 3),
            ),
            chart: Chart {
                title: "Free fall",
                x_title: "time (s)",
                x: [0.0, 4.0],
                panels: vec![subplot],
            },
        }
    }
}

/// Free fall with dry friction of the arm that the constant input identified.
fn fall_with(coulomb_nm: f64) -> SampledExperiment {
    VirtualArm::paper(B1_PUSH, coulomb_nm, 0)
        .with_ideal_encoder()
        .paper_fall()
}

/// b1 of the model without dry friction, fitted to a fall.
fn fit_b1(fall: &SampledExperiment) -> f64 {
    let guess = JointParameters::from_arm(&Parameters::paper());
    let fit = fit(std::slice::from_ref(fall), VISCOUS, &guess);
    fit.map_or(f64::NAN, |fit| fit.parameters.b1)
}

/// Time in s of a fall from near upright to a quarter turn.
fn quarter_turn_s(arm: &Parameters<f64>) -> f64 {
    let motion = JointParameters::from_arm(arm).motion(NEAR_UPRIGHT_RAD, 0.005, 2000);
    let mut beyond = motion.filter(|(_, q)| *q >= FRAC_PI_2);
    beyond.next().map_or(f64::NAN, |(time_s, _)| time_s)
}
