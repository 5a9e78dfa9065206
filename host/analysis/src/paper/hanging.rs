//! "The ensemble becomes unstable": LQR on the printed observer.

use armbridge_log::summary::SETTLED_RAD;
use armbridge_shared::JOINTS;
use armbridge_shared::control::Lqr;
use armbridge_shared::estimate::{Estimator, Form};
use armbridge_sim::plant::{Friction, PlantConfig};

use super::chart::{Chart, Curve, DIFFERENCE, Figure, MENDED, PLACED, PRINTED, Part};
use super::claim::{Claim, Number, Rule};
use super::printed::{OBSERVER, PERIOD_S, PERIOD_US, PUSH_FROM_RAD};
use super::sim::{Delay, EstimatorInput, Loop, Run, Start, arm_at};
use super::text::number;
use super::{FindError, observers, stability};

/// Torque of the arm over what (5) promises: a supply that sags, or a wrong 834.
pub const WEAK: f64 = 0.7;
const DURATION_S: f64 = 10.0;
/// At the end of a run, what counts as rest.
const LAST_S: f64 = 2.0;
/// An arm that hangs this far off is not stabilised, whatever its poles.
const HANGS_RAD: f64 = 0.3;
/// An arm that is this near upright is.
const STANDS_RAD: f64 = 0.1;
/// Torque gains of the sweep: from the weakest.
const SWEEP: (f64, f64, u32) = (0.5, 1.2, 29);

/// What the run finds.
#[derive(Clone, Debug)]
pub struct Hanging {
    /// Largest pole of the loop with the printed observer, and the same with a
    /// period of delay.
    pub radius: [f64; 2],
    /// Largest pole with the printed poles, and with differences.
    pub radius_of_others: [f64; 2],
    /// Net restoring stiffness in N m/rad of each joint: full state, printed
    /// observer, printed poles.
    pub stiffness: [[f64; JOINTS]; 3],
    /// Share of its torque that the arm may lose before it sags, joint 1: full
    /// state, printed observer, printed poles.
    pub least_gain: [f64; 3],
    /// Largest angle at rest in rad at nominal torque, with dry friction: by
    /// differences, printed observer, printed poles, printed poles in current
    /// form, the board's observer, the same with compensation, the Kalman filter
    /// that takes off the disturbance torque.
    pub rest_rad: [f64; 7],
    /// The same with weak motors.
    pub weak_rest_rad: [f64; 7],
    friction: Friction,
    weak: [Run; 4],
    /// Rest in rad over torque gain: differences, printed, placed, mended.
    sweep: [Vec<(f64, f64)>; 4],
}

const NAMES: [&str; 7] = [
    "speeds by differences",
    "printed observer",
    "printed poles",
    "printed poles, current form",
    "the board's observer",
    "the board's, dead zone compensated",
    "Kalman filter with disturbance torques",
];

/// The first that is the board's, the one that compensates, and the filter.
const BOARD: usize = 4;
const COMPENSATED: usize = 5;
const FILTER: usize = 6;

/// Which of the six are drawn.
const DRAWN: [usize; 4] = [0, 1, 2, FILTER];

