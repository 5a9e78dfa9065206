//! A window's motion by the numbers that were found; of the window itself only its start
//! is sought.

use nalgebra::{Matrix2, Vector2};
use num_dual::{DualSVec64, DualStruct};

use super::super::arm::{Joint, Known};
use super::super::cost::BLOCK;
use super::super::dataset::{Trace, Window};
use super::super::motion::Motion;
use super::super::quantity::{COUNT, PER_JOINT, Quantity};

/// Carries the derivatives by the start: angle and speed.
type Dual = DualSVec64<2>;

/// A window, as it was measured and as it is computed.
#[derive(Clone, Debug)]
pub struct Followed {
    /// Which.
    pub window: Window,
    /// Encoder counts that are computed, tick by tick.
    pub computed: Vec<f64>,
    /// Measured less computed in counts; not a number where nothing was measured.
    pub errors: Vec<f64>,
    /// Standard deviation in counts of what is computed, by what is not known of the start
    /// where each measured tick is off by one count.
    pub spread: Vec<f64>,
    /// Derivatives of what is computed by the start.
    slopes: Vec<Vector2<f64>>,
    /// Which way it slides, towards larger (1) or smaller (-1) angles, or not (0).
    pub(super) ways: Vec<f64>,
}

/// Errors of a block of ticks, and how they depend on the start.
pub(super) struct Block {
    /// Sum of the errors by the root of their number.
    pub(super) error: f64,
    /// Of the start's derivatives likewise.
    pub(super) slope: Vector2<f64>,
}

/// Follows a window in a smoothed trace; its start is sought in so many of its ticks.
pub(in super::super) fn follow(
    window: &Window,
    trace: &Trace,
    known: &Known,
    at: &[f64; COUNT],
    fitted: usize,
) -> Followed {
    /// The start enters nearly linearly.
    const ROUNDS: usize = 3;
    let mut x = Vector2::from(trace.smooth[window.first][window.joint]);
    let mut normal = Matrix2::zeros();
    let mut followed = run(window, trace, known, at, x);
    for _ in 0..ROUNDS {
        let ticks = followed.slopes.iter().zip(&followed.errors).take(fitted);
        let mut right = Vector2::zeros();
        normal = Matrix2::zeros();
        for (slope, error) in ticks.filter(|(_, error)| error.is_finite()) {
            normal += slope * slope.transpose();
            right += slope * *error;
        }
        let Some(step) = normal.try_inverse().map(|inverse| inverse * right) else {
            break;
        };
        x += step;
        followed = run(window, trace, known, at, x);
    }
    let covariance = normal.try_inverse().unwrap_or_else(Matrix2::zeros);
    let spread = |slope: &Vector2<f64>| (slope.transpose() * covariance * slope)[0].max(0.0).sqrt();
    followed.spread = followed.slopes.iter().map(spread).collect();
    followed
}

fn run(
    window: &Window,
    trace: &Trace,
    known: &Known,
    at: &[f64; COUNT],
    x: Vector2<f64>,
) -> Followed {
    let &Window {
        joint, first, len, ..
    } = window;
    let own: [Dual; PER_JOINT] = core::array::from_fn(|i| at[joint * PER_JOINT + i].into());
    let link = Dual::from_re(at[Quantity::Gravity.at(1)]);
    let start = [0, 1].map(|i| Dual::from_re(x[i]).derivative(i));
    let model = Joint::new(known, joint, &own, link);
    let mut motion = Motion::new(model, joint, known, trace, start, x[1].signum());
    let mut followed = Followed {
        window: window.clone(),
        computed: Vec::with_capacity(len),
        errors: Vec::with_capacity(len),
        spread: Vec::new(),
        slopes: Vec::with_capacity(len),
        ways: Vec::with_capacity(len),
    };
    for tick in first..first + len {
        let position = motion.position();
        followed.ways.push(motion.way());
        let measured = trace.counts[tick][joint].map_or(f64::NAN, f64::from);
        followed.computed.push(position.re());
        followed.errors.push(measured - position.re());
        followed.slopes.push(
            position
                .eps
                .unwrap_generic(nalgebra::Const, nalgebra::Const),
        );
        motion.step(tick);
    }
    followed
}

impl Followed {
    /// Root mean square of the errors of a part of the ticks, in counts.
    pub fn rms(&self, part: core::ops::Range<usize>) -> f64 {
        let errors = self.errors[part].iter().filter(|error| error.is_finite());
        let (squares, count) = errors.fold((0.0, 0.0), |(squares, count), error| {
            (squares + error * error, count + 1.0)
        });
        f64::sqrt(squares / count)
    }

    /// The errors, block by block.
    pub(super) fn blocks(&self) -> Vec<Block> {
        let nothing = vec![[]; self.errors.len()];
        self.blocks_with::<0>(&nothing)
            .into_iter()
            .map(|(block, _)| block)
            .collect()
    }

    /// The errors, and something else that has values for each tick, block by block.
    pub(super) fn blocks_with<const N: usize>(&self, more: &[[f64; N]]) -> Vec<(Block, [f64; N])> {
        let ticks: Vec<_> = self.errors.iter().zip(&self.slopes).zip(more).collect();
        let mut blocks = Vec::new();
        for ticks in ticks.chunks(BLOCK) {
            let (mut error, mut slope, mut sum, mut n) = (0.0, Vector2::zeros(), [0.0; N], 0.0);
            for ((own, by_start), more) in ticks.iter().filter(|((error, _), _)| error.is_finite())
            {
                error += **own;
                slope += **by_start;
                sum = core::array::from_fn(|i| sum[i] + more[i]);
                n += 1.0;
            }
            if n > 0.0 {
                let root = f64::sqrt(n);
                let block = Block {
                    error: error / root,
                    slope: slope / root,
                };
                blocks.push((block, sum.map(|sum| sum / root)));
            }
        }
        blocks
    }
}
