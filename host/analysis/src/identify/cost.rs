//! Cost of an arm's coordinates: the sum of squared residuals over windows, with its
//! gradient and Gauss-Newton Hessian.
//!
//! Each window has two nuisance parameters of its own, the angle and the speed of its first
//! tick. They are eliminated: only the Schur complement of the window's normal equations,
//! with the initial state at its optimum, enters the sum.

use armbridge_servo::JOINTS;
use nalgebra::{SMatrix, SVector};
use num_dual::{DualSVec64, DualStruct};

use super::arm::{JointModel, KnownParameters};
use super::dataset::{Trace, Window};
use super::motion::Motion;
use super::quantity::{COUNT, PER_JOINT, Quantity};

/// Components of a window's initial state.
pub(super) const INITIAL_STATES: usize = 2;
/// Derivatives of a motion: by the joint's own parameters, link 2's gravity, and the
/// window's initial state.
const DERIVATIVES: usize = PER_JOINT + 1 + INITIAL_STATES;
/// Index of the derivative by link 2's gravity.
const LINK: usize = PER_JOINT;
/// Derivatives without those by the initial state.
const PARAMETERS: usize = PER_JOINT + 1;
/// Ticks whose residuals are added up to one: nothing of interest is that fast.
pub(super) const BLOCK: usize = 5;

type Dual = DualSVec64<DERIVATIVES>;
type Gradient = SVector<f64, COUNT>;
type Hessian = SMatrix<f64, COUNT, COUNT>;
/// Derivatives of a window's optimal initial state by all coordinates.
type StartSensitivity = SMatrix<f64, INITIAL_STATES, COUNT>;

/// Sum over windows.
#[derive(Clone, Debug)]
pub(super) struct Cost {
    /// Sum of squares in counts squared.
    pub(super) squares: f64,
    /// Residuals in it, of blocks of [`BLOCK`] ticks.
    pub(super) count: usize,
    /// Half the negative gradient of the sum.
    pub(super) gradient: Gradient,
    /// Half its Gauss-Newton Hessian.
    pub(super) hessian: Hessian,
    /// Sum of the outer products of the windows' gradients.
    pub(super) scatter: Hessian,
}

/// Fit of a window: its initial state and its sum of squares.
#[derive(Clone, Debug)]
pub struct WindowFit {
    /// The window.
    pub window: Window,
    /// Angle in rad and speed in rad/s of its first tick.
    initial_state: [f64; INITIAL_STATES],
    /// Coordinates of the last evaluation, and the sensitivity of the initial state there.
    start_sensitivity: Option<([f64; COUNT], StartSensitivity)>,
    /// Sum of the squared residuals at the last evaluation, in counts squared.
    pub squares: f64,
    /// Number of residuals, of blocks of [`BLOCK`] ticks.
    pub count: usize,
}

impl WindowFit {
    pub(super) fn new(window: Window, trace: &Trace) -> Self {
        Self {
            initial_state: trace.states[window.first][window.joint],
            window,
            start_sensitivity: None,
            squares: 0.0,
            count: 0,
        }
    }

    /// Whether the mean square of the residuals, in counts squared, is at most this limit.
    pub(super) fn is_explained(&self, limit_counts2: f64) -> bool {
        self.squares <= limit_counts2 * self.count as f64
    }

    /// Sum of the squared residuals, and weight of its derivatives: an outlier's grows by its
    /// logarithm only.
    pub(super) fn weighted_squares(&self, limit_counts2: f64) -> (f64, f64) {
        let limit = limit_counts2 * self.count as f64;
        if self.squares > limit {
            let ratio = self.squares / limit;
            (limit * (1.0 + ratio.ln()), 1.0 / ratio)
        } else {
            (self.squares, 1.0)
        }
    }

    /// Root mean square of the residuals in counts.
    pub(super) fn rms_counts(&self) -> f64 {
        (self.squares / self.count as f64).sqrt()
    }
}