impl Hanging {
    /// Poles, stiffness, and the arm itself.
    ///
    /// # Errors
    ///
    /// See [`FindError`].
    pub fn find() -> Result<Self, FindError> {
        let placed = observers::placed_gain()?;
        let gravity = stability::gravity();
        let k = Lqr::<f64>::paper().gain;
        let gains = [
            Some([k.m11, k.m22]),
            stability::static_gain(&OBSERVER),
            stability::static_gain(&placed),
        ]
        .map(|gain| gain.unwrap_or([f64::NAN; JOINTS]));

        let friction = PlantConfig::default().friction[0];
        let candidates = [
            observers::difference(),
            observers::printed()?,
            observers::placed(false, Form::Prediction)?,
            observers::placed(false, Form::Current)?,
            observers::standing(PERIOD_S)?,
            observers::standing(PERIOD_S)?,
            observers::kalman(PERIOD_S)?,
        ];
        let runs = |gain| [0, 1, 2, 3, 4, 5, 6].map(|i| run(i, &candidates[i], friction, gain));
        let (usual, weak) = (runs(1.0), runs(WEAK));
        let sweep = DRAWN.map(|i| {
            let (from, to, steps) = SWEEP;
            let gains =
                (0..steps).map(|s| from + (to - from) * f64::from(s) / f64::from(steps - 1));
            gains
                .map(|gain| {
                    let run = run(i, &candidates[i], friction, gain);
                    (gain, run.rest_rad(LAST_S))
                })
                .collect()
        });
        Ok(Self {
            radius: [false, true].map(|delayed| stability::radius(&OBSERVER, delayed)),
            radius_of_others: [
                stability::radius(&placed, false),
                stability::radius_of_differences(),
            ],
            stiffness: gains.map(|gain| [0, 1].map(|j| gain[j] - gravity[j])),
            least_gain: gains.map(|gain| gravity[0] / gain[0]),
            rest_rad: usual.map(|run| run.rest_rad(LAST_S)),
            weak_rest_rad: weak.clone().map(|run| run.rest_rad(LAST_S)),
            friction,
            weak: DRAWN.map(|i| weak[i].clone()),
            sweep,
        })
    }

    /// By how many times the printed observer softens joint 1.
    pub fn softening(&self) -> f64 {
        self.stiffness[0][0] / self.stiffness[1][0]
    }

    /// The claim about the observer with LQR.
    pub fn claims(&self) -> Vec<Claim> {
        let [full, printed, _] = self.stiffness;
        let radius = |what: &str, found| {
            let what = format!("Largest pole, LQR with printed observer{what}");
            Number::new(what, "", found, Rule::AtLeast(1.0))
        };
        let rest = |i: usize, found: [f64; 7], how: &str, rule| {
            Number::new(format!("Rest, {}, {how}", NAMES[i]), "rad", found[i], rule)
        };
        let (usual, weak) = (self.rest_rad, self.weak_rest_rad);
        let weakly = format!("{WEAK} of the torque");
        vec![Claim {
            id: "instability",
            title: "“The ensemble becomes unstable”",
            paper: "The observer cannot be applied together with the LQR: the observer is not \
                    fast enough, so the ensemble becomes unstable."
                .into(),
            find: format!(
                "Not from the printed numbers. With K of (10) and L of (12) on the exact model \
                 the largest pole is {}, with a whole period of delay {}, and the simulated arm \
                 stays up. But the printed observer takes {} % of the net restoring stiffness of \
                 joint 1: {} N m/rad are left of {}, {} times softer. With {} of the torque and \
                 dry friction the arm hangs at {} rad; with speeds by differences it rests at \
                 {} rad.",
                number(self.radius[0], 3),
                number(self.radius[1], 3),
                number(100.0 * (1.0 - printed[0] / full[0]), 0),
                number(printed[0], 4),
                number(full[0], 4),
                number(self.softening(), 2),
                WEAK,
                number(weak[1], 2),
                number(weak[0], 3),
            ),
            why: format!(
                "The observer believes in (7) and in the torque it was told. When dry friction \
                 holds the arm aside, a slow observer goes on believing that the torque moves it \
                 upright, and asks for less. Gravity wins as soon as the motors give less than \
                 {} of what (5) promises; with full state feedback they may give as little as \
                 {}. To the eye that is “the observer does not hold the arm, plain LQR does”. \
                 That this is what was seen is an inference: the paper shows no curve of it.",
                number(self.least_gain[1], 3),
                number(self.least_gain[0], 3),
            ),
            mend: format!(
                "At nominal torque with dry friction the arm rests at {} mrad with the printed \
                 observer, {} with the printed poles, {} with the same in current form, {} with \
                 the board's observer (exact discretisation, exact gravity), {} mrad when the \
                 board compensates the dead zone as well, and {} with a Kalman filter that \
                 estimates the torque nobody commanded and takes it off, against {} mrad by \
                 differences. With {} of the torque the filter rests at {} mrad.",
                number(usual[1] * 1e3, 0),
                number(usual[2] * 1e3, 0),
                number(usual[3] * 1e3, 0),
                number(usual[4] * 1e3, 0),
                number(usual[COMPENSATED] * 1e3, 1),
                number(usual[FILTER] * 1e3, 1),
                number(usual[0] * 1e3, 0),
                WEAK,
                number(weak[FILTER] * 1e3, 1),
            ),
            printed: vec![
                radius("", self.radius[0]),
                radius(", 45 ms delay", self.radius[1]),
            ],
            reading: vec![
                Number::new(
                    "Share of the restoring stiffness that is lost, joint 1",
                    "",
                    1.0 - printed[0] / full[0],
                    Rule::Within(2.0 / 3.0, 0.03),
                ),
                Number::new(
                    "Share of it that is lost, joint 2",
                    "",
                    1.0 - printed[1] / full[1],
                    Rule::Within(2.0 / 3.0, 0.03),
                ),
                rest(1, usual, "nominal torque", Rule::AtMost(HANGS_RAD)),
                rest(1, weak, &weakly, Rule::AtLeast(HANGS_RAD)),
                rest(0, weak, &weakly, Rule::AtMost(STANDS_RAD)),
                rest(
                    COMPENSATED,
                    usual,
                    "nominal torque",
                    Rule::AtMost(SETTLED_RAD),
                ),
                rest(FILTER, usual, "nominal torque", Rule::AtMost(SETTLED_RAD)),
                rest(FILTER, weak, &weakly, Rule::AtMost(SETTLED_RAD)),
            ],
            figures: vec![self.over_time(), self.over_gain()],
        }]
    }

