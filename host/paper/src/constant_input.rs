//! Fig. 6: a constant torque on joint 1, and the fit of b1 and that torque.

use core::f64::consts::FRAC_PI_2;

use armbridge_control::arm::Parameters;
use armbridge_sim::plant::{Friction, PlantConfig};

use super::chart::{Chart, Curve, DIFFERENCE, Figure, Level, MODEL, Subplot, WRONG};
use super::claim::{Claim, Number, Rule};
use super::identification::{JointParameters, SampledExperiment, VISCOUS_TORQUE, VirtualArm, fit};
use super::printed::{B1_FALL, B1_PUSH, PERIOD_S, PUSH_FROM_RAD, PUSH_NM};
use super::text::number;

/// Samples until just before the table stops the arm, 1.3 s.
const SAMPLES: u32 = 30;
/// Duration of those samples in s: half a period beyond the last.
const DURATION_S: f64 = (SAMPLES as f64 - 0.5) * PERIOD_S;

/// Results of the run.
#[derive(Clone, Debug)]
pub struct ConstantInput {
    /// b1 in N m s/rad and torque in N m, fitted to an arm without dry friction.
    pub without: [f64; 2],
    /// b1 and torque fitted to an arm with dry friction under the same motor torque.
    pub with: [f64; 2],
    /// Dry friction of that arm.
    pub friction: Friction,
    /// Time in s at which the arm passes upright.
    pub upright_s: f64,
    /// That time in s with the b1 of the free fall.
    pub upright_with_b1_of_fall_s: f64,
    /// Motion with dry friction and a motor torque larger by the Coulomb friction.
    dry: SampledExperiment,
}

impl ConstantInput {
    /// Simulates the push with and without dry friction, and fits b1 and torque.
    pub fn compute() -> Self {
        let friction = PlantConfig::default().friction[0];
        let upright_s = |b1| {
            let mut beyond = viscous(b1).motion(PUSH_FROM_RAD, 0.001, 3000);
            let first = beyond.find(|(_, q)| *q <= 0.0);
            first.map_or(f64::NAN, |(time_s, _)| time_s)
        };
        Self {
            without: fit_both(Friction::NONE),
            with: fit_both(friction),
            friction,
            upright_s: upright_s(B1_PUSH),
            upright_with_b1_of_fall_s: upright_s(B1_FALL),
            dry: arm(friction)
                .with_ideal_encoder()
                .constant_input(PUSH_NM - friction.coulomb_nm, DURATION_S),
        }
    }

    /// The claim about the constant input.
    pub fn claims(&self) -> Vec<Claim> {
        let b1 = |quantity, found| {
            Number::new(quantity, "N m s/rad", found, Rule::Within(B1_PUSH, 0.002))
        };
        let torque = |quantity, found, expected| {
            Number::new(quantity, "N m", found, Rule::Within(expected, 0.001))
        };
        let coulomb_nm = self.friction.coulomb_nm;
        vec![Claim {
            id: "push",
            title: "Fig. 6: constant input",
            paper: format!(
                "From {PUSH_FROM_RAD} rad under a constant torque, a fit of torque and friction \
                 gives τ = {} N m and b1 = {B1_PUSH}; at the beginning the arm deviates from the \
                 model.",
                number(PUSH_NM, 4),
            ),
            finding: format!(
                "{SAMPLES} encoder samples, taken before the arm meets the table, suffice for \
                 both: the arm of (7), pushed with {} N m, gives τ = {} N m and b1 = {}. It passes \
                 upright after {} s; with the b1 of the free fall it would pass after {} s.",
                number(PUSH_NM, 4),
                number(self.without[1], 4),
                number(self.without[0], 4),
                number(self.upright_s, 2),
                number(self.upright_with_b1_of_fall_s, 2),
            ),
            explanation: format!(
                "The arm moves in one direction only, so dry friction is a constant torque like the \
                 motor's. With {} N m of Coulomb friction the fit gives {} N m, the sum of the \
                 two, and still the correct b1, {}. The paper's τ, and therefore (5), includes the \
                 dry friction of one direction.",
                number(coulomb_nm, 2),
                number(self.with[1], 4),
                number(self.with[0], 4),
            ),
            remedy: "Push with several PWM values in both directions. The fitted torques over PWM \
                     form two lines: their slope is that of (5), and the step between them is \
                     twice the dry friction."
                .into(),
            printed: vec![
                b1("b1 fitted to the constant input", self.without[0]),
                torque(
                    "Torque fitted to the constant input",
                    self.without[1],
                    PUSH_NM,
                ),
            ],
            reading: vec![
                b1("b1 fitted with dry friction", self.with[0]),
                torque(
                    "Torque fitted with dry friction",
                    self.with[1],
                    PUSH_NM + coulomb_nm,
                ),
            ],
            figures: vec![self.figure()],
        }]
    }

    fn figure(&self) -> Figure {
        let model = |b1| viscous(b1).motion(PUSH_FROM_RAD, PERIOD_S, 60).collect();
        let mut subplot = Subplot::new(
            "Joint 1",
            "angle (rad)",
            vec![
                Curve::new("b1 of the free fall", WRONG, model(B1_FALL)),
                Curve::new(
                    "dry friction, larger torque",
                    DIFFERENCE,
                    self.dry.points().collect(),
                ),
                Curve::new("b1 of this experiment", MODEL, model(B1_PUSH)),
            ],
        );
        subplot.y = Some([-1.75, 0.6]);
        subplot.levels = vec![Level {
            name: "table".to_owned(),
            y: -FRAC_PI_2,
        }];
        Figure {
            name: "fig6",
            paper_figure: Some("Fig. 6"),
            caption: format!(
                "Joint 1 from {PUSH_FROM_RAD} rad under {} N m. The paper's measured curve is \
                 not available. An arm with {} N m of Coulomb friction and a torque larger by that \
                 amount moves like the model without friction: the experiment cannot distinguish \
                 them. This friction model does not show the real arm's deviation at the beginning \
                 either.",
                number(PUSH_NM, 4),
                number(self.friction.coulomb_nm, 2),
            ),
            chart: Chart {
                title: "Constant input",
                x_title: "time (s)",
                x: [0.0, 2.0],
                panels: vec![subplot],
            },
        }
    }
}

/// The paper's model under its constant torque, with `b1` in N m s/rad.
fn viscous(b1: f64) -> JointParameters {
    JointParameters {
        b1,
        torque_nm: PUSH_NM,
        ..JointParameters::from_arm(&Parameters::paper())
    }
}

/// The arm of (7) with dry friction and a noiseless encoder.
fn arm(friction: Friction) -> VirtualArm {
    VirtualArm {
        friction,
        noise_rad: 0.0,
        ..VirtualArm::paper(Parameters::<f64>::paper().b1, 0.0, 0)
    }
}

/// b1 and torque of the model without dry friction, fitted to a push of that arm.
fn fit_both(friction: Friction) -> [f64; 2] {
    let push = arm(friction).constant_input(PUSH_NM, DURATION_S);
    let guess = JointParameters {
        b1: 0.3,
        torque_nm: -0.35,
        ..JointParameters::from_arm(&Parameters::paper())
    };
    let fit = fit(&[push], VISCOUS_TORQUE, &guess);
    fit.map_or([f64::NAN; 2], |fit| {
        [fit.parameters.b1, fit.parameters.torque_nm]
    })
}
