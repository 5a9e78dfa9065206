//! Nonlinear least squares by Levenberg-Marquardt, with a trust region as in MINPACK.
//!
//! Moré, "The Levenberg-Marquardt algorithm: implementation and theory", 1978. Each step
//! minimises the residuals' linear model within a ball about the current coordinates, in
//! which each coordinate is scaled by the largest norm that its column of the Jacobian has
//! had. The ball grows where the model forecasts the residuals, and shrinks where it does
//! not. Its step is found in the singular vectors of the scaled Jacobian, in which the
//! damping for any radius is the root of a scalar function; the decomposition is done
//! once for each Jacobian.

use nalgebra::{DMatrix, DVector};

/// A problem at its current coordinates.
pub(crate) trait LeastSquares {
    /// The coordinates.
    fn coordinates(&self) -> DVector<f64>;
    /// Changes the coordinates.
    fn set_coordinates(&mut self, coordinates: &DVector<f64>);
    /// The residuals, if they can be computed; always of one length, at least as many as
    /// there are coordinates.
    fn residuals(&self) -> Option<DVector<f64>>;
    /// Derivatives of the residuals, one row per residual, if they can be computed.
    fn jacobian(&self) -> Option<DMatrix<f64>>;
}

/// When a search ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// Relative change of the sum of squares, and of the coordinates.
    pub(crate) tolerance: f64,
    /// Cosine between the residuals and a column of the Jacobian.
    pub(crate) gradient_tolerance: f64,
    /// Evaluations per coordinate, and as many once more.
    pub(crate) patience: usize,
}

impl Default for Limits {
    /// As near to the minimum as rounding allows.
    fn default() -> Self {
        Self {
            tolerance: 30.0 * f64::EPSILON,
            gradient_tolerance: 30.0 * f64::EPSILON,
            patience: 100,
        }
    }
}

/// End of a search. The problem has the best coordinates that were found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum End {
    /// At a minimum, within the tolerances or as far as rounding allows.
    Converged,
    /// The limit of evaluations is reached.
    OutOfPatience,
    /// Residuals or derivatives could not be computed, or are not finite.
    NotFinite,
}

/// Searches for a minimum from the problem's coordinates.
pub(crate) fn minimise(problem: &mut impl LeastSquares, limits: Limits) -> End {
    let mut x = problem.coordinates();
    let mut scale = DVector::zeros(x.len());
    let mut region = None;
    let mut evaluations_left = limits.patience * (x.len() + 1);
    let Some(mut residuals) = problem.residuals() else {
        return End::NotFinite;
    };
    loop {
        let norm = residuals.norm();
        if norm <= f64::MIN_POSITIVE {
            return End::Converged;
        }
        let is_finite = |jacobian: &DMatrix<f64>| {
            norm.is_finite() && jacobian.iter().all(|slope| slope.is_finite())
        };
        let Some(jacobian) = problem.jacobian().filter(is_finite) else {
            return End::NotFinite;
        };
        if steepest(&jacobian, &residuals) <= limits.gradient_tolerance {
            return End::Converged;
        }
        rescale(&mut scale, &jacobian);
        let region = region.get_or_insert_with(|| TrustRegion::new(x.component_mul(&scale).norm()));
        let model = LinearModel::new(jacobian, &residuals, &scale);
        // Steps from here, until one is better or the search ends.
        loop {
            let step = model.step(region);
            if !step.len.is_finite() {
                problem.set_coordinates(&x);
                return End::NotFinite;
            }
            let next = &x - &step.coordinates;
            problem.set_coordinates(&next);
            evaluations_left = evaluations_left.saturating_sub(1);
            let Some(candidate) = problem.residuals() else {
                problem.set_coordinates(&x);
                return End::NotFinite;
            };
            let forecast = step.forecast / norm.powi(2);
            let reduction = reduction(norm, candidate.norm());
            let ratio = if forecast == 0.0 {
                0.0
            } else {
                reduction / forecast
            };
            region.adapt(&step, norm, reduction, ratio);
            let is_better = ratio >= 1e-4;
            if is_better {
                x = next;
                residuals = candidate;
            }
            let is_still = reduction.abs() <= limits.tolerance && forecast <= limits.tolerance;
            let size = x.component_mul(&scale).norm();
            let end = if (is_still && ratio <= 2.0) || region.radius <= limits.tolerance * size {
                Some(End::Converged)
            } else {
                (evaluations_left <= 1).then_some(End::OutOfPatience)
            };
            if let Some(end) = end {
                if !is_better {
                    problem.set_coordinates(&x);
                }
                return end;
            }
            if is_better {
                break;
            }
        }
    }
}

