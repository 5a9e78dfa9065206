//! Figs. 7 and 8: LQR stabilises the arm, released away from upright.

use armbridge_control::actuator::Joint;
use armbridge_control::arm::{Discrete, State};
use armbridge_control::controller::Lqr;
use armbridge_control::estimate::Estimator;
use armbridge_log::summary::SETTLED_RAD;
use armbridge_servo::{JOINTS, Pwm};
use armbridge_sim::plant::{Friction, PlantConfig};
use nalgebra::{Vector2, Vector4};

use super::chart::{Chart, Curve, DIFFERENCE, Figure, MODEL, PLACED, Subplot};
use super::claim::{Claim, Number, Rule};
use super::printed::{PERIOD_S, PERIOD_US};
use super::sampled_loop::{
    Delay, EstimatorInput, InitialEstimate, Run, SampledLoop, arm_at, upright,
};
use super::stability::gravity_stiffness;
use super::text::number;
use super::{BOARD_US, DesignError, JOINT_NAMES, observers};

/// Start angles in rad; the paper says only "different from 0".
pub(crate) const FROM_RAD: [f64; JOINTS] = [0.49, 0.40];
const DURATION_S: f64 = 6.0;
/// Largest RMS difference of curves that are "very close to each other": a tenth of the
/// motion.
const CLOSE_RAD: f64 = 0.1 * FROM_RAD[0];

/// Results of the run.
#[derive(Clone, Debug)]
pub struct Regulation {
    /// RMS difference between model and arm over the run, for each joint, in rad.
    pub difference_rad: [f64; JOINTS],
    /// Largest angle at rest with dry friction, in rad.
    pub rest_rad: f64,
    /// Largest angle at rest at the board's period of 1 ms with its observer, in rad.
    pub fast_rest_rad: f64,
    /// Largest angle that static friction can hold against the loop's stiffness, in rad.
    pub explained_rad: f64,
    /// Time in s after which the arm without dry friction stays within 20 mrad.
    pub settled_s: f64,
    /// Largest torque requested, and the smaller limit of (5), in N m.
    pub torque_nm: [f64; 2],
    model: Vec<(f64, Vector2<f64>)>,
    free: Run,
    dry: Run,
}