/// Normal equations of a window, its initial state eliminated.
struct NormalEquations {
    squares: f64,
    count: usize,
    gradient: Gradient,
    hessian: Hessian,
    /// Step from the initial state of the evaluation to the optimal one.
    start_step: SVector<f64, INITIAL_STATES>,
    start_sensitivity: StartSensitivity,
    /// Reduction of the sum of squares by that step.
    start_improvement: f64,
}

/// Index among all coordinates of a joint's derivative.
fn coordinate_index(joint: usize, derivative: usize) -> usize {
    if derivative == LINK {
        Quantity::Gravity.index(1)
    } else {
        joint * PER_JOINT + derivative
    }
}

fn motion<'a>(
    window_fit: &WindowFit,
    trace: &'a Trace,
    known: &KnownParameters,
    coordinates: &[f64; COUNT],
) -> Motion<'a, Dual> {
    let dual = |value: f64, index: usize| Dual::from_re(value).derivative(index);
    let Window { joint, .. } = window_fit.window;
    let own = core::array::from_fn(|i| dual(coordinates[joint * PER_JOINT + i], i));
    let link = match joint {
        0 => dual(coordinates[Quantity::Gravity.index(1)], LINK),
        _ => own[Quantity::Gravity as usize],
    };
    let [angle, speed] = window_fit.initial_state;
    let start = [dual(angle, LINK + 1), dual(speed, LINK + 2)];
    let model = JointModel::new(known, joint, &own, link);
    Motion::new(model, joint, known, trace, start, speed.signum())
}

fn normal_equations(
    window_fit: &WindowFit,
    trace: &Trace,
    known: &KnownParameters,
    coordinates: &[f64; COUNT],
) -> NormalEquations {
    let Window {
        joint, first, len, ..
    } = window_fit.window;
    let mut motion = motion(window_fit, trace, known, coordinates);
    let mut normal = SMatrix::<f64, DERIVATIVES, DERIVATIVES>::zeros();
    let mut right = SVector::<f64, DERIVATIVES>::zeros();
    let (mut squares, mut count) = (0.0, 0);
    let (mut sum, mut n) = (0.0, 0);
    let mut sensitivity = SVector::<f64, DERIVATIVES>::zeros();
    for tick in first..first + len {
        if let Some(measured) = trace.counts[tick][joint] {
            let position = motion.position();
            sum += f64::from(measured) - position.re();
            n += 1;
            if let Some(eps) = position.eps.0.as_ref() {
                sensitivity += eps;
            }
        }
        if n == BLOCK || (tick + 1 == first + len && n > 0) {
            let scale = 1.0 / f64::from(n as u32).sqrt();
            let (residual, row) = (sum * scale, sensitivity * scale);
            squares += residual * residual;
            count += 1;
            right.axpy(residual, &row, 1.0);
            normal.syger(1.0, &row, &row, 1.0);
            (sum, n) = (0.0, 0);
            sensitivity.fill(0.0);
        }
        motion.step(tick);
    }
    normal.fill_upper_triangle_with_lower_triangle();
    let starts = normal
        .fixed_view::<INITIAL_STATES, INITIAL_STATES>(PARAMETERS, PARAMETERS)
        .into_owned();
    let cross = normal
        .fixed_view::<PARAMETERS, INITIAL_STATES>(0, PARAMETERS)
        .into_owned();
    let own = normal
        .fixed_view::<PARAMETERS, PARAMETERS>(0, 0)
        .into_owned();
    let inverse = starts.try_inverse().unwrap_or_else(SMatrix::zeros);
    let start_step = inverse * right.fixed_rows::<INITIAL_STATES>(PARAMETERS);
    let start_sensitivity = inverse * cross.transpose();
    let start_improvement = start_step.dot(&right.fixed_rows::<INITIAL_STATES>(PARAMETERS));
    let gradient = right.fixed_rows::<PARAMETERS>(0) - cross * start_step;
    let hessian = own - cross * start_sensitivity;
    let mut equations = NormalEquations {
        squares: squares - start_improvement,
        count,
        gradient: Gradient::zeros(),
        hessian: Hessian::zeros(),
        start_step,
        start_sensitivity: SMatrix::zeros(),
        start_improvement,
    };
    for i in 0..PARAMETERS {
        let row = coordinate_index(joint, i);
        equations.gradient[row] += gradient[i];
        for s in 0..INITIAL_STATES {
            equations.start_sensitivity[(s, row)] += start_sensitivity[(s, i)];
        }
        for j in 0..PARAMETERS {
            equations.hessian[(row, coordinate_index(joint, j))] += hessian[(i, j)];
        }
    }
    equations
}