/// Largest cosine between the residuals and a column of the Jacobian: zero at a minimum.
fn steepest(jacobian: &DMatrix<f64>, residuals: &DVector<f64>) -> f64 {
    let cosine = |column: nalgebra::DVectorView<'_, f64>| {
        let norms = column.norm() * residuals.norm();
        if norms > 0.0 {
            column.dot(residuals).abs() / norms
        } else {
            0.0
        }
    };
    jacobian.column_iter().map(cosine).fold(0.0, f64::max)
}

/// Raises each coordinate's scale to the norm of its column; 1 where nothing depends on it.
fn rescale(scale: &mut DVector<f64>, jacobian: &DMatrix<f64>) {
    for (scale, column) in scale.iter_mut().zip(jacobian.column_iter()) {
        let norm = column.norm();
        *scale = if *scale == 0.0 && norm == 0.0 {
            1.0
        } else {
            scale.max(norm)
        };
    }
}

/// Relative fall of the sum of squares; none is worse than residuals that are not finite.
fn reduction(norm: f64, candidate: f64) -> f64 {
    if candidate.is_finite() {
        1.0 - (candidate / norm).powi(2)
    } else {
        f64::NEG_INFINITY
    }
}

/// Ball in which the linear model is trusted.
#[derive(Debug)]
struct TrustRegion {
    /// In scaled coordinates.
    radius: f64,
    /// Damping of the last step.
    damping: f64,
    /// No step is taken yet.
    is_new: bool,
}

impl TrustRegion {
    /// A large region about coordinates of this scaled norm: the first step sets its size.
    fn new(norm: f64) -> Self {
        const LARGE: f64 = 100.0;
        Self {
            radius: if norm == 0.0 { LARGE } else { LARGE * norm },
            damping: 0.0,
            is_new: true,
        }
    }

    /// Shrinks or grows the region by the success of a step. `norm` is that of the
    /// residuals before it, `ratio` the share of the forecast reduction that came.
    fn adapt(&mut self, step: &Step, norm: f64, reduction: f64, ratio: f64) {
        if self.is_new {
            self.radius = self.radius.min(step.len);
            self.is_new = false;
        }
        if ratio <= 0.25 {
            let slope = -step.slope / norm.powi(2);
            let shrink = if reduction >= 0.0 {
                0.5
            } else {
                // Minimum of the parabola through both sums of squares and the slope.
                (0.5 * slope / (slope + 0.5 * reduction)).max(0.1)
            };
            self.radius = shrink * self.radius.min(10.0 * step.len);
            self.damping /= shrink;
        } else if self.damping == 0.0 || ratio >= 0.75 {
            self.radius = 2.0 * step.len;
            self.damping *= 0.5;
        }
    }
}

/// A step within a region.
struct Step {
    /// What is subtracted from the coordinates.
    coordinates: DVector<f64>,
    /// Its length in scaled coordinates.
    len: f64,
    /// Fall of the sum of squares by the linear model.
    forecast: f64,
    /// Half the slope of the sum of squares along the step, downwards.
    slope: f64,
}

/// The residuals' linear model, in the singular vectors of the scaled Jacobian.
struct LinearModel<'a> {
    scale: &'a DVector<f64>,
    values: DVector<f64>,
    /// Residuals along the left vectors.
    residuals: DVector<f64>,
    /// Right vectors, a row each.
    right: DMatrix<f64>,
}

impl<'a> LinearModel<'a> {
    fn new(mut jacobian: DMatrix<f64>, residuals: &DVector<f64>, scale: &'a DVector<f64>) -> Self {
        for (mut column, scale) in jacobian.column_iter_mut().zip(scale) {
            column /= *scale;
        }
        let columns = jacobian.ncols();
        let svd = jacobian.svd(true, true);
        let residuals = svd
            .u
            .map_or_else(|| DVector::zeros(columns), |u| u.tr_mul(residuals));
        Self {
            scale,
            values: svd.singular_values,
            residuals,
            right: svd
                .v_t
                .unwrap_or_else(|| DMatrix::identity(columns, columns)),
        }
    }

    /// The scaled step with this damping, in the right vectors. Undamped, directions that
    /// change no residual are left out.
    fn damped(&self, damping: f64) -> DVector<f64> {
        let least = self.values.max() * self.values.len() as f64 * f64::EPSILON;
        self.values.zip_map(&self.residuals, |value, residual| {
            if damping == 0.0 && value <= least {
                return 0.0;
            }
            value * residual / (value * value + damping)
        })
    }

