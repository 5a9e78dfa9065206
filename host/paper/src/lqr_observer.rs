//! "The ensemble becomes unstable": LQR with the printed observer.

use armbridge_control::controller::Lqr;
use armbridge_control::estimate::{Estimator, Form};
use armbridge_log::summary::SETTLED_RAD;
use armbridge_servo::JOINTS;
use armbridge_sim::plant::{Friction, PlantConfig};

use super::chart::{CORRECTED, Chart, Curve, DIFFERENCE, Figure, PLACED, PRINTED, Subplot};
use super::claim::{Claim, Number, Rule};
use super::printed::{OBSERVER, PERIOD_S, PERIOD_US, PUSH_FROM_RAD};
use super::sampled_loop::{Delay, EstimatorInput, InitialEstimate, Run, SampledLoop, arm_at};
use super::text::number;
use super::{DesignError, observers, stability};

/// Torque gain of weak motors: ratio of the torque to that of (5), as with a sagging supply
/// or an error in 834.
pub const WEAK: f64 = 0.7;
const DURATION_S: f64 = 10.0;
/// Final part of a run that counts as rest, in s.
const LAST_S: f64 = 2.0;
/// Smallest angle at rest of an arm that is not stabilised.
const HANGS_RAD: f64 = 0.3;
/// Largest angle at rest of an arm that is stabilised.
const STANDS_RAD: f64 = 0.1;
/// Torque gains of the sweep: smallest, largest, and their number.
const SWEEP: (f64, f64, u32) = (0.5, 1.2, 29);

/// Results of the run.
#[derive(Clone, Debug)]
pub struct LqrObserver {
    /// Spectral radius of the loop with the printed observer, without delay and with a
    /// period of delay.
    pub spectral_radius: [f64; 2],
    /// Spectral radius with the printed poles, and with differences.
    pub other_spectral_radii: [f64; 2],
    /// Net restoring stiffness in N m/rad of each joint: full state, printed
    /// observer, printed poles.
    pub stiffness: [[f64; JOINTS]; 3],
    /// Torque gain below which gravity exceeds the loop's stiffness, joint 1: full
    /// state, printed observer, printed poles.
    pub minimum_torque_gain: [f64; 3],
    /// Largest angle at rest in rad at nominal torque, with dry friction: speeds by
    /// differences, printed observer, printed poles, printed poles in current
    /// form, the board's observer, the same with compensation, the Kalman filter
    /// with the disturbance torque subtracted.
    pub rest_rad: [f64; 7],
    /// Largest angle at rest in rad with weak motors, in the same order.
    pub weak_rest_rad: [f64; 7],
    friction: Friction,
    weak: [Run; 4],
    /// Angle at rest in rad over torque gain, for the estimators of `DRAWN`.
    sweep: [Vec<(f64, f64)>; 4],
}

/// Names of the candidates: estimators, with or without compensation.
const NAMES: [&str; 7] = [
    "speeds by differences",
    "printed observer",
    "printed poles",
    "printed poles, current form",
    "the board's observer",
    "the board's, dead zone compensated",
    "Kalman filter with disturbance torques",
];

/// Indices of the board's first candidate, of its observer with compensation, and of the
/// filter.
const BOARD: usize = 4;
const COMPENSATED: usize = 5;
const FILTER: usize = 6;

/// Indices of the candidates that the figures show.
const DRAWN: [usize; 4] = [0, 1, 2, FILTER];

