//! Figs. 7 and 8: the arm is let go off upright and stabilised by LQR.

use armbridge_log::summary::SETTLED_RAD;
use armbridge_shared::JOINTS;
use armbridge_shared::actuator::{Joint, Pwm};
use armbridge_shared::arm::{Discrete, State};
use armbridge_shared::control::Lqr;
use armbridge_shared::estimate::Estimator;
use armbridge_sim::plant::{Friction, PlantConfig};
use nalgebra::{Vector2, Vector4};

use super::chart::{Chart, Curve, DIFFERENCE, Figure, MODEL, PLACED, Part};
use super::claim::{Claim, Number, Rule};
use super::printed::{PERIOD_S, PERIOD_US};
use super::sim::{Delay, EstimatorInput, Loop, Run, Start, arm_at, upright};
use super::stability::gravity;
use super::text::number;
use super::{BOARD_US, FindError, JOINT_NAMES, observers};

/// Where the arm is let go, in rad. "Different from 0" in the paper.
pub(crate) const FROM_RAD: [f64; JOINTS] = [0.49, 0.40];
const DURATION_S: f64 = 6.0;
/// Curves this close are "very close to each other": a tenth of the motion.
const CLOSE_RAD: f64 = 0.1 * FROM_RAD[0];

/// What the run finds.
#[derive(Clone, Debug)]
pub struct Standing {
    /// Root mean square over the run of model less arm, for each joint, in rad.
    pub apart_rad: [f64; JOINTS],
    /// Largest angle at rest with dry friction, in rad.
    pub rest_rad: f64,
    /// The same at the board's 1 ms, with its observer.
    pub fast_rest_rad: f64,
    /// What dry friction can hold against the loop's stiffness, in rad.
    pub explained_rad: f64,
    /// When the arm without dry friction stays within 20 mrad, in s.
    pub settled_s: f64,
    /// Largest torque asked for, and the smaller limit of (5), in N m.
    pub torque_nm: [f64; 2],
    model: Vec<(f64, Vector2<f64>)>,
    free: Run,
    dry: Run,
}

impl Standing {
    /// Runs the model and the arm, with and without dry friction.
    ///
    /// # Errors
    ///
    /// See [`FindError`].
    pub fn find() -> Result<Self, FindError> {
        let friction = PlantConfig::default().friction[0];
        let run = |estimator, friction, period_us| run(&estimator, friction, period_us);
        let (free, dry) = (
            run(observers::difference(), Friction::NONE, PERIOD_US),
            run(observers::difference(), friction, PERIOD_US),
        );
        let observer = observers::standing(f64::from(BOARD_US) * 1e-6)?;
        let fast = run(observer, friction, BOARD_US);
        let model = linear_model();
        let apart = |joint: usize| {
            let at = |time_s: f64| {
                let k = (time_s / PERIOD_S).round() as usize;
                model.get(k).map_or(f64::NAN, |(_, q)| q[joint])
            };
            dry.rms(joint, 0.0, at)
        };
        let k = Lqr::<f64>::paper().gain;
        let offset = |j: usize| friction.static_nm / (k[(j, j)] - gravity()[j]);
        let outside = free.samples.iter().rfind(|s| s.q.amax() > SETTLED_RAD);
        let limit = [Pwm::MIN, Pwm::MAX].map(|pwm| Joint::<f64>::paper().torque(pwm).abs());
        Ok(Self {
            apart_rad: [apart(0), apart(1)],
            rest_rad: dry.rest_rad(1.0),
            fast_rest_rad: fast.rest_rad(1.0),
            explained_rad: offset(0).max(offset(1)),
            settled_s: outside.map_or(0.0, |sample| sample.time_s + PERIOD_S),
            torque_nm: [dry.peak_nm(), limit[0].min(limit[1])],
            model,
            free,
            dry,
        })
    }