    /// The best step in the region, within a tenth of its radius; changes the damping.
    fn step(&self, region: &mut TrustRegion) -> Step {
        let (damping, along) = self.in_region(region.radius, region.damping);
        region.damping = damping;
        let len = along.norm();
        let fall = self.values.component_mul(&along).norm_squared();
        let damped = damping * len * len;
        Step {
            coordinates: self.right.tr_mul(&along).component_div(self.scale),
            len,
            forecast: fall + 2.0 * damped,
            slope: fall + damped,
        }
    }

    /// Damping and step for a radius; the search for the damping begins at `guess`.
    fn in_region(&self, radius: f64, guess: f64) -> (f64, DVector<f64>) {
        /// Largest relative excess of the step over the radius.
        const EXCESS: f64 = 0.1;
        /// Newton's method needs two or three.
        const ITERATIONS: usize = 10;

        let undamped = self.damped(0.0);
        let excess = undamped.norm() - radius;
        if excess <= EXCESS * radius {
            return (0.0, undamped);
        }
        // Newton's correction of the damping, by which a step's length falls to the radius.
        let correction = |along: &DVector<f64>, damping: f64| {
            let len = along.norm();
            let parts = along.zip_map(&self.values, |along, value| {
                (along / len).powi(2) / (value * value + damping)
            });
            (len - radius) / (radius * parts.sum())
        };
        let is_full_rank = self.values.min() > 0.0 && undamped.iter().all(|along| *along != 0.0);
        let mut least = if is_full_rank {
            correction(&undamped, 0.0)
        } else {
            0.0
        };
        let gradient = self.values.component_mul(&self.residuals).norm();
        let mut most = gradient / radius;
        let mut damping = guess.max(least).min(most);
        if damping == 0.0 {
            damping = gradient / undamped.norm();
        }
        for _ in 0..ITERATIONS {
            if damping == 0.0 {
                damping = (1e-3 * most).max(f64::MIN_POSITIVE);
            }
            let along = self.damped(damping);
            let excess = along.norm() - radius;
            if excess.abs() <= EXCESS * radius {
                return (damping, along);
            }
            if excess > 0.0 {
                least = least.max(damping);
            } else {
                most = most.min(damping);
            }
            damping = least.max(damping + correction(&along, damping)).min(most);
        }
        (damping, self.damped(damping))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A problem given by two functions.
    struct Functions<R, J> {
        x: DVector<f64>,
        residuals: R,
        jacobian: J,
    }

    impl<R, J> LeastSquares for Functions<R, J>
    where
        R: Fn(&DVector<f64>) -> Vec<f64>,
        J: Fn(&DVector<f64>) -> Vec<f64>,
    {
        fn coordinates(&self) -> DVector<f64> {
            self.x.clone()
        }

        fn set_coordinates(&mut self, coordinates: &DVector<f64>) {
            self.x.copy_from(coordinates);
        }

        fn residuals(&self) -> Option<DVector<f64>> {
            Some((self.residuals)(&self.x).into())
        }

        fn jacobian(&self) -> Option<DMatrix<f64>> {
            let slopes = (self.jacobian)(&self.x);
            let columns = self.x.len();
            Some(DMatrix::from_row_slice(
                slopes.len() / columns,
                columns,
                &slopes,
            ))
        }
    }

    fn problem<R, J>(x: &[f64], residuals: R, jacobian: J) -> Functions<R, J>
    where
        R: Fn(&DVector<f64>) -> Vec<f64>,
        J: Fn(&DVector<f64>) -> Vec<f64>,
    {
        let x = DVector::from_column_slice(x);
        Functions {
            x,
            residuals,
            jacobian,
        }
    }

    #[track_caller]
    fn assert_near(x: &DVector<f64>, expected: &[f64], tolerance: f64) {
        for (x, expected) in x.iter().zip(expected) {
            assert!((x - expected).abs() <= tolerance, "{x}, not {expected}");
        }
    }

    /// Rosenbrock's valley, from its customary start.
    #[test]
    fn curved_valley_is_followed_to_its_minimum() {
        let mut problem = problem(
            &[-1.2, 1.0],
            |x| vec![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]],
            |x| vec![-20.0 * x[0], 10.0, -1.0, 0.0],
        );
        assert_eq!(minimise(&mut problem, Limits::default()), End::Converged);
        assert_near(&problem.x, &[1.0, 1.0], 1e-12);
    }

