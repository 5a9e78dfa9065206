//! Fig. 6: a constant torque on joint 1, and b1 and that torque fitted to it.

use core::f64::consts::FRAC_PI_2;

use armbridge_shared::arm::Parameters;
use armbridge_sim::plant::{Friction, PlantConfig};

use super::chart::{Chart, Curve, DIFFERENCE, Figure, Level, MODEL, Part, WRONG};
use super::claim::{Claim, Number, Rule};
use super::identification::{Numbers, Sampled, VISCOUS_TORQUE, VirtualArm, fit};
use super::printed::{B1_FALL, B1_PUSH, PERIOD_S, PUSH_FROM_RAD, PUSH_NM};
use super::text::number;

/// Samples until just before the table stops the arm, 1.3 s.
const SAMPLES: u32 = 30;
/// As long as it takes for them: half a period beyond the last.
const DURATION_S: f64 = (SAMPLES as f64 - 0.5) * PERIOD_S;

/// What the run finds.
#[derive(Clone, Debug)]
pub struct Push {
    /// b1 in N m s/rad and torque in N m, fitted without dry friction.
    pub without: [f64; 2],
    /// The same with dry friction, the motor's torque being the same.
    pub with: [f64; 2],
    /// That dry friction.
    pub friction: Friction,
    /// When the arm passes upright, in s.
    pub upright_s: f64,
    /// The same with the b1 of the free fall.
    pub upright_with_b1_of_fall_s: f64,
    /// Angles of the arm with dry friction whose motor gives as much more.
    dry: Sampled,
}

impl Push {
    /// Pushes the arm, with and without dry friction, and fits.
    pub fn find() -> Self {
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
                .seen_exactly()
                .constant_input(PUSH_NM - friction.coulomb_nm, DURATION_S),
        }
    }

    /// The claim about the constant input.
    pub fn claims(&self) -> Vec<Claim> {
        let b1 = |what, found| Number::new(what, "N m s/rad", found, Rule::Within(B1_PUSH, 0.002));
        let torque =
            |what, found, expected| Number::new(what, "N m", found, Rule::Within(expected, 0.001));
        let coulomb_nm = self.friction.coulomb_nm;
        vec![Claim {
            id: "push",
            title: "Fig. 6: constant input",
            paper: format!(
                "From {PUSH_FROM_RAD} rad under a constant torque, a fit of torque and friction \
                 gives τ = {} N m and b1 = {B1_PUSH}; at the beginning the arm behaves otherwise.",
                number(PUSH_NM, 4),
            ),
            find: format!(
                "{SAMPLES} samples of the encoder, up to the table, are enough for both: the arm \
                 that made (7), pushed with {} N m, gives τ = {} N m and b1 = {}. It passes \
                 upright after {} s; with the free fall's b1 it would after {} s.",
                number(PUSH_NM, 4),
                number(self.without[1], 4),
                number(self.without[0], 4),
                number(self.upright_s, 2),
                number(self.upright_with_b1_of_fall_s, 2),
            ),
            why: format!(
                "The test moves one way only, where dry friction is a constant torque like the \
                 motor's. With {} N m of Coulomb friction the fit gives {} N m, which is the sum \
                 of the two, and still the right b1, {}. So the paper's τ, and with it (5), holds \
                 the dry friction of one direction.",
                number(coulomb_nm, 2),
                number(self.with[1], 4),
                number(self.with[0], 4),
            ),
            mend: "Push with several PWMs, both ways. The fitted torques over PWM are two lines: \
                   their slope is that of (5), and the jump between them is twice the dry \
                   friction."
                .into(),
            printed: vec![
                b1("b1 fitted to the constant input", self.without[0]),
                torque("Torque fitted to it", self.without[1], PUSH_NM),
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
        let mut part = Part::new(
            "Joint 1",
            "angle (rad)",
            vec![
                Curve::new("b1 of the free fall", WRONG, model(B1_FALL)),
                Curve::new(
                    "dry friction, more torque",
                    DIFFERENCE,
                    self.dry.points().collect(),
                ),
                Curve::new("b1 of this test", MODEL, model(B1_PUSH)),
            ],
        );
        part.y = Some([-1.75, 0.6]);
        part.levels = vec![Level {
            name: "table".to_owned(),
            y: -FRAC_PI_2,
        }];
        Figure {
            name: "fig6",
            of_paper: Some("Fig. 6"),
            caption: format!(
                "Joint 1 from {PUSH_FROM_RAD} rad under {} N m. The paper's measured curve is \
                 not available. An arm with {} N m of Coulomb friction and as much more torque \
                 moves like the model without: the test cannot tell them apart. What the real \
                 arm did at the beginning is not in this model of friction either.",
                number(PUSH_NM, 4),
                number(self.friction.coulomb_nm, 2),
            ),
            chart: Chart {
                title: "Constant input",
                x_title: "time (s)",
                x: [0.0, 2.0],
                panels: vec![part],
            },
        }
    }
}

/// The paper's model with this friction in N m s/rad, under its torque.
fn viscous(b1: f64) -> Numbers {
    Numbers {
        b1,
        torque_nm: PUSH_NM,
        ..Numbers::of(&Parameters::paper())
    }
}

/// The arm that made (7), with dry friction, and an encoder without noise.
fn arm(friction: Friction) -> VirtualArm {
    VirtualArm {
        friction,
        noise_rad: 0.0,
        ..VirtualArm::paper(Parameters::<f64>::paper().b1, 0.0, 0)
    }
}

/// b1 and torque with which the model without dry friction comes nearest to that arm's
/// motion under a torque.
fn fit_both(friction: Friction) -> [f64; 2] {
    let push = arm(friction).constant_input(PUSH_NM, DURATION_S);
    let begin = Numbers {
        b1: 0.3,
        torque_nm: -0.35,
        ..Numbers::of(&Parameters::paper())
    };
    let found = fit(&[push], VISCOUS_TORQUE, &begin);
    found.map_or([f64::NAN; 2], |fit| [fit.numbers.b1, fit.numbers.torque_nm])
}
