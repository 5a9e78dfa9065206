//! Fig. 5: joint 1 falls from near upright, and b1 is fitted to the fall.

use core::f64::consts::{FRAC_PI_2, PI};

use armbridge_shared::arm::Parameters;

use super::chart::{Chart, Curve, DIFFERENCE, Figure, Level, MENDED, MODEL, Part};
use super::claim::{Claim, Number, Rule};
use super::identification::{Numbers, Sampled, VISCOUS, VirtualArm, fit};
use super::printed::{B1_FALL, B1_PUSH, PERIOD_S};
use super::pwm::PwmLaw;
use super::text::number;

/// Where falls without dry friction start, in rad.
const NEAR_UPRIGHT_RAD: f64 = 0.1;

/// What the run finds.
#[derive(Clone, Debug)]
pub struct Fall {
    /// b1 fitted to a fall of the arm that made (7), in N m s/rad.
    pub b1_without: f64,
    /// Coulomb friction in N m with which the same fit gives the paper's b1.
    pub coulomb_nm: f64,
    /// That fit, in N m s/rad.
    pub b1_with: f64,
    /// By how much that arm comes to rest short of hanging down, in degrees.
    pub short_deg: f64,
    /// Change of the time to a quarter turn, with half and one and a half times
    /// the inertia, in per cent.
    pub inertia_effect: [f64; 2],
    /// The same with the friction.
    pub friction_effect: [f64; 2],
    /// Angle over time of the arm with dry friction.
    dropped: Sampled,
}

