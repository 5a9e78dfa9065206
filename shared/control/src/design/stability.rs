//! Stability of a discrete closed loop.
//!
//! The loop is stable if the largest eigenvalue of its state matrix lies inside the unit
//! circle. Powers of the matrix, squared again and again, leave nothing but the
//! directions that belong to that eigenvalue, or to it and its conjugate; what
//! the matrix does to such a direction shows it. No iteration that may fail to
//! converge, and twenty products.

use crate::real::Real;
use nalgebra::{ComplexField, SMatrix, SVector};

/// One of a pair `re + i im`, `re - i im`, or a real one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eigenvalue<T> {
    /// Real part.
    pub re: T,
    /// Imaginary part, not negative.
    pub im: T,
}

impl<T: Real> Eigenvalue<T> {
    /// Distance from 0: what a deviation grows by each period, in the long run.
    pub fn radius(&self) -> T {
        (self.re * self.re + self.im * self.im).sqrt()
    }
}

/// 2^24 periods: what is smaller by one part in a million is gone.
const SQUARINGS: u8 = 24;

/// The eigenvalue of largest magnitude; `None` if an entry is not finite.
pub fn dominant<T: Real, const N: usize>(a: &SMatrix<T, N, N>) -> Option<Eigenvalue<T>> {
    if !a.iter().all(ComplexField::is_finite) {
        return None;
    }
    let mut power = *a;
    for _ in 0..SQUARINGS {
        let norm = power.norm();
        if norm <= T::zero() {
            return Some(Eigenvalue::real(T::zero()));
        }
        power /= norm;
        power *= power;
    }
    let columns = power.column_iter();
    let longest = columns.max_by(|a, b| {
        let (a, b) = (a.norm_squared(), b.norm_squared());
        a.partial_cmp(&b).unwrap_or(core::cmp::Ordering::Equal)
    })?;
    let mut v = SVector::<T, N>::zeros();
    v.iter_mut()
        .zip(longest.iter())
        .for_each(|(to, from)| *to = *from);
    let (w, z) = (a * v, a * (a * v));
    // z = p w + q v, so that the eigenvalue solves x^2 = p x + q.
    let (vv, vw, ww) = (v.dot(&v), v.dot(&w), w.dot(&w));
    if vv <= T::zero() {
        return Some(Eigenvalue::real(T::zero()));
    }
    let determinant = vv * ww - vw * vw;
    // Parallel but for rounding.
    if determinant <= vv * ww * T::default_epsilon() * T::lit(64.0) {
        return Some(Eigenvalue::real(vw / vv));
    }
    let (vz, wz) = (v.dot(&z), w.dot(&z));
    let p = (wz * vv - vz * vw) / determinant;
    let q = (vz * ww - wz * vw) / determinant;
    let half = p * T::lit(0.5);
    let square = half * half + q;
    Some(if square < T::zero() {
        Eigenvalue {
            re: half,
            im: (-square).sqrt(),
        }
    } else {
        Eigenvalue::real(half + square.sqrt().copysign(half))
    })
}

impl<T: Real> Eigenvalue<T> {
    fn real(re: T) -> Self {
        Self { re, im: T::zero() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix2, Matrix4};

    #[test]
    fn agrees_with_the_schur_decomposition() {
        let mut state = 1_u64;
        let mut next = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 40) as f64 / f64::from(1 << 23) - 1.0
        };
        for _ in 0..500 {
            let a = Matrix4::<f64>::from_fn(|_, _| next());
            let all = a.complex_eigenvalues();
            let radius = all.iter().map(|x| x.re.hypot(x.im)).fold(0.0, f64::max);
            let found = dominant(&a).unwrap();
            assert!((found.radius() - radius).abs() < 1e-5 * radius, "{a}");
            let close = dominant(&a.cast::<f32>()).unwrap();
            assert!(
                (f64::from(close.radius()) - radius).abs() < 1e-2 * radius,
                "{a}"
            );
        }
    }

    #[test]
    fn real_pairs_and_what_is_no_matrix() {
        let pair = Matrix2::new(0.0, -0.5, 0.5, 0.0);
        assert_eq!(dominant(&pair), Some(Eigenvalue { re: 0.0, im: 0.5 }));
        let real = Matrix2::new(-1.5, 0.0, 0.0, 0.2);
        assert_eq!(dominant(&real), Some(Eigenvalue { re: -1.5, im: 0.0 }));
        let none = Matrix2::<f64>::zeros();
        assert_eq!(dominant(&none), Some(Eigenvalue { re: 0.0, im: 0.0 }));
        assert_eq!(dominant(&(pair * f64::NAN)), None);
    }
}
