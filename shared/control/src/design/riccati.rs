//! The discrete algebraic Riccati equation, by structure-preserving doubling.
//!
//! For `x(k+1) = A x(k) + B u(k)` and the cost `sum of x'Q x + u'R u`, the
//! optimal feedback is `u = -K x` with
//!
//! ```text
//! K = (R + B'PB)^-1 B'PA       P = Q + A'PA - A'PB (R + B'PB)^-1 B'PA
//! ```
//!
//! The doubling algorithm iterates on `A_0 = A`, `G_0 = B R^-1 B'`, `H_0 = Q`:
//!
//! ```text
//! W = I + G H      A <- A W^-1 A     G <- G + A W^-1 G A'     H <- H + A' H W^-1 A
//! ```
//!
//! H grows to P, and A falls to zero as the closed loop does over 2^k periods.
//! So a vanishing A is both the sign of convergence and the proof that K
//! stabilises the model; that, and not a small change of H, ends the iteration.
//! Ten to fifteen iterations are usual, more for shorter periods.

use crate::real::Real;
use nalgebra::{ComplexField, SMatrix};

use super::linear_solve;

/// Solution of the equation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution<T, const N: usize, const M: usize> {
    /// The gain K of `u = -K x`.
    pub gain: SMatrix<T, M, N>,
    /// The cost P: starting at x costs `x'P x`.
    pub cost: SMatrix<T, N, N>,
}

/// Reason why there is no gain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error {
    /// A model or a weight has an entry that is not finite.
    NotFinite,
    /// R, or a matrix that R should keep regular, has no inverse: a torque that
    /// costs nothing, or weights that are not positive.
    Singular,
    /// The closed loop did not decay: the input cannot stabilise the model, or
    /// Q does not see a mode that grows.
    NoConvergence,
}

/// More than `f32` and `f64` can use: 2^40 periods.
const MOST_ITERATIONS: u8 = 40;

/// Solves the equation for N states and M inputs; Q and R symmetric, Q
/// positive semidefinite, R positive definite.
///
/// # Errors
///
/// See [`Error`]. No gain is returned that does not stabilise the model.
pub fn solve<T: Real, const N: usize, const M: usize>(
    a: &SMatrix<T, N, N>,
    b: &SMatrix<T, N, M>,
    q: &SMatrix<T, N, N>,
    r: &SMatrix<T, M, M>,
) -> Result<Solution<T, N, M>, Error> {
    if !(is_finite(a) && is_finite(b) && is_finite(q) && is_finite(r)) {
        return Err(Error::NotFinite);
    }
    let [weighted] = linear_solve::solve(r, [&b.transpose()]).ok_or(Error::Singular)?;
    let mut power = *a;
    let mut g = symmetric(b * weighted);
    let mut h = *q;
    for _ in 0..MOST_ITERATIONS {
        let w = SMatrix::identity() + g * h;
        let [w_a, w_g] = linear_solve::solve(&w, [&power, &g]).ok_or(Error::Singular)?;
        g = symmetric(g + power * w_g * power.transpose());
        h = symmetric(h + power.transpose() * h * w_a);
        power *= w_a;
        if !(is_finite(&h) && is_finite(&power)) {
            return Err(Error::NoConvergence);
        }
        // What is still to be added to H is of the order of its square.
        if power.norm() <= T::default_epsilon() {
            return gain(a, b, r, h);
        }
    }
    Err(Error::NoConvergence)
}

fn gain<T: Real, const N: usize, const M: usize>(
    a: &SMatrix<T, N, N>,
    b: &SMatrix<T, N, M>,
    r: &SMatrix<T, M, M>,
    cost: SMatrix<T, N, N>,
) -> Result<Solution<T, N, M>, Error> {
    let b_cost = b.transpose() * cost;
    let [gain] = linear_solve::solve(&(r + b_cost * b), [&(b_cost * a)]).ok_or(Error::Singular)?;
    if is_finite(&gain) {
        Ok(Solution { gain, cost })
    } else {
        Err(Error::Singular)
    }
}

fn is_finite<T: Real, const R: usize, const C: usize>(m: &SMatrix<T, R, C>) -> bool {
    m.iter().all(ComplexField::is_finite)
}

/// Rounding must not make G and H drift from symmetry.
fn symmetric<T: Real, const N: usize>(m: SMatrix<T, N, N>) -> SMatrix<T, N, N> {
    (m + m.transpose()) * T::lit(0.5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix1, Matrix2, Vector2};

    #[test]
    fn the_golden_ratio() {
        // a = b = q = r = 1: P^2 = P + 1.
        let one = Matrix1::new(1.0_f64);
        let solution = solve(&one, &one, &one, &one).unwrap();
        let golden = f64::midpoint(1.0, 5.0_f64.sqrt());
        assert!((solution.cost.x - golden).abs() < 1e-15);
        assert!((solution.gain.x - 1.0 / golden).abs() < 1e-15);
    }

    #[test]
    fn every_error_has_its_reason() {
        let a = Matrix2::new(1.1, 0.1, 0.0, 0.5);
        let b = Vector2::new(0.0, 1.0);
        let (q, r) = (Matrix2::identity(), Matrix1::new(1.0));
        assert!(solve(&a, &b, &q, &r).is_ok());
        let beyond_reach = Vector2::new(0.0, 0.0);
        assert_eq!(solve(&a, &beyond_reach, &q, &r), Err(Error::NoConvergence));
        // Nothing asks for the growing mode to be stopped.
        let blind = Matrix2::zeros();
        assert_eq!(solve(&a, &b, &blind, &r), Err(Error::NoConvergence));
        assert_eq!(solve(&a, &b, &q, &Matrix1::new(0.0)), Err(Error::Singular));
        let broken = a * f64::NAN;
        assert_eq!(solve(&broken, &b, &q, &r), Err(Error::NotFinite));
    }
}
