//! Rollout of a window: its motion simulated with the estimates, its initial state fitted.

use nalgebra::{Matrix2, Vector2};
use num_dual::{DualSVec64, DualStruct};

use super::super::arm::{JointModel, KnownParameters};
use super::super::cost::BLOCK;
use super::super::dataset::{Trace, Window};
use super::super::motion::Motion;
use super::super::quantity::{COUNT, PER_JOINT, Quantity};

/// Carries the derivatives by the initial angle and speed.
type Dual = DualSVec64<2>;

/// A window, measured and computed.
#[derive(Clone, Debug)]
pub struct Rollout {
    /// The window.
    pub window: Window,
    /// Computed encoder position in counts, tick by tick.
    pub computed: Vec<f64>,
    /// Measured less computed in counts; NaN for a missing sample.
    pub residuals: Vec<f64>,
    /// Standard deviation in counts of the computed position because of the uncertainty of
    /// the initial state, with one count of noise in each fitted tick.
    pub deviation: Vec<f64>,
    /// Derivatives of the computed position by the initial state.
    sensitivities: Vec<Vector2<f64>>,
    /// Direction of sliding: towards larger (1) or smaller (-1) angles, or at rest (0).
    pub(super) directions: Vec<f64>,
}

/// Residual of a block of ticks, and its sensitivity to the initial state.
pub(super) struct Block {
    /// Sum of the ticks' residuals over the root of their number.
    pub(super) residual: f64,
    /// The same of the derivatives by the initial state.
    pub(super) sensitivity: Vector2<f64>,
}

/// Rolls out a window of a smoothed trace, its initial state fitted to its first ticks: by
/// Gauss-Newton steps, each of them halved until the residuals fall. A standing arm amplifies an error of
/// the initial state a hundredfold within a long window, and reversals make the motion nonlinear in it.
pub(in super::super) fn rollout(
    window: &Window,
    trace: &Trace,
    known: &KnownParameters,
    coordinates: &[f64; COUNT],
    fitted_ticks: usize,
) -> Rollout {
    /// Most Gauss-Newton steps, and halvings of one.
    const STEPS: usize = 20;
    const HALVINGS: i32 = 8;
    /// Relative reduction of the squares at convergence.
    const TOLERANCE: f64 = 1e-6;
    let from = |initial_state| simulate(window, trace, known, coordinates, initial_state);
    let mut initial_state = Vector2::from(trace.states[window.first][window.joint]);
    let mut rolled = from(initial_state);
    let mut equations = rolled.normal_equations(fitted_ticks);
    for _ in 0..STEPS {
        let Some(inverse) = equations.matrix.try_inverse() else {
            break;
        };
        let step = inverse * equations.gradient;
        let shorter = (0..HALVINGS).map(|halvings| {
            let state = initial_state + step * 0.5_f64.powi(halvings);
            let rolled = from(state);
            let equations = rolled.normal_equations(fitted_ticks);
            (state, rolled, equations)
        });
        let squares = equations.squares;
        let mut better = shorter.filter(|(_, _, equations)| equations.squares < squares);
        let Some(next) = better.next() else {
            break;
        };
        (initial_state, rolled, equations) = next;
        if equations.squares > squares * (1.0 - TOLERANCE) {
            break;
        }
    }
    let covariance = equations
        .matrix
        .try_inverse()
        .unwrap_or_else(Matrix2::zeros);
    let deviation = |sensitivity: &Vector2<f64>| {
        (sensitivity.transpose() * covariance * sensitivity)[0]
            .max(0.0)
            .sqrt()
    };
    rolled.deviation = rolled.sensitivities.iter().map(deviation).collect();
    rolled
}

/// Normal equations of the initial state, and the sum of the squared residuals.
struct NormalEquations {
    matrix: Matrix2<f64>,
    gradient: Vector2<f64>,
    squares: f64,
}

