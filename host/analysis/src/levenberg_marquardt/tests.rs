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
