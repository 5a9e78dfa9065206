//! Speeds and accelerations at waypoints.
//!
//! Of all motions that pass given angles at given times the one with the least
//! integral of squared jerk is a spline of quintics whose jerk and snap (third and
//! fourth derivative) are continuous at the waypoints too. With v and a the speeds
//! and accelerations at three successive knots -, 0 and +, h and H the times before
//! and after the middle one, and d and D the distances, that means
//!
//! ```text
//! jerk    (-24 v- - 36 v)/h^2 + (36 v + 24 v+)/H^2 + (-3 a- + 9 a)/h + (9 a - 3 a+)/H
//!             = 60 (D/H^3 - d/h^3)
//! snap    (-168 v- - 192 v)/h^3 - (192 v + 168 v+)/H^3 + (-24 a- + 36 a)/h^2 - (36 a - 24 a+)/H^2
//!             = -360 (D/H^4 + d/h^4)
//! ```
//!
//! Two equations per inner knot, the unknowns of neighbours only: block
//! tridiagonal with blocks of 2 x 2, the same for both joints, which are the two
//! columns of the unknown and of the right-hand side. It is solved by elimination
//! without exchanges: up to the order of rows it is the Hessian of the integral, and
//! that is positive definite. Rows are multiplied by powers of h, so that they stay
//! of one size.

use super::WAYPOINTS_MAX;
use crate::real::Real;
use crate::trajectory::Reference;
use heapless::Vec;
use nalgebra::{Matrix2, RowVector2, Vector2};

/// A knot of the spline: a reference and its time in s since the start.
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "snapshot", serde(bound = "T: crate::snapshot::Number"))]
pub(super) struct Knot<T> {
    pub(super) at_s: T,
    pub(super) reference: Reference<T>,
}

/// The knots of a spline, the start included.
pub(super) type Knots<T> = Vec<Knot<T>, { WAYPOINTS_MAX + 1 }>;

/// Fills in speeds and accelerations of all but the first and the last knot.
///
/// `None` if the times are so uneven that the equations have no solution in
/// this precision.
pub(super) fn smooth<T: Real>(knots: &mut Knots<T>) -> Option<()> {
    // Forward: of each inner knot, x = constant - coupling * x+.
    let mut eliminated: Vec<(Matrix2<T>, Matrix2<T>), WAYPOINTS_MAX> = Vec::new();
    let mut before = knots.first().map(|first| unknown(&first.reference))?;
    let mut coupling_before = Matrix2::zeros();
    for three in knots.windows(3) {
        let [a, b, c] = three else { continue };
        let row = Row::about(a, b, c);
        let pivot = (row.diagonal - row.lower * coupling_before).try_inverse()?;
        before = pivot * (row.right - row.lower * before);
        coupling_before = pivot * row.upper;
        eliminated.push((before, coupling_before)).ok()?;
    }
    // Backward, from the last knot.
    let mut after = knots.last().map(|last| unknown(&last.reference))?;
    let inner = knots.iter_mut().skip(1).zip(&eliminated);
    for (knot, (constant, coupling)) in inner.rev() {
        after = constant - coupling * after;
        knot.reference.dq = after.row(0).transpose();
        knot.reference.ddq = after.row(1).transpose();
    }
    Some(())
}

/// Speeds above accelerations; a column per joint.
fn unknown<T: Real>(reference: &Reference<T>) -> Matrix2<T> {
    Matrix2::from_rows(&[reference.dq.transpose(), reference.ddq.transpose()])
}

/// Continuity of jerk and snap at one knot.
struct Row<T> {
    lower: Matrix2<T>,
    diagonal: Matrix2<T>,
    upper: Matrix2<T>,
    right: Matrix2<T>,
}

impl<T: Real> Row<T> {
    fn about(before: &Knot<T>, at: &Knot<T>, after: &Knot<T>) -> Self {
        let lit = T::lit;
        let h = at.at_s - before.at_s;
        // h/H. The jerk's row is multiplied by h^2, that of snap by h^3.
        let r = h / (after.at_s - at.at_s);
        let (r2, r3) = (r * r, r * r * r);
        let over_h = |d: Vector2<T>| -> RowVector2<T> { (d / h).transpose() };
        let d = over_h(at.reference.q - before.reference.q);
        let d_after = over_h(after.reference.q - at.reference.q);
        Self {
            lower: Matrix2::new(lit(-24.0), lit(-3.0) * h, lit(-168.0), lit(-24.0) * h),
            diagonal: Matrix2::new(
                lit(36.0) * (r2 - T::one()),
                lit(9.0) * h * (T::one() + r),
                lit(-192.0) * (T::one() + r3),
                lit(36.0) * h * (T::one() - r2),
            ),
            upper: Matrix2::new(
                lit(24.0) * r2,
                lit(-3.0) * h * r,
                lit(-168.0) * r3,
                lit(24.0) * h * r2,
            ),
            right: Matrix2::from_rows(&[
                (d_after * r3 - d) * lit(60.0),
                (d_after * (r3 * r) + d) * lit(-360.0),
            ]),
        }
    }
}