impl Regulation {
    /// Simulates the model, and the arm with and without dry friction.
    ///
    /// # Errors
    ///
    /// See [`DesignError`].
    pub fn compute() -> Result<Self, DesignError> {
        let friction = PlantConfig::default().friction[0];
        let run = |estimator, friction, period_us| run(&estimator, friction, period_us);
        let (free, dry) = (
            run(observers::difference(), Friction::NONE, PERIOD_US),
            run(observers::difference(), friction, PERIOD_US),
        );
        let observer = observers::standing(f64::from(BOARD_US) * 1e-6)?;
        let fast = run(observer, friction, BOARD_US);
        let model = linear_model();
        let difference = |joint: usize| {
            let model_angle = |time_s: f64| {
                let k = (time_s / PERIOD_S).round() as usize;
                model.get(k).map_or(f64::NAN, |(_, q)| q[joint])
            };
            dry.rms_error(joint, 0.0, model_angle)
        };
        let k = Lqr::<f64>::paper().gain;
        let offset = |j: usize| friction.static_nm / (k[(j, j)] - gravity_stiffness()[j]);
        let outside = free.samples.iter().rfind(|s| s.q.amax() > SETTLED_RAD);
        let limit = [Pwm::MIN, Pwm::MAX].map(|pwm| Joint::<f64>::paper().torque(pwm).abs());
        Ok(Self {
            difference_rad: [difference(0), difference(1)],
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
        let difference = |joint: usize| {
            Number::new(
                format!("Difference of model and arm (RMS), {}", JOINT_NAMES[joint]),
                "rad",
                self.difference_rad[joint],
                Rule::AtMost(CLOSE_RAD),
            )
        };
        let [requested, limit] = self.torque_nm;
        vec![Claim {
            id: "standing",
            title: "Figs. 7 and 8: LQR on the arm",
            paper: "From a start away from upright, model and arm follow trajectories that are \
                    very close to each other."
                .into(),
            finding: format!(
                "From {} and {} rad, with speeds by differences, encoder counts, integer PWM and \
                 dry friction, arm and model differ by {} and {} mrad (RMS over {} s). Without dry \
                 friction the arm stays within {} mrad after {} s; with it, the arm comes to rest \
                 with an error of up to {} mrad.",
                FROM_RAD[0],
                FROM_RAD[1],
                number(self.difference_rad[0] * 1e3, 1),
                number(self.difference_rad[1] * 1e3, 1),
                DURATION_S,
                SETTLED_RAD * 1e3,
                number(self.settled_s, 2),
                number(self.rest_rad * 1e3, 1),
            ),
            explanation: format!(
                "The difference has the cause that the paper suspects, unmodelled static friction: \
                 against the loop's stiffness it can hold the arm up to {} mrad from upright. \
                 Speeds by differences do no harm at 45 ms. The torque does not saturate: at most \
                 {} of {} N m are requested.",
                number(self.explained_rad * 1e3, 1),
                number(requested, 2),
                number(limit, 2),
            ),
            remedy: format!(
                "Compensate the dead zone, or estimate the friction torque. Faster sampling alone \
                 does not help, because the error is static: at {} ms with the board's observer, \
                 the arm rests {} mrad from upright.",
                f64::from(BOARD_US) * 1e-3,
                number(self.fast_rest_rad * 1e3, 1),
            ),
            printed: vec![
                difference(0),
                difference(1),
                Number::new(
                    "Ratio of the rest angle to the largest that friction explains",
                    "",
                    self.rest_rad / self.explained_rad,
                    Rule::AtMost(1.0),
                ),
                Number::new(
                    "Ratio of the largest torque to the servo's limit",
                    "",
                    requested / limit,
                    Rule::AtMost(1.0),
                ),
            ],
            reading: Vec::new(),
            figures: vec![self.figure(0), self.figure(1)],
        }]
    }

    fn figure(&self, joint: usize) -> Figure {
        let model = self.model.iter().map(|(t, q)| (*t, q[joint])).collect();
        let (name, paper_figure, title) = [
            ("fig7", "Fig. 7", "Model and arm with LQR, first joint"),
            ("fig8", "Fig. 8", "Model and arm with LQR, second joint"),
        ][joint];
        let curves = vec![
            Curve::new("arm, dry friction", DIFFERENCE, self.dry.angle(joint)),
            Curve::new("arm, no dry friction", PLACED, self.free.angle(joint)),
            Curve::new("model (7)", MODEL, model),
        ];
        Figure {
            name,
            paper_figure: Some(paper_figure),
            caption: format!(
                "{} from {} rad under K of (10) at {} ms. The paper's measured curve and its start \
                 are not available; the curves are those of the simulated arm, with speeds by \
                 differences, encoder counts and integer PWM. Model (7) stays at its start for one \
                 period because in Euler's B the torque does not act on the angles.",
                JOINT_NAMES[joint],
                FROM_RAD[joint],
                PERIOD_S * 1e3,
            ),
            chart: Chart {
                title,
                x_title: "time (s)",
                x: [0.0, 4.0],
                panels: vec![Subplot::new("", "angle (rad)", curves)],
            },
        }
    }
}

/// Simulates LQR on the arm.
fn run(estimator: &Estimator<f64>, friction: Friction, period_us: u32) -> Run {
    let control = SampledLoop {
        period_us,
        duration_s: DURATION_S,
        plant: arm_at(FROM_RAD, friction),
        delay: Delay::None,
        input: EstimatorInput::Requested,
        start: InitialEstimate::FirstSample,
        compensate: false,
    };
    control.regulate(estimator)
}

/// Angles in rad over time in s of the linear model: (6), (7) and (9) alone.
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