    fn over_time(&self) -> Figure {
        let looks = [DIFFERENCE, PRINTED, PLACED, MENDED];
        let curves = (0..4).map(|i| Curve::new(NAMES[DRAWN[i]], looks[i], self.weak[i].angle(0)));
        Figure {
            name: "hanging",
            of_paper: None,
            caption: format!(
                "Joint 1 from {PUSH_FROM_RAD} rad under K of (10) at 45 ms, motors giving {WEAK} \
                 of their torque, dry friction {} N m moving and {} N m at rest. The paper says \
                 of the printed observer that it is unstable, and shows no figure.",
                self.friction.coulomb_nm, self.friction.static_nm,
            ),
            chart: Chart {
                title: "LQR with four estimators, weak motors",
                x_title: "time (s)",
                x: [0.0, 6.0],
                panels: vec![Part::new("Joint 1", "angle (rad)", curves.collect())],
            },
        }
    }

    fn over_gain(&self) -> Figure {
        let looks = [DIFFERENCE, PRINTED, PLACED, MENDED];
        let curves = (0..4).map(|i| Curve::in_mrad(NAMES[DRAWN[i]], looks[i], &self.sweep[i]));
        let part = Part::new("Worse joint", "angle at rest (mrad)", curves.collect());
        Figure {
            name: "weak-motors",
            of_paper: None,
            caption: format!(
                "Where the arm rests after {} s, over the torque of its motors. The printed \
                 observer is the first to let it sag. Above its plateau near the start gravity \
                 wins; on it, static friction holds the arm where it was let go.",
                DURATION_S - LAST_S,
            ),
            chart: Chart {
                title: "How much torque the loop can lose",
                x_title: "torque over what (5) promises",
                x: [SWEEP.0, SWEEP.1],
                panels: vec![part],
            },
        }
    }
}

/// A run of the `i`th candidate. The paper's observers start upright and are
/// given what was asked for, as (11) has it; the board's what was sent.
fn run(i: usize, estimator: &Estimator<f64>, friction: Friction, gain: f64) -> Run {
    let of_board = i >= BOARD;
    let observes = matches!(estimator, Estimator::Luenberger(_));
    let control = Loop {
        period_us: PERIOD_US,
        duration_s: DURATION_S,
        plant: PlantConfig {
            torque_gain: gain,
            ..arm_at([PUSH_FROM_RAD, 0.0], friction)
        },
        delay: Delay::None,
        input: if of_board {
            EstimatorInput::Sent
        } else {
            EstimatorInput::Requested
        },
        start: if observes && !of_board {
            Start::Upright
        } else {
            Start::Sampled
        },
        compensate: i == COMPENSATED || i == FILTER,
    };
    control.regulate(estimator)
}