impl LqrObserver {
    /// Computes poles and stiffness, and simulates the arm.
    ///
    /// # Errors
    ///
    /// See [`DesignError`].
    pub fn compute() -> Result<Self, DesignError> {
        let placed = observers::placed_gain()?;
        let gravity = stability::gravity_stiffness();
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
        let (nominal, weak) = (runs(1.0), runs(WEAK));
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
            spectral_radius: [false, true]
                .map(|delayed| stability::spectral_radius(&OBSERVER, delayed)),
            other_spectral_radii: [
                stability::spectral_radius(&placed, false),
                stability::spectral_radius_of_differences(),
            ],
            stiffness: gains.map(|gain| [0, 1].map(|j| gain[j] - gravity[j])),
            minimum_torque_gain: gains.map(|gain| gravity[0] / gain[0]),
            rest_rad: nominal.map(|run| run.rest_rad(LAST_S)),
            weak_rest_rad: weak.clone().map(|run| run.rest_rad(LAST_S)),
            friction,
            weak: DRAWN.map(|i| weak[i].clone()),
            sweep,
        })
    }

    /// Factor by which the printed observer reduces the stiffness of joint 1.
    pub fn softening(&self) -> f64 {
        self.stiffness[0][0] / self.stiffness[1][0]
    }

    /// The claim about the observer with LQR.
    pub fn claims(&self) -> Vec<Claim> {
        let [full, printed, _] = self.stiffness;
        let radius = |condition: &str, found| {
            let quantity = format!("Largest pole, LQR with printed observer{condition}");
            Number::new(quantity, "", found, Rule::AtLeast(1.0))
        };
        let rest = |i: usize, found: [f64; 7], torque: &str, rule| {
            let quantity = format!("Angle at rest, {}, {torque}", NAMES[i]);
            Number::new(quantity, "rad", found[i], rule)
        };
        let (nominal, weak) = (self.rest_rad, self.weak_rest_rad);
        let weak_torque = format!("{WEAK} of the torque");
        vec![Claim {
            id: "instability",
            title: "“The ensemble becomes unstable”",
            paper: "The observer cannot be applied together with the LQR: the observer is not \
                    fast enough, so the ensemble becomes unstable."
                .into(),
            finding: format!(
                "The printed numbers give a stable loop. With K of (10) and L of (12) on the exact \
                 model the largest pole is {}, with a full period of delay {}, and the simulated \
                 arm stays upright. But the printed observer removes {} % of the net restoring \
                 stiffness of joint 1: {} of {} N m/rad remain, {} times less. With {} of the \
                 torque and dry friction the arm hangs at {} rad; with speeds by differences it \
                 rests at {} rad.",
                number(self.spectral_radius[0], 3),
                number(self.spectral_radius[1], 3),
                number(100.0 * (1.0 - printed[0] / full[0]), 0),
                number(printed[0], 4),
                number(full[0], 4),
                number(self.softening(), 2),
                WEAK,
                number(weak[1], 2),
                number(weak[0], 3),
            ),
            explanation: format!(
                "The observer relies on (7) and on the requested torque. When dry friction holds \
                 the arm away from upright, a slow observer still predicts that the torque moves \
                 it upright, and the LQR requests less. Gravity prevails as soon as the motors \
                 give less than {} of the torque by (5); with full state feedback {} is enough. \
                 This looks as if the observer failed to hold the arm and plain LQR succeeded. \
                 That the authors observed this is an inference: the paper shows no curve of it.",
                number(self.minimum_torque_gain[1], 3),
                number(self.minimum_torque_gain[0], 3),
            ),
            remedy: format!(
                "Use a faster observer, and compensate friction. At nominal torque with dry \
                 friction the arm rests at {} mrad with the printed observer, {} mrad with the \
                 printed poles, {} mrad with the same in current form, {} mrad with the board's \
                 observer (exact discretisation, exact gravity), {} mrad with dead-zone \
                 compensation added, and {} mrad with a Kalman filter whose estimate of the \
                 disturbance torque is subtracted, against {} mrad with speeds by differences. \
                 With {} of the torque, the arm rests at {} mrad with the filter.",
                number(nominal[1] * 1e3, 0),
                number(nominal[2] * 1e3, 0),
                number(nominal[3] * 1e3, 0),
                number(nominal[4] * 1e3, 0),
                number(nominal[COMPENSATED] * 1e3, 1),
                number(nominal[FILTER] * 1e3, 1),
                number(nominal[0] * 1e3, 0),
                WEAK,
                number(weak[FILTER] * 1e3, 1),
            ),
            printed: vec![
                radius("", self.spectral_radius[0]),
                radius(", 45 ms delay", self.spectral_radius[1]),
            ],
            reading: vec![
                Number::new(
                    "Fraction of the restoring stiffness lost, joint 1",
                    "",
                    1.0 - printed[0] / full[0],
                    Rule::Within(2.0 / 3.0, 0.03),
                ),
                Number::new(
                    "Fraction of the restoring stiffness lost, joint 2",
                    "",
                    1.0 - printed[1] / full[1],
                    Rule::Within(2.0 / 3.0, 0.03),
                ),
                rest(1, nominal, "nominal torque", Rule::AtMost(HANGS_RAD)),
                rest(1, weak, &weak_torque, Rule::AtLeast(HANGS_RAD)),
                rest(0, weak, &weak_torque, Rule::AtMost(STANDS_RAD)),
                rest(
                    COMPENSATED,
                    nominal,
                    "nominal torque",
                    Rule::AtMost(SETTLED_RAD),
                ),
                rest(FILTER, nominal, "nominal torque", Rule::AtMost(SETTLED_RAD)),
                rest(FILTER, weak, &weak_torque, Rule::AtMost(SETTLED_RAD)),
            ],
            figures: vec![self.over_time(), self.over_gain()],
        }]
    }

    fn over_time(&self) -> Figure {
        let looks = [DIFFERENCE, PRINTED, PLACED, CORRECTED];
        let curves = (0..4).map(|i| Curve::new(NAMES[DRAWN[i]], looks[i], self.weak[i].angle(0)));
        Figure {
            name: "hanging",
            paper_figure: None,
            caption: format!(
                "Joint 1 from {PUSH_FROM_RAD} rad under K of (10) at 45 ms, with motors that give \
                 {WEAK} of their torque and dry friction of {} N m in motion and {} N m at rest. \
                 The paper states that the printed observer is unstable, and shows no figure.",
                self.friction.coulomb_nm, self.friction.static_nm,
            ),
            chart: Chart {
                title: "LQR with four estimators, weak motors",
                x_title: "time (s)",
                x: [0.0, 6.0],
                panels: vec![Subplot::new("Joint 1", "angle (rad)", curves.collect())],
            },
        }
    }

    fn over_gain(&self) -> Figure {
        let looks = [DIFFERENCE, PRINTED, PLACED, CORRECTED];
        let curves = (0..4).map(|i| Curve::in_mrad(NAMES[DRAWN[i]], looks[i], &self.sweep[i]));
        let subplot = Subplot::new("Worse joint", "angle at rest (mrad)", curves.collect());
        Figure {
            name: "weak-motors",
            paper_figure: None,
            caption: format!(
                "Angle at rest after {} s, over the torque of the motors. As torque decreases, the \
                 arm sags first with the printed observer. On the plateau near the start angle, \
                 static friction holds the arm where it was released; above it, gravity prevails.",
                DURATION_S - LAST_S,
            ),
            chart: Chart {
                title: "How much torque the loop can lose",
                x_title: "ratio of torque to that of (5)",
                x: [SWEEP.0, SWEEP.1],
                panels: vec![subplot],
            },
        }
    }
}

/// Simulates candidate `i`. The paper's observers start upright, and their input is the
/// requested torque, as in (11); the board's input is the torque sent.
fn run(i: usize, estimator: &Estimator<f64>, friction: Friction, gain: f64) -> Run {
    let is_board = i >= BOARD;
    let is_observer = matches!(estimator, Estimator::Luenberger(_));
    let control = SampledLoop {
        period_us: PERIOD_US,
        duration_s: DURATION_S,
        plant: PlantConfig {
            torque_gain: gain,
            ..arm_at([PUSH_FROM_RAD, 0.0], friction)
        },
        delay: Delay::None,
        input: if is_board {
            EstimatorInput::Sent
        } else {
            EstimatorInput::Requested
        },
        start: if is_observer && !is_board {
            InitialEstimate::Upright
        } else {
            InitialEstimate::FirstSample
        },
        compensate: i == COMPENSATED || i == FILTER,
    };
    control.regulate(estimator)
}