    /// Powell's function, whose Jacobian is singular at the minimum.
    #[test]
    fn singular_minimum_is_approached() {
        let (r5, r10) = (5.0_f64.sqrt(), 10.0_f64.sqrt());
        let mut problem = problem(
            &[3.0, -1.0, 0.0, 1.0],
            |x| {
                let (a, b) = (x[1] - 2.0 * x[2], x[0] - x[3]);
                vec![x[0] + 10.0 * x[1], r5 * (x[2] - x[3]), a * a, r10 * b * b]
            },
            |x| {
                let (a, b) = (x[1] - 2.0 * x[2], x[0] - x[3]);
                [
                    [1.0, 10.0, 0.0, 0.0],
                    [0.0, 0.0, r5, -r5],
                    [0.0, 2.0 * a, -4.0 * a, 0.0],
                    [2.0 * r10 * b, 0.0, 0.0, -2.0 * r10 * b],
                ]
                .concat()
            },
        );
        let end = minimise(&mut problem, Limits::default());
        assert_eq!(end, End::Converged);
        assert_near(&problem.x, &[0.0; 4], 1e-6);
    }

    /// A decay with noise, whose residuals are not zero at the minimum; the expected
    /// values are those of a fine grid search.
    #[test]
    fn residuals_that_remain_are_minimised() {
        const MEASURED: [f64; 5] = [2.0, 1.3, 0.7, 0.5, 0.2];
        let curve = |x: &DVector<f64>, i: usize| x[0] * (-x[1] * i as f64).exp();
        let mut problem = problem(
            &[1.0, 3.0],
            |x| (0..5).map(|i| curve(x, i) - MEASURED[i]).collect(),
            |x| {
                let row = |i: usize| {
                    let decay = (-x[1] * i as f64).exp();
                    [decay, -(i as f64) * x[0] * decay]
                };
                (0..5).flat_map(row).collect()
            },
        );
        assert_eq!(minimise(&mut problem, Limits::default()), End::Converged);
        let slope = steepest(&problem.jacobian().unwrap(), &problem.residuals().unwrap());
        assert!(slope < 1e-7, "{slope}");
        let squares = problem.residuals().unwrap().norm_squared();
        for change in [[1e-4, 0.0], [-1e-4, 0.0], [0.0, 1e-4], [0.0, -1e-4]] {
            let x = &problem.x + DVector::from_column_slice(&change);
            let there: f64 = (problem.residuals)(&x).iter().map(|r| r * r).sum();
            assert!(
                there > squares,
                "{there} at {change:?}, not above {squares}"
            );
        }
    }

    /// Only the sum of both is seen: the search moves both alike, and ends.
    #[test]
    fn direction_without_information_is_left_alone() {
        let mut problem = problem(
            &[5.0, 1.0],
            |x| vec![x[0] + x[1] - 2.0, 0.1, 0.0],
            |_| vec![1.0, 1.0, 0.0, 0.0, 0.0, 0.0],
        );
        assert_eq!(minimise(&mut problem, Limits::default()), End::Converged);
        assert_near(&problem.x, &[3.0, -1.0], 1e-9);
    }

    #[test]
    fn steps_stay_in_their_region_and_longer_ones_fall_further() {
        let jacobian = DMatrix::from_row_slice(3, 2, &[3.0, 1.0, 0.0, 1e-3, 1.0, 2.0]);
        let residuals = DVector::from_column_slice(&[1.0, -2.0, 3.0]);
        let scale = DVector::from_element(2, 1.0);
        let model = LinearModel::new(jacobian.clone(), &residuals, &scale);
        let mut last = residuals.norm();
        for radius in [0.01, 0.1, 0.5] {
            let mut region = TrustRegion {
                radius,
                damping: 0.0,
                is_new: false,
            };
            let step = model.step(&mut region);
            assert!((0.9..=1.1).contains(&(step.len / radius)), "{}", step.len);
            let left = (&residuals - &jacobian * &step.coordinates).norm();
            let fall = residuals.norm_squared() - left.powi(2);
            assert!((fall - step.forecast).abs() < 1e-12, "{fall}");
            assert!(left < last, "{left}, not below {last}");
            last = left;
        }
    }

    #[test]
    fn evaluations_are_bounded_and_failures_end_the_search() {
        let mut valley = problem(
            &[-1.2, 1.0],
            |x| vec![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]],
            |x| vec![-20.0 * x[0], 10.0, -1.0, 0.0],
        );
        let brief = Limits {
            patience: 2,
            ..Limits::default()
        };
        assert_eq!(minimise(&mut valley, brief), End::OutOfPatience);
        let mut broken = problem(&[1.0], |x| vec![x[0]], |_| vec![f64::NAN]);
        assert_eq!(minimise(&mut broken, Limits::default()), End::NotFinite);
        let mut broken = problem(&[1.0], |_| vec![f64::NAN], |_| vec![1.0]);
        assert_eq!(minimise(&mut broken, Limits::default()), End::NotFinite);
    }
}