/// Cost at these coordinates; moves the windows' initial states to their optimum. The
/// weight of a window falls with its mean square above the outlier limit.
pub(super) fn cost(
    window_fits: &mut [WindowFit],
    traces: &[Trace],
    known: &KnownParameters,
    coordinates: &[f64; COUNT],
    outlier_limit_counts2: f64,
) -> Cost {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let per_thread = window_fits.len().div_ceil(threads).max(1);
    std::thread::scope(|scope| {
        let parts: Vec<_> = window_fits
            .chunks_mut(per_thread)
            .map(|part| {
                scope.spawn(move || {
                    part.iter_mut().fold(Cost::zero(), |total, window_fit| {
                        let trace = &traces[window_fit.window.trace];
                        let limit = outlier_limit_counts2;
                        total.plus(&window_cost(window_fit, trace, known, coordinates, limit))
                    })
                })
            })
            .collect();
        let parts = parts.into_iter().map(|part| match part.join() {
            Ok(cost) => cost,
            Err(panic) => std::panic::resume_unwind(panic),
        });
        parts.fold(Cost::zero(), |total, part| total.plus(&part))
    })
}

/// Contribution of a window.
fn window_cost(
    window_fit: &mut WindowFit,
    trace: &Trace,
    known: &KnownParameters,
    coordinates: &[f64; COUNT],
    outlier_limit_counts2: f64,
) -> Cost {
    if let Some((before, sensitivity)) = &window_fit.start_sensitivity {
        let moved = sensitivity * Gradient::from_fn(|i, _| coordinates[i] - before[i]);
        window_fit.initial_state = core::array::from_fn(|i| window_fit.initial_state[i] - moved[i]);
    }
    let mut equations = normal_equations(window_fit, trace, known, coordinates);
    if equations.start_improvement > 1.0 {
        window_fit.step_start(&equations);
        equations = normal_equations(window_fit, trace, known, coordinates);
    }
    window_fit.step_start(&equations);
    window_fit.start_sensitivity = Some((*coordinates, equations.start_sensitivity));
    (window_fit.squares, window_fit.count) = (equations.squares, equations.count);
    let (squares, weight) = window_fit.weighted_squares(outlier_limit_counts2);
    let gradient = equations.gradient * weight;
    Cost {
        squares,
        count: equations.count,
        gradient,
        hessian: equations.hessian * weight,
        scatter: gradient * gradient.transpose(),
    }
}

impl WindowFit {
    fn step_start(&mut self, equations: &NormalEquations) {
        let step = &equations.start_step;
        self.initial_state = core::array::from_fn(|i| self.initial_state[i] + step[i]);
    }
}

impl Cost {
    fn zero() -> Self {
        Self {
            squares: 0.0,
            count: 0,
            gradient: Gradient::zeros(),
            hessian: Hessian::zeros(),
            scatter: Hessian::zeros(),
        }
    }

    fn plus(self, other: &Self) -> Self {
        Self {
            squares: self.squares + other.squares,
            count: self.count + other.count,
            gradient: self.gradient + other.gradient,
            hessian: self.hessian + other.hessian,
            scatter: self.scatter + other.scatter,
        }
    }
}

const _: () = assert!(JOINTS == 2, "the other joint is the one that is not this");
