//! Fig. 6: a constant torque on joint 1, and b1 and that torque fitted to it.

use core::f64::consts::{FRAC_PI_2, PI};

use armbridge_shared::JOINTS;
use armbridge_shared::actuator::Joint;
use armbridge_shared::arm::{Parameters, State};
use armbridge_sim::plant::{Body, Friction, PlantConfig};
use nalgebra::Vector2;

use super::chart::{Chart, Curve, DIFFERENCE, Figure, Level, MODEL, Part, WRONG};
use super::claim::{Claim, Number, Rule};
use super::integrate;
use super::printed::{B1_FALL, B1_PUSH, PERIOD_S, PUSH_FROM_RAD, PUSH_NM};
use super::text::number;
use crate::identify::paper::{Kind, Numbers, Sampled, Start, VISCOUS_TORQUE, fit};

/// Samples until just before the table stops the arm, 1.3 s.
const SAMPLES: usize = 30;

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
    dry: Vec<f64>,
}

impl Push {
    /// Pushes the arm, with and without dry friction, and fits.
    pub fn find() -> Self {
        let friction = PlantConfig::default().friction[0];
        let upright_s = |b1| {
            let arm = Parameters {
                b1,
                ..Parameters::paper()
            };
            let angles = integrate::first_joint(&arm, PUSH_FROM_RAD, PUSH_NM, 0.001, 3000);
            angles.iter().take_while(|q| **q > 0.0).count() as f64 * 0.001
        };
        Self {
            without: fit_both(&counted(&pushed(PUSH_NM, Friction::NONE))),
            with: fit_both(&counted(&pushed(PUSH_NM, friction))),
            friction,
            upright_s: upright_s(B1_PUSH),
            upright_with_b1_of_fall_s: upright_s(B1_FALL),
            dry: pushed(PUSH_NM - friction.coulomb_nm, friction),
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
        let over_time = |angles: &[f64]| {
            let points = angles.iter().enumerate();
            points.map(|(k, q)| (k as f64 * PERIOD_S, *q)).collect()
        };
        let model = |b1| {
            let arm = Parameters {
                b1,
                ..Parameters::paper()
            };
            let angles = integrate::first_joint(&arm, PUSH_FROM_RAD, PUSH_NM, PERIOD_S, 60);
            over_time(&angles)
        };
        let mut part = Part::new(
            "Joint 1",
            "angle (rad)",
            vec![
                Curve::new("b1 of the free fall", WRONG, model(B1_FALL)),
                Curve::new(
                    "dry friction, more torque",
                    DIFFERENCE,
                    over_time(&self.dry),
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

/// Angles of the arm that made (7) under a torque, with dry friction.
fn pushed(torque_nm: f64, friction: Friction) -> Vec<f64> {
    let initial = State::at_rest(Vector2::new(PUSH_FROM_RAD, 0.0));
    let stops = [[-PI, PI]; JOINTS];
    let mut body = Body::new(Parameters::paper(), [friction; JOINTS], stops, initial);
    body.set_torque(0, Vector2::new(torque_nm, 0.0));
    let period_ns = (PERIOD_S * 1e9) as u64;
    let angles = (0..SAMPLES as u64).map(|k| {
        body.advance(k * period_ns);
        body.state(k * period_ns).q.x
    });
    angles.collect()
}

/// What the encoder makes of them.
fn counted(angles: &[f64]) -> Vec<f64> {
    let joint = Joint::<f64>::paper();
    let count = |q: &f64| joint.position(*q).round().clamp(0.0, 1023.0) as u16;
    angles.iter().map(|q| joint.angle(count(q))).collect()
}

/// b1 and torque with which the model without dry friction comes nearest.
fn fit_both(angles: &[f64]) -> [f64; 2] {
    let push = Sampled {
        kind: Kind::ConstantInput,
        period_s: PERIOD_S,
        angles_rad: angles.iter().copied().map(Some).collect(),
        start_rad: PUSH_FROM_RAD,
        start: Start::Known,
        told_nm: None,
    };
    let begin = Numbers {
        b1: 0.3,
        torque_nm: -0.35,
        ..Numbers::of(&Parameters::paper())
    };
    let found = fit(&[push], VISCOUS_TORQUE, &begin);
    found.map_or([f64::NAN; 2], |fit| [fit.numbers.b1, fit.numbers.torque_nm])
}
