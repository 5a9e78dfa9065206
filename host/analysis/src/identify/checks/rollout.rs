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

/// Rolls out a window of a smoothed trace, its initial state fitted to its first ticks.
pub(in super::super) fn rollout(
    window: &Window,
    trace: &Trace,
    known: &KnownParameters,
    coordinates: &[f64; COUNT],
    fitted_ticks: usize,
) -> Rollout {
    /// The motion is nearly linear in the initial state.
    const ITERATIONS: usize = 3;
    let mut initial_state = Vector2::from(trace.states[window.first][window.joint]);
    let mut normal = Matrix2::zeros();
    let mut rolled = simulate(window, trace, known, coordinates, initial_state);
    for _ in 0..ITERATIONS {
        let ticks = rolled
            .sensitivities
            .iter()
            .zip(&rolled.residuals)
            .take(fitted_ticks);
        let mut gradient = Vector2::zeros();
        normal = Matrix2::zeros();
        for (sensitivity, residual) in ticks.filter(|(_, residual)| residual.is_finite()) {
            normal += sensitivity * sensitivity.transpose();
            gradient += sensitivity * *residual;
        }
        let Some(step) = normal.try_inverse().map(|inverse| inverse * gradient) else {
            break;
        };
        initial_state += step;
        rolled = simulate(window, trace, known, coordinates, initial_state);
    }
    let covariance = normal.try_inverse().unwrap_or_else(Matrix2::zeros);
    let deviation = |sensitivity: &Vector2<f64>| {
        (sensitivity.transpose() * covariance * sensitivity)[0]
            .max(0.0)
            .sqrt()
    };
    rolled.deviation = rolled.sensitivities.iter().map(deviation).collect();
    rolled
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
