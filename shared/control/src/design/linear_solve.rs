//! Linear equations, by Gaussian elimination with partial pivoting.
//!
//! The LU decomposition of nalgebra, computed in the same order and so to the
//! same bits, but over rows that are split off one by one: nothing is indexed by
//! a number that is only known at run time, so that there is no panic to be
//! reached whatever the weights are that a host sends.

use core::{array, mem};

use crate::real::Real;
use nalgebra::SMatrix;

/// One equation: the left side, and as many right sides as there are.
struct Row<T, const N: usize, const M: usize, const K: usize> {
    left: [T; N],
    right: [[T; M]; K],
}

/// The X of `A X = B` for each of the `right` sides B; `None` if A is singular.
pub(crate) fn solve<T: Real, const N: usize, const M: usize, const K: usize>(
    a: &SMatrix<T, N, N>,
    right: [&SMatrix<T, N, M>; K],
) -> Option<[SMatrix<T, N, M>; K]> {
    // Matrices are stored by columns: those of the transpose are the rows.
    let a = a.transpose().data.0;
    let b = right.map(|b| b.transpose().data.0);
    let mut rows: [Row<T, N, M, K>; N] = array::from_fn(|i| Row {
        left: a[i],
        right: array::from_fn(|k| b[k][i]),
    });
    eliminate(&mut rows)?;
    substitute(&mut rows);
    Some(array::from_fn(|k| {
        let x: [[T; M]; N] = array::from_fn(|i| rows[i].right[k]);
        SMatrix::<T, M, N>::from(x).transpose()
    }))
}

/// Makes the left sides upper triangular. What is under the diagonal is left
/// as it comes.
fn eliminate<T: Real, const N: usize, const M: usize, const K: usize>(
    rows: &mut [Row<T, N, M, K>; N],
) -> Option<()> {
    let mut remaining = rows.as_mut_slice();
    for column in 0..N {
        let (first, below) = mem::take(&mut remaining).split_first_mut()?;
        let mut largest = first.left[column].abs();
        let mut pivot = None;
        for row in below.iter_mut() {
            let magnitude = row.left[column].abs();
            if magnitude > largest {
                largest = magnitude;
                pivot = Some(row);
            }
        }
        if let Some(pivot) = pivot {
            mem::swap(first, pivot);
        }
        let diagonal = first.left[column];
        if diagonal == T::zero() {
            return None;
        }
        let inverse = T::one() / diagonal;
        for row in below.iter_mut() {
            let factor = row.left[column] * inverse;
            let left = row.left.iter_mut().zip(&first.left);
            for (to, from) in left.skip(column + 1) {
                *to -= *from * factor;
            }
            subtract(&mut row.right, &first.right, factor);
        }
        remaining = below;
    }
    Some(())
}

/// Turns the right sides into the solution, from the last row up.
fn substitute<T: Real, const N: usize, const M: usize, const K: usize>(
    rows: &mut [Row<T, N, M, K>; N],
) {
    let mut remaining = rows.as_mut_slice();
    for column in (0..N).rev() {
        let Some((last, above)) = mem::take(&mut remaining).split_last_mut() else {
            return;
        };
        let diagonal = last.left[column];
        for value in last.right.as_flattened_mut() {
            *value /= diagonal;
        }
        for row in above.iter_mut() {
            subtract(&mut row.right, &last.right, row.left[column]);
        }
        remaining = above;
    }
}

fn subtract<T: Real, const M: usize, const K: usize>(
    to: &mut [[T; M]; K],
    from: &[[T; M]; K],
    factor: T,
) {
    for (to, from) in to.as_flattened_mut().iter_mut().zip(from.as_flattened()) {
        *to -= *from * factor;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix2, Matrix4, Matrix4x2};

    /// Reproducible numbers from -1 to 1.
    fn numbers() -> impl FnMut() -> f32 {
        let mut state = 1_u64;
        move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 40) as f32 / (1 << 23) as f32 - 1.0
        }
    }

    #[test]
    fn agrees_with_the_lu_decomposition_to_the_bit() {
        let mut next = numbers();
        for round in 0..500 {
            let mut a = Matrix4::from_fn(|_, _| next());
            if round % 3 == 0 {
                // Equal magnitudes: which row is the pivot then?
                a = a.map(|x| (x * 2.0).round());
            }
            let b = [0; 2].map(|_| Matrix4x2::from_fn(|_, _| next()));
            let lu = a.lu();
            let expected = lu.solve(&b[0]).zip(lu.solve(&b[1]));
            let got = solve(&a, [&b[0], &b[1]]).map(|[x, y]| (x, y));
            let bits = |(x, y): (Matrix4x2<f32>, Matrix4x2<f32>)| {
                (x.map(f32::to_bits), y.map(f32::to_bits))
            };
            assert_eq!(got.map(bits), expected.map(bits), "{a}");
        }
    }

    #[test]
    fn a_singular_matrix_has_no_solution() {
        let ones = Matrix2::repeat(1.0_f64);
        assert_eq!(solve(&ones, [&ones]), None);
        assert_eq!(solve(&Matrix2::zeros(), [&ones]), None);
    }
}