    /// The claim about LQR on the arm.
    pub fn claims(&self) -> Vec<Claim> {
        let apart = |joint: usize| {
            Number::new(
                format!("Model and arm apart (RMS), {}", JOINT_NAMES[joint]),
                "rad",
                self.apart_rad[joint],
                Rule::AtMost(CLOSE_RAD),
            )
        };
        let [asked, limit] = self.torque_nm;
        vec![Claim {
            id: "standing",
            title: "Figs. 7 and 8: LQR on the arm",
            paper: "Started off upright, model and arm follow trajectories that are very close \
                    to each other."
                .into(),
            find: format!(
                "From {} and {} rad, with speeds by differences, encoder counts, integer PWM and \
                 dry friction, arm and model are {} and {} mrad apart (RMS over {} s). Without \
                 dry friction the arm stays within {} mrad after {} s; with it, it comes to rest \
                 up to {} mrad off.",
                FROM_RAD[0],
                FROM_RAD[1],
                number(self.apart_rad[0] * 1e3, 1),
                number(self.apart_rad[1] * 1e3, 1),
                DURATION_S,
                SETTLED_RAD * 1e3,
                number(self.settled_s, 2),
                number(self.rest_rad * 1e3, 1),
            ),
            why: format!(
                "What sets them apart is what the paper suspects, the unmodelled static friction: \
                 it can hold the arm up to {} mrad off against the loop's stiffness. Speeds by \
                 differences do no harm at 45 ms. Nothing saturates: {} of {} N m are asked for.",
                number(self.explained_rad * 1e3, 1),
                number(asked, 2),
                number(limit, 2),
            ),
            mend: format!(
                "Compensation of the dead zone, or an estimate of the friction torque. Faster \
                 sampling alone does not help, for the offset is static: at {} ms, with the \
                 board's observer, the arm rests {} mrad off.",
                f64::from(BOARD_US) * 1e-3,
                number(self.fast_rest_rad * 1e3, 1),
            ),
            printed: vec![
                apart(0),
                apart(1),
                Number::new(
                    "Rest with dry friction over what friction explains",
                    "",
                    self.rest_rad / self.explained_rad,
                    Rule::AtMost(1.0),
                ),
                Number::new(
                    "Torque asked for over the servo's limit",
                    "",
                    asked / limit,
                    Rule::AtMost(1.0),
                ),
            ],
            reading: Vec::new(),
            figures: vec![self.figure(0), self.figure(1)],
        }]
    }

    fn figure(&self, joint: usize) -> Figure {
        let model = self.model.iter().map(|(t, q)| (*t, q[joint])).collect();
        let (name, of_paper, title) = [
            ("fig7", "Fig. 7", "Model and arm with LQR, first joint"),
            ("fig8", "Fig. 8", "Model and arm with LQR, second joint"),
        ][joint];
        let curves = vec![
            Curve::new("arm, dry friction", DIFFERENCE, self.dry.angle(joint)),
            Curve::new("arm without", PLACED, self.free.angle(joint)),
            Curve::new("model (7)", MODEL, model),
        ];
        Figure {
            name,
            of_paper: Some(of_paper),
            caption: format!(
                "{} from {} rad under K of (10) at {} ms. The paper's measured curve is not \
                 available, and neither is its start; in its place moves the simulated arm, with \
                 speeds by differences, encoder counts and integer PWM. Model (7) stands still \
                 for a period because Euler's B has no torque on the angles.",
                JOINT_NAMES[joint],
                FROM_RAD[joint],
                PERIOD_S * 1e3,
            ),
            chart: Chart {
                title,
                x_title: "time (s)",
                x: [0.0, 4.0],
                panels: vec![Part::new("", "angle (rad)", curves)],
            },
        }
    }
}

/// LQR on the arm.
fn run(estimator: &Estimator<f64>, friction: Friction, period_us: u32) -> Run {
    let control = Loop {
        period_us,
        duration_s: DURATION_S,
        plant: arm_at(FROM_RAD, friction),
        delay: Delay::None,
        input: EstimatorInput::Requested,
        start: Start::Sampled,
        compensate: false,
    };
    control.regulate(estimator)
}

/// (6), (7) and (9) alone.
fn linear_model() -> Vec<(f64, Vector2<f64>)> {
    let (model, lqr, upright) = (Discrete::paper(), Lqr::paper(), upright());
    let [q1, q2] = FROM_RAD;
    let mut x = Vector4::new(q1, q2, 0.0, 0.0);
    let samples = (DURATION_S / PERIOD_S).ceil() as u32;
    (0..=samples)
        .map(|k| {
            let state = State::from_vector(x);
            x = model.step(x, lqr.torque(&state, &upright));
            (f64::from(k) * PERIOD_S, state.q)
        })
        .collect()
}
