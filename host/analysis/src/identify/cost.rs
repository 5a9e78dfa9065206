//! How far the arm of given numbers is from what was measured, and which way is down.
//!
//! Each window begins with two numbers of its own, the angle and the speed of its first
//! tick: nuisance parameters. They are eliminated: of the window's normal
//! equations only what is left when they are at their best goes into the sum.

use armbridge_shared::JOINTS;
use nalgebra::{SMatrix, SVector};
use num_dual::{DualSVec64, DualStruct};

use super::arm::{Joint, Known};
use super::dataset::{Trace, Window};
use super::motion::Motion;
use super::quantity::{COUNT, PER_JOINT, Quantity};

/// Numbers of a window's start.
pub(super) const STARTS: usize = 2;
/// Derivatives that a motion carries: the joint's own numbers, link 2's gravity, its start.
const LANES: usize = PER_JOINT + 1 + STARTS;
const LINK: usize = PER_JOINT;
/// All but the start.
const OWN: usize = PER_JOINT + 1;
/// Ticks whose errors are added up to one: nothing of interest is that fast.
pub(super) const BLOCK: usize = 5;

type Dual = DualSVec64<LANES>;
type Slope = SVector<f64, COUNT>;
type Curve = SMatrix<f64, COUNT, COUNT>;

/// The sum over windows.
#[derive(Clone, Debug)]
pub(super) struct Cost {
    /// Sum of squares in counts squared.
    pub(super) squares: f64,
    /// Errors in it, blocks of [`BLOCK`] ticks.
    pub(super) count: usize,
    /// Half the slope of the sum, downwards.
    pub(super) gradient: Slope,
    /// Half its curvature, after Gauss and Newton.
    pub(super) hessian: Curve,
    /// Sum of the outer products of the windows' slopes.
    pub(super) scatter: Curve,
}

/// A window, and where it is thought to begin.
#[derive(Clone, Debug)]
pub struct Stretch {
    /// The window.
    pub window: Window,
    /// Angle in rad and speed in rad/s.
    x: [f64; STARTS],
    /// How the best start depends on the coordinates at which it was sought last.
    seen: Option<([f64; COUNT], SMatrix<f64, STARTS, COUNT>)>,
    /// Sum of its errors' squares, in counts squared, as looked at last.
    pub squares: f64,
    /// Errors in it.
    pub count: usize,
}

impl Stretch {
    pub(super) fn new(window: Window, trace: &Trace) -> Self {
        Self {
            x: trace.smooth[window.first][window.joint],
            window,
            seen: None,
            squares: 0.0,
            count: 0,
        }
    }
}

/// The normal equations of a window.
struct Look {
    squares: f64,
    count: usize,
    gradient: Slope,
    hessian: Curve,
    /// From the start that was taken to the best.
    step: SVector<f64, STARTS>,
    back: SMatrix<f64, STARTS, COUNT>,
    /// How much that is better.
    gain: f64,
}

/// Where a joint's lane belongs among the coordinates.
fn place(joint: usize, lane: usize) -> usize {
    if lane == LINK {
        Quantity::Gravity.at(1)
    } else {
        joint * PER_JOINT + lane
    }
}

fn motion<'a>(
    stretch: &Stretch,
    trace: &'a Trace,
    known: &Known,
    at: &[f64; COUNT],
) -> Motion<'a, Dual> {
    let lane = |value: f64, index: usize| Dual::from_re(value).derivative(index);
    let Window { joint, .. } = stretch.window;
    let coordinates = core::array::from_fn(|i| lane(at[joint * PER_JOINT + i], i));
    let link = match joint {
        0 => lane(at[Quantity::Gravity.at(1)], LINK),
        _ => coordinates[Quantity::Gravity as usize],
    };
    let start = [lane(stretch.x[0], LINK + 1), lane(stretch.x[1], LINK + 2)];
    let model = Joint::new(known, joint, &coordinates, link);
    Motion::new(model, joint, known, trace, start, stretch.x[1].signum())
}