impl Fall {
    /// Lets the arm fall, with and without dry friction, and fits.
    pub fn find() -> Self {
        let arm = Parameters::<f64>::paper();
        let smooth = VirtualArm::paper(arm.b1, 0.0, 0).seen_exactly();
        let smooth = smooth.free_fall(NEAR_UPRIGHT_RAD, 4.0);

        // More dry friction looks like more viscous friction: bisect.
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

        let usual_s = quarter_turn_s(&arm);
        let change = |arm: Parameters<f64>| 100.0 * (quarter_turn_s(&arm) / usual_s - 1.0);
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
            dropped: fall,
        }
    }

    /// The claims about the free fall.
    pub fn claims(&self) -> Vec<Claim> {
        vec![self.friction(), self.inertia()]
    }

    fn friction(&self) -> Claim {
        let b1 = |what, found| Number::new(what, "N m s/rad", found, Rule::Within(B1_FALL, 0.002));
        let dead_zone_nm = PwmLaw::find().dead_zone_half_nm();
        Claim {
            id: "fall",
            title: "Fig. 5: free fall",
            paper: format!(
                "Fitting a free fall gives b1 = {B1_FALL}. The form is not exactly that of the \
                 data, and the arm does not reach 180°, because of static friction."
            ),
            find: format!(
                "The arm that made (7) falls with b1 = {}, and the fit finds it: {}. With {} N m \
                 of Coulomb friction on a b1 of {B1_PUSH}, the fit of viscous friction alone \
                 gives {}, and the arm comes to rest {}° short of 180°.",
                Parameters::<f64>::paper().b1,
                number(self.b1_without, 3),
                number(self.coulomb_nm, 3),
                number(self.b1_with, 3),
                number(self.short_deg, 1),
            ),
            why: format!(
                "A fit that knows only viscous friction takes dry friction for more of it. The \
                 paper's {B1_FALL} and {B1_PUSH} are then one arm seen by two tests. The dry \
                 friction that this takes is {} times the dead zone's half width of {} N m: \
                 turning a gear from the wrong end costs more.",
                number(self.coulomb_nm / dead_zone_nm, 1),
                number(dead_zone_nm, 2),
            ),
            mend: "Fit Coulomb friction together with b1. Its measured curve is not available, \
                   so the one drawn here is that of the simulated arm with dry friction."
                .into(),
            printed: vec![b1(
                "b1 fitted to a fall of the arm that made (7)",
                self.b1_without,
            )],
            reading: vec![
                b1("b1 fitted to a fall with dry friction", self.b1_with),
                Number::new(
                    "Rest short of 180° with dry friction",
                    "°",
                    self.short_deg,
                    Rule::AtLeast(1.0),
                ),
                Number::new(
                    "Coulomb friction over the dead zone's half width",
                    "",
                    self.coulomb_nm / dead_zone_nm,
                    Rule::AtMost(2.0),
                ),
            ],
            figures: vec![self.figure()],
        }
    }

    fn inertia(&self) -> Claim {
        let largest = |effect: [f64; 2]| effect[0].abs().max(effect[1].abs());
        let share = largest(self.inertia_effect) / largest(self.friction_effect);
        Claim {
            id: "inertia",
            title: "The inertias matter little",
            paper: "The inertia parameters have a relatively small effect on the overall system."
                .into(),
            find: format!(
                "Half and one and a half times the moments of inertia change the time of the fall to 90° by {} \
                 and {} %; half and one and a half times b1 change it by {} and {} %.",
                number(self.inertia_effect[0], 1),
                number(self.inertia_effect[1], 1),
                number(self.friction_effect[0], 1),
                number(self.friction_effect[1], 1),
            ),
            why: "The fall is slow, and friction, not mass, takes up gravity's torque.".into(),
            mend: "Nothing to mend. It also means that a fall cannot tell the inertia.".into(),
            printed: vec![Number::new(
                "Effect of inertia over effect of friction on the fall",
                "",
                share,
                Rule::AtMost(0.5),
            )],
            reading: Vec::new(),
            figures: Vec::new(),
        }
    }

    fn figure(&self) -> Figure {
        let arm = Parameters::<f64>::paper();
        let degrees = self.dropped.points().map(|(t, q)| (t, q.to_degrees()));
        let from_rad = self.dropped.start_rad;
        let with = |b1| {
            let numbers = Numbers {
                b1,
                ..Numbers::of(&arm)
            };
            let motion = numbers.motion(from_rad, PERIOD_S, self.dropped.angles_rad.len());
            motion.map(|(t, q)| (t, q.to_degrees())).collect()
        };
        let mut part = Part::new(
            "Joint 1",
            "angle (°)",
            vec![
                Curve::new("dry friction", DIFFERENCE, degrees.collect()),
                Curve::new("fit, viscous only", MODEL, with(self.b1_with)),
                Curve::new("the true b1 alone", MENDED, with(B1_PUSH)),
            ],
        );
        part.y = Some([0.0, 195.0]);
        part.levels = vec![Level {
            name: "hanging down".to_owned(),
            y: 180.0,
        }];
        Figure {
            name: "fig5",
            of_paper: Some("Fig. 5"),
            caption: format!(
                "Free fall of joint 1 from {} rad. The paper's measured curve is not available; \
                 in its place falls the simulated arm with {} N m Coulomb friction and \
                 b1 = {B1_PUSH}, which stops short of 180° as the paper's does. Fitted by \
                 viscous friction alone, b1 = {}.",
                number(from_rad, 3),
                number(self.coulomb_nm, 3),
                number(self.b1_with, 3),
            ),
            chart: Chart {
                title: "Free fall",
                x_title: "time (s)",
                x: [0.0, 4.0],
                panels: vec![part],
            },
        }
    }
}

/// The arm that the constant input found, with dry friction, and falling.
fn fall_with(coulomb_nm: f64) -> Sampled {
    VirtualArm::paper(B1_PUSH, coulomb_nm, 0)
        .seen_exactly()
        .paper_fall()
}

/// The b1 with which the model without dry friction comes nearest to a fall.
fn fit_b1(fall: &Sampled) -> f64 {
    let begin = Numbers::of(&Parameters::paper());
    let found = fit(std::slice::from_ref(fall), VISCOUS, &begin);
    found.map_or(f64::NAN, |fit| fit.numbers.b1)
}

/// Time in s of a fall from near upright to a quarter turn.
fn quarter_turn_s(arm: &Parameters<f64>) -> f64 {
    let motion = Numbers::of(arm).motion(NEAR_UPRIGHT_RAD, 0.005, 2000);
    let mut beyond = motion.filter(|(_, q)| *q >= FRAC_PI_2);
    beyond.next().map_or(f64::NAN, |(time_s, _)| time_s)
}