fn simulate(
    window: &Window,
    trace: &Trace,
    known: &KnownParameters,
    coordinates: &[f64; COUNT],
    initial_state: Vector2<f64>,
) -> Rollout {
    let &Window {
        joint, first, len, ..
    } = window;
    let own: [Dual; PER_JOINT] =
        core::array::from_fn(|i| coordinates[joint * PER_JOINT + i].into());
    let link = Dual::from_re(coordinates[Quantity::Gravity.index(1)]);
    let start = [0, 1].map(|i| Dual::from_re(initial_state[i]).derivative(i));
    let model = JointModel::new(known, joint, &own, link);
    let mut motion = Motion::new(model, joint, known, trace, start, initial_state[1].signum());
    let mut rollout = Rollout {
        window: window.clone(),
        computed: Vec::with_capacity(len),
        residuals: Vec::with_capacity(len),
        deviation: Vec::new(),
        sensitivities: Vec::with_capacity(len),
        directions: Vec::with_capacity(len),
    };
    for tick in first..first + len {
        let position = motion.position();
        rollout.directions.push(motion.direction());
        let measured = trace.counts[tick][joint].map_or(f64::NAN, f64::from);
        rollout.computed.push(position.re());
        rollout.residuals.push(measured - position.re());
        rollout.sensitivities.push(
            position
                .eps
                .unwrap_generic(nalgebra::Const, nalgebra::Const),
        );
        motion.step(tick);
    }
    rollout
}

impl Rollout {
    /// Of the first ticks.
    fn normal_equations(&self, ticks: usize) -> NormalEquations {
        let mut equations = NormalEquations {
            matrix: Matrix2::zeros(),
            gradient: Vector2::zeros(),
            squares: 0.0,
        };
        let ticks = self.sensitivities.iter().zip(&self.residuals).take(ticks);
        for (sensitivity, residual) in ticks.filter(|(_, residual)| residual.is_finite()) {
            equations.matrix += sensitivity * sensitivity.transpose();
            equations.gradient += sensitivity * *residual;
            equations.squares += residual * residual;
        }
        equations
    }

    /// Root mean square of the residuals of a range of ticks, in counts.
    pub fn rms(&self, part: core::ops::Range<usize>) -> f64 {
        let residuals = self.residuals[part]
            .iter()
            .filter(|residual| residual.is_finite());
        let (squares, count) = residuals.fold((0.0, 0.0), |(squares, count), residual| {
            (squares + residual * residual, count + 1.0)
        });
        f64::sqrt(squares / count)
    }

    /// The residuals, block by block.
    pub(super) fn blocks(&self) -> Vec<Block> {
        let nothing = vec![[]; self.residuals.len()];
        self.blocks_with::<0>(&nothing)
            .into_iter()
            .map(|(block, _)| block)
            .collect()
    }

    /// The residuals and further values of each tick, block by block.
    pub(super) fn blocks_with<const N: usize>(&self, more: &[[f64; N]]) -> Vec<(Block, [f64; N])> {
        let ticks: Vec<_> = self
            .residuals
            .iter()
            .zip(&self.sensitivities)
            .zip(more)
            .collect();
        let mut blocks = Vec::new();
        for ticks in ticks.chunks(BLOCK) {
            let (mut residual, mut sensitivity, mut sum, mut n) =
                (0.0, Vector2::zeros(), [0.0; N], 0.0);
            for ((own, sensitivity_), more) in ticks
                .iter()
                .filter(|((residual, _), _)| residual.is_finite())
            {
                residual += **own;
                sensitivity += **sensitivity_;
                sum = core::array::from_fn(|i| sum[i] + more[i]);
                n += 1.0;
            }
            if n > 0.0 {
                let root = f64::sqrt(n);
                let block = Block {
                    residual: residual / root,
                    sensitivity: sensitivity / root,
                };
                blocks.push((block, sum.map(|sum| sum / root)));
            }
        }
        blocks
    }
}