fn look(stretch: &Stretch, trace: &Trace, known: &Known, at: &[f64; COUNT]) -> Look {
    let Window {
        joint, first, len, ..
    } = stretch.window;
    let mut motion = motion(stretch, trace, known, at);
    let mut normal = SMatrix::<f64, LANES, LANES>::zeros();
    let mut right = SVector::<f64, LANES>::zeros();
    let (mut squares, mut count) = (0.0, 0);
    let (mut sum, mut n, mut slope) = (0.0, 0, SVector::<f64, LANES>::zeros());
    for tick in first..first + len {
        if let Some(measured) = trace.counts[tick][joint] {
            let position = motion.position();
            sum += f64::from(measured) - position.re();
            n += 1;
            if let Some(eps) = position.eps.0.as_ref() {
                slope += eps;
            }
        }
        if n == BLOCK || (tick + 1 == first + len && n > 0) {
            let scale = 1.0 / f64::from(n as u32).sqrt();
            let (residual, row) = (sum * scale, slope * scale);
            squares += residual * residual;
            count += 1;
            right.axpy(residual, &row, 1.0);
            normal.syger(1.0, &row, &row, 1.0);
            (sum, n) = (0.0, 0);
            slope.fill(0.0);
        }
        motion.step(tick);
    }
    normal.fill_upper_triangle_with_lower_triangle();
    let starts = normal.fixed_view::<STARTS, STARTS>(OWN, OWN).into_owned();
    let cross = normal.fixed_view::<OWN, STARTS>(0, OWN).into_owned();
    let own = normal.fixed_view::<OWN, OWN>(0, 0).into_owned();
    let inverse = starts.try_inverse().unwrap_or_else(SMatrix::zeros);
    let step = inverse * right.fixed_rows::<STARTS>(OWN);
    let back = inverse * cross.transpose();
    let gain = step.dot(&right.fixed_rows::<STARTS>(OWN));
    let gradient = right.fixed_rows::<OWN>(0) - cross * step;
    let hessian = own - cross * back;
    let mut look = Look {
        squares: squares - gain,
        count,
        gradient: Slope::zeros(),
        hessian: Curve::zeros(),
        step,
        back: SMatrix::zeros(),
        gain,
    };
    for i in 0..OWN {
        let a = place(joint, i);
        look.gradient[a] += gradient[i];
        for s in 0..STARTS {
            look.back[(s, a)] += back[(s, i)];
        }
        for j in 0..OWN {
            look.hessian[(a, place(joint, j))] += hessian[(i, j)];
        }
    }
    look
}

/// The sum at these coordinates; moves the windows' starts to their best. A window whose
/// errors are more than `most` squared on average pulls less the farther off it is.
pub(super) fn cost(
    stretches: &mut [Stretch],
    traces: &[Trace],
    known: &Known,
    at: &[f64; COUNT],
    most: f64,
) -> Cost {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let share = stretches.len().div_ceil(threads).max(1);
    std::thread::scope(|scope| {
        let parts: Vec<_> = stretches
            .chunks_mut(share)
            .map(|part| {
                scope.spawn(move || {
                    part.iter_mut().fold(Cost::zero(), |total, stretch| {
                        let trace = &traces[stretch.window.trace];
                        total.plus(&of_window(stretch, trace, known, at, most))
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

/// A window's part of it.
fn of_window(
    stretch: &mut Stretch,
    trace: &Trace,
    known: &Known,
    at: &[f64; COUNT],
    most: f64,
) -> Cost {
    if let Some((before, back)) = &stretch.seen {
        let moved = back * Slope::from_fn(|i, _| at[i] - before[i]);
        stretch.x = core::array::from_fn(|i| stretch.x[i] - moved[i]);
    }
    let mut found = look(stretch, trace, known, at);
    if found.gain > 1.0 {
        stretch.x = core::array::from_fn(|i| stretch.x[i] + found.step[i]);
        found = look(stretch, trace, known, at);
    }
    stretch.x = core::array::from_fn(|i| stretch.x[i] + found.step[i]);
    stretch.seen = Some((*at, found.back));
    (stretch.squares, stretch.count) = (found.squares, found.count);
    let most = most * found.count as f64;
    let (squares, weight) = if found.squares > most {
        (
            most * (1.0 + (found.squares / most).ln()),
            most / found.squares,
        )
    } else {
        (found.squares, 1.0)
    };
    let gradient = found.gradient * weight;
    Cost {
        squares,
        count: found.count,
        gradient,
        hessian: found.hessian * weight,
        scatter: gradient * gradient.transpose(),
    }
}

impl Cost {
    fn zero() -> Self {
        Self {
            squares: 0.0,
            count: 0,
            gradient: Slope::zeros(),
            hessian: Curve::zeros(),
            scatter: Curve::zeros(),
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
